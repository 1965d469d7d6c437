//! The command line: each subcommand parses, runs, prints.

mod add;
mod arguments;
mod batch;
#[cfg(feature = "development")]
mod bench;
#[cfg(feature = "development")]
mod calibrate;
mod calibrate_imu;
mod calibration_summary;
mod command_tree;
mod compare;
mod comparison_summary;
mod completions;
mod convert;
mod demo;
mod diagnose;
mod effects;
mod error_table;
mod export;
pub mod files;
mod fit;
mod fleet;
mod formats;
mod guide;
mod history;
mod inspect;
mod man;
mod noise;
mod numbers;
mod output;
mod plan;
mod record;
mod refinement;
mod replay;
mod report;
#[cfg(feature = "workbench")]
mod serve;
mod simulate;
mod simulate_case;
#[cfg(feature = "development")]
mod table;
mod temperature_tables;
mod undo;
mod units;
mod world;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use output::Failure;

/// Models the bias drift of MEMS gyros and accelerometers from a log, and removes it in firmware
#[derive(Debug, Parser)]
#[command(name = "fos", version, arg_required_else_help = true, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Simulate(simulate::Simulate),
    Noise(noise::Noise),
    Plan(plan::Plan),
    CalibrateImu(calibrate_imu::CalibrateImu),
    #[cfg(feature = "development")]
    Table(table::Table),
    Fit(fit::Fit),
    Compare(compare::Compare),
    Diagnose(diagnose::Diagnose),
    Add(add::Add),
    Undo(undo::Undo),
    History(history::History),
    Effects(effects::Effects),
    Formats(formats::Formats),
    Convert(convert::Convert),
    Batch(batch::Batch),
    Fleet(fleet::Fleet),
    #[cfg(feature = "development")]
    Calibrate(calibrate::Calibrate),
    Export(export::Export),
    Inspect(inspect::Inspect),
    Replay(replay::Replay),
    Record(record::Record),
    Report(report::Report),
    #[cfg(feature = "workbench")]
    Serve(serve::Serve),
    #[cfg(feature = "development")]
    Bench(bench::Bench),
    Completions(completions::Completions),
    Man(man::Man),
}

/// Short help: the most common subcommands.
const START: &str = "\
fos models the bias drift of MEMS gyros and accelerometers from a log.

  fos diagnose LOG             find out why a sensor drifts
  fos fit LOG -o unit.json     fit a model for the device
  fos calibrate-imu LOG        bias, sensitivity and cross-axis, from hand-turned orientations
  fos noise LOG                noise values for a filter, from a log at rest

`fos demo` shows everything on simulated data, `fos --help` lists all commands.";

/// Subcommands by purpose.
const GROUPS: &[(&str, &[&str])] = &[
    ("Start here", &["demo", "diagnose", "fit", "calibrate-imu", "noise", "serve"]),
    ("Improve a model", &["compare", "add", "undo", "history", "report", "effects"]),
    ("Device", &["export", "inspect", "replay", "record"]),
    ("Logs", &["plan", "formats", "convert", "simulate"]),
    ("Many devices and cases", &["fleet", "batch"]),
    ("Checks of fos itself", &["calibrate", "table", "bench"]),
    ("Shell", &["completions", "man"]),
];

/// Subcommands and their arguments, as defined for clap.
pub fn command() -> clap::Command {
    let program = Cli::command();
    let groups: String = GROUPS
        .iter()
        .map(|(title, names)| {
            let known = names.iter().filter_map(|name| program.find_subcommand(name));
            let line = |one: &clap::Command| {
                let about = one.get_about().map(ToString::to_string).unwrap_or_default();
                format!("  {:<14} {about}\n", one.get_name())
            };
            let lines: String = known.map(line).collect();
            // built without the feature `development`, a group is empty
            if lines.is_empty() { lines } else { format!("{title}:\n{lines}\n") }
        })
        .collect();
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}\n\n`fos help COMMAND` explains a command"
    );
    program.help_template(template)
}

/// All subcommands, including nested ones, with the words that call them: `fleet`, `fleet report`.
pub fn subcommands() -> Vec<(String, clap::Command)> {
    command_tree::subcommands_of(&command())
}

/// Expected lifetime of the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lifetime {
    /// Ends with its work.
    UntilDone,
    /// Ends on request: a workbench.
    UntilEnded,
}

/// Calls `prepare`, parses the arguments and runs the subcommand. Exit code 0: success; 1: failure; 2: wrong usage.
pub fn run(prepare: impl FnOnce(Lifetime)) -> ExitCode {
    // The derived type accepts everything that its own description accepts.
    let parsed = command().try_get_matches().and_then(|matches| {
        let command = Cli::from_arg_matches(&matches)?.command;
        Ok((matches, command))
    });
    let (matches, command) = match parsed {
        Ok(parsed) => parsed,
        Err(answer) => return answer_of_clap(&answer),
    };
    prepare(match command {
        #[cfg(feature = "workbench")]
        Command::Serve(_) => Lifetime::UntilEnded,
        _ => Lifetime::UntilDone,
    });
    match run_checked(&matches, command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let all = subcommands();
            let arguments = all.iter().flat_map(|(_, subcommand)| subcommand.get_arguments());
            output::print_error(&output::with_flags(&output::in_words(&failure), arguments));
            ExitCode::FAILURE
        }
    }
}

fn run_checked(matches: &ArgMatches, command: Command) -> Result<(), Failure> {
    let all = self::command();
    let (mut subcommand, mut given) = (&all, matches);
    while let Some((name, below)) = given.subcommand()
        && let Some(named) = subcommand.find_subcommand(name)
    {
        (subcommand, given) = (named, below);
        files::check(subcommand, given)?;
    }
    match command {
        Command::Demo(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Noise(command) => command.run(),
        Command::CalibrateImu(command) => command.run(),
        #[cfg(feature = "development")]
        Command::Table(command) => command.run(),
        Command::Fit(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Diagnose(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Add(command) => command.run(),
        Command::Undo(command) => command.run(),
        Command::History(command) => command.run(),
        Command::Effects(command) => command.run(),
        Command::Formats(command) => command.run(),
        Command::Convert(command) => command.run(),
        Command::Batch(command) => command.run(),
        Command::Fleet(command) => command.run(),
        #[cfg(feature = "development")]
        Command::Calibrate(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Replay(command) => command.run(),
        Command::Record(command) => command.run(),
        Command::Report(command) => command.run(),
        #[cfg(feature = "workbench")]
        Command::Serve(command) => command.run(),
        #[cfg(feature = "development")]
        Command::Bench(command) => command.run(),
        Command::Completions(command) => command.run(all),
        Command::Man(command) => command.run(all),
    }
}

/// Prints help, whose text is trusted, as clap formats it; an error repeats arguments and is made visible like any other.
fn answer_of_clap(answer: &clap::Error) -> ExitCode {
    if std::env::args_os().len() <= 1 {
        output::print(format_args!("{START}\n"));
    } else if answer.use_stderr() && answer.kind() != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let text = answer.render().to_string();
        output::print_error(&text.trim_start_matches("error: ").trim_end());
    } else if answer.print().is_err() {
        return ExitCode::FAILURE;
    }
    // Exit codes of Unix have eight bits.
    ExitCode::from(answer.exit_code() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_subcommand_is_in_one_group_of_the_help() {
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
        grouped.sort_unstable();
        let mut all: Vec<String> =
            subcommands().into_iter().map(|(words, _)| words).filter(|words| !words.contains(' ')).collect();
        all.sort_unstable();
        if cfg!(all(feature = "development", feature = "workbench")) {
            assert_eq!(grouped, all);
        }
    }
}
