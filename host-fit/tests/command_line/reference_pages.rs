//! Reference pages generated from the program: docs/command-line.md and docs/effects.md.

use clap::{Arg, ArgAction, Command};
use fos_diagnose::effects::{Band, Effect, Library};
use fos_testkit::page;

use crate::effect_pictures::picture;

/// Spelling of an argument: `--axis AXIS`, `-o, --output OUTPUT`, or `LOG`.
fn spelled(argument: &Arg) -> String {
    let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
    let names = argument.get_value_names().unwrap_or_default();
    let values = names.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    let flags =
        [argument.get_short().map(|s| format!("-{s}")), argument.get_long().map(|l| format!("--{l}"))];
    let flags: Vec<String> = flags.into_iter().flatten().collect();
    match (flags.is_empty(), takes_value) {
        (true, _) if values.is_empty() => argument.get_id().to_string().to_uppercase(),
        (true, _) => values,
        (false, true) => format!("{} {values}", flags.join(", ")),
        (false, false) => flags.join(", "),
    }
}

fn line_of(argument: &Arg) -> String {
    let help = argument.get_help().map(|help| help.to_string().replace('\n', " ")).unwrap_or_default();
    let mut line = format!("- `{}`: {}", spelled(argument), help.trim_end_matches('.'));
    let default: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let is_flag = !matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
    let choices: Vec<String> = match is_flag {
        true => Vec::new(),
        false => {
            argument.get_possible_values().iter().map(|value| format!("`{}`", value.get_name())).collect()
        }
    };
    if !choices.is_empty() {
        line += &format!(". One of {}", choices.join(", "));
    }
    if !is_flag && default.iter().any(|value| !value.is_empty()) {
        line += &format!(". Default: `{}`", default.join(" "));
    }
    line + "\n"
}

/// Returns true for an option common to all commands that read logs.
fn is_of_reading(argument: &Arg) -> bool {
    ["columns", "map_file", "format", "topic", "rate_hz", "strict", "keep_moved"]
        .contains(&argument.get_id().as_str())
}

fn reads_a_log(command: &Command) -> bool {
    command.get_arguments().any(|one| one.get_id() == "keep_moved")
}

fn section(words: &str, command: &Command) -> String {
    let text = |text: Option<&clap::builder::StyledStr>| text.map(ToString::to_string).unwrap_or_default();
    let about = text(command.get_long_about().or(command.get_about()));
    let example = text(command.get_after_help());
    let example = example.strip_prefix("Example: ").expect("an example");
    let example = example.lines().map(str::trim).collect::<Vec<_>>().join("\n");
    let mut section = format!("## fos {words}\n\n{about}\n\n```sh\n{example}\n```\n\n");
    let reads_a_log = reads_a_log(command);
    let is_shown =
        |one: &&Arg| !one.is_hide_set() && one.get_id() != "help" && !(reads_a_log && is_of_reading(one));
    section.extend(command.get_arguments().filter(is_shown).map(line_of));
    if reads_a_log {
        section += "- the [options for reading a log](#options-for-reading-a-log)\n";
    }
    section + "\n"
}

#[test]
fn the_page_of_the_command_line_lists_every_subcommand_and_option() {
    let all = host_fit::cli::subcommands();
    let (_, reader) =
        all.iter().find(|(_, command)| reads_a_log(command)).expect("a command that reads logs");
    let mut text = String::from("## Options for reading a log\n\n");
    text.extend(reader.get_arguments().filter(|one| is_of_reading(one)).map(line_of));
    text += "\n";
    text.extend(all.iter().map(|(words, command)| section(words, command)));
    page::holds("command-line.md", "<!-- commands -->\n", "<!-- end of commands -->", &text);
}

fn entry(effect: &Effect) -> String {
    let mut text =
        format!("### {}\n\n`{}`\n\n{}\n\n", capitalised(&effect.name), effect.id, effect.mechanism);
    let file = format!("figures/effects/{}.svg", effect.id);
    page::file_holds(&file, &picture(effect));
    text += &format!("![Error against its input or time: {}]({file})\n\n", effect.name);
    let mut row = |title: &str, content: &str| {
        if !content.is_empty() {
            text += &format!("- **{title}**: {}\n", content.replace('|', "\\|"));
        }
    };
    row("error", &format!("`{}`", effect.equation));
    let terms: Vec<String> = effect.terms.iter().map(|term| format!("`{}`", term.regressor)).collect();
    row("regressors", &terms.join(", "));
    if let Some(parameter) = &effect.parameter {
        let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
        row("parameter", &format!("`{}`, {} to {}{unit}", parameter.name, parameter.low, parameter.high));
    }
    row("typical size", &effect.typical_size);
    row("source", &effect.source);
    row("signature in a plot", &effect.gives_away);
    row("experiment", &effect.experiment);
    row("cost on the device", &effect.device);
    if !effect.confused_with.is_empty() {
        text += "- **confused with**\n";
        for rival in &effect.confused_with {
            text += &format!("  - `{}`: {}\n", rival.effect, rival.separate);
        }
    }
    text + "\n"
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[test]
fn the_page_of_effects_lists_the_whole_library() {
    let library = Library::built_in();
    let bands = [
        (Band::Slow, "## Slow error: drift of the bias"),
        (Band::Wide, "## Broadband error: in the samples"),
        (Band::Data, "## Defects of the data"),
        (Band::Stochastic, "## Stochastic error"),
    ];
    let mut text = String::new();
    for (band, title) in bands {
        text += &format!("{title}\n\n");
        text.extend(library.effects().iter().filter(|effect| effect.band == band).map(entry));
    }
    page::holds("effects.md", "<!-- effects -->\n", "<!-- end of effects -->", &text);
}
