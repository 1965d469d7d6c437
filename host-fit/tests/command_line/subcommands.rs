//! Requirements on every subcommand: an example, JSON, a manual page, completion; and plain output without a terminal.

use crate::session::{done, fails};
use crate::sources::sources;

/// Subcommands listed in the help, including nested ones.
fn subcommands() -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let help = done(folder.path(), &["--help"]);
    assert!(help.lines().all(|line| line.len() <= 100), "{help}");
    let listed = help.lines().take_while(|line| *line != "Options:").filter(|line| line.starts_with("  "));
    let mut names: Vec<&str> = listed.filter_map(|line| line.split_whitespace().next()).collect();
    names.sort_unstable();
    let all: Vec<String> = host_fit::cli::subcommands().into_iter().map(|(words, _)| words).collect();
    let mut known: Vec<&str> = all.iter().map(String::as_str).filter(|words| !words.contains(' ')).collect();
    known.sort_unstable();
    assert_eq!(names, known);
    all
}

#[test]
fn every_subcommand_has_an_example_and_speaks_json() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in subcommands() {
        let help = done(folder.path(), &name.split(' ').chain(["--help"]).collect::<Vec<_>>());
        assert!(help.contains("Example: ") && help.contains(&format!("fos {name}")), "{name}: {help}");
        // a completion script and a server have no JSON output
        let has_none = ["completions", "serve"].contains(&name.as_str());
        assert_eq!(help.contains("--json"), !has_none, "{name}");
    }
    let printed = done(folder.path(), &["simulate", "unit.csv", "--minutes", "0.1", "--json"]);
    let printed: serde_json::Value = serde_json::from_str(&printed).expect("JSON and nothing else");
    assert_eq!(printed[0]["path"], "unit.csv");
}

#[test]
fn every_subcommand_has_a_manual_page_and_is_completed() {
    let folder = tempfile::tempdir().expect("a folder");
    done(folder.path(), &["man", "pages"]);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = done(folder.path(), &["completions", shell]);
        for name in subcommands() {
            assert!(name.split(' ').all(|word| script.contains(word)), "{shell}: {name}");
        }
    }
    for name in subcommands() {
        let page = folder.path().join(format!("pages/fos-{}.1", name.replace(' ', "-")));
        let page = std::fs::read_to_string(page).expect("written");
        assert!(page.contains("Example: fos"), "{name}: {page}");
    }
}

#[test]
fn fos_without_arguments_lists_the_main_commands() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_fos")).output().expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("fos diagnose LOG") && text.contains("fos --help"), "{text}");
    let stderr = fails(folder.path(), 2, &["diagnos"]);
    assert!(stderr.contains("'diagnose'"), "{stderr}");
}

/// Files are accepted by different commands: the message names one that takes this file.
#[test]
fn recognises_a_log_passed_as_a_study_and_the_reverse() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.csv", "--minutes", "1", "--at-rest"]);
    done(folder, &["fit", "log.csv", "--axis", "gx", "--max-terms", "2", "-o", "unit.json"]);
    let stderr = fails(folder, 1, &["noise", "unit.json"]);
    assert!(
        stderr.contains("a study, not a log") && stderr.contains("`fos compare unit.json LOG`"),
        "{stderr}"
    );
    let stderr = fails(folder, 1, &["compare", "log.csv"]);
    assert!(
        stderr.contains("a log, not a study") && stderr.contains("`fos fit log.csv -o unit.json`"),
        "{stderr}"
    );
    let stderr = fails(folder, 1, &["replay", "unit.json", "log.csv"]);
    assert!(stderr.contains("`fos export unit.json --image unit.fosm`"), "{stderr}");
    let stderr = fails(folder, 1, &["diagnose", "log.csv", "--axis", "gX"]);
    assert!(stderr.contains("did you mean \"gx\"?"), "{stderr}");
    let stderr = fails(folder, 1, &["add", "unit.json", "temp_linear", "--axis", "gX", "--from", "log.csv"]);
    assert!(stderr.contains("did you mean gx?"), "{stderr}");
    let stderr = fails(folder, 2, &["fit", "log.csv", "--train", "50"]);
    assert!(stderr.contains("50% or 50s"), "{stderr}");
    let stderr = fails(folder, 1, &["fit", "log.csv", "--axis", "gx", "--physical", "Temperature"]);
    assert!(stderr.contains("did you mean \"temp_c\"?"), "{stderr}");
}

#[test]
fn refuses_figures_and_reports_with_an_ending_that_cannot_be_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let stderr = fails(folder, 1, &["noise", "log.csv", "--svg", "allan.png"]);
    assert!(stderr.contains("help: --svg allan.svg"), "{stderr}");
    let stderr = fails(folder, 1, &["report", "unit.json", "-o", "unit.pdf"]);
    assert!(stderr.contains("help: --output unit.html"), "{stderr}");
    let stderr = fails(folder, 1, &["fleet", "report", "population.json", "-o", "fleet.pdf"]);
    assert!(stderr.contains("help: --output fleet.html"), "{stderr}");
}

#[test]
fn prints_field_units_by_default_and_si_on_request() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.csv", "--minutes", "3", "--at-rest", "--rate", "50"]);
    let noise = done(folder, &["noise", "log.csv", "--axis", "gx,ax"]);
    assert!(noise.contains("N, °/√h") && noise.contains("N, µg/√Hz"), "{noise}");
    let noise = done(folder, &["noise", "log.csv", "--axis", "gx", "--units", "si"]);
    assert!(noise.contains("N, (rad/s)/√Hz") && !noise.contains("°/√h"), "{noise}");
    done(folder, &["fit", "log.csv", "--axis", "gx", "--max-terms", "2", "-o", "unit.json"]);
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    assert!(done(folder, &["inspect", "unit.fosm"]).contains("\ngyro x: reference 0 rad/s"));
    let unit = |units: &str| {
        let printed = done(folder, &["replay", "unit.fosm", "log.csv", "--units", units]);
        let row =
            printed.lines().find(|line| line.starts_with("   gx_rads")).expect("a row").trim_end().to_owned();
        row.rsplit(' ').next().expect("a unit").to_owned()
    };
    assert!(["°/s", "°/h"].contains(&unit("field").as_str()) && unit("si") == "rad/s");
}

#[test]
fn output_without_a_terminal_has_no_colours() {
    let folder = tempfile::tempdir().expect("a folder");
    let stderr = fails(folder.path(), 1, &["diagnose", "none.csv", "--axis", "gx"]);
    assert!(stderr.starts_with("error: none.csv: cannot open it"), "{stderr:?}");
    assert!(!stderr.contains('\u{1b}'), "{stderr:?}");
}

/// Words in backticks in the messages of the libraries: an option, which the program shows as its flag, or a column of a
/// log.
fn unknown_words(line: &str, options: &[String]) -> Vec<String> {
    const IN_LOGS: [&str; 4] = ["still", "segment", "ref_…", "t_s"];
    if !line.contains("help: ") && !line.contains("#[error(") {
        return Vec::new();
    }
    let quoted = line.split('`').skip(1).step_by(2);
    let is_name = |word: &&str| word.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let unknown = |word: &&str| {
        is_name(word) && !options.iter().any(|option| option == word) && !IN_LOGS.contains(word)
    };
    let mut unknown: Vec<String> = quoted.filter(unknown).map(str::to_owned).collect();
    // fields of the libraries that are options, outside backticks
    let bare = options.iter().filter(|option| option.contains('_')).filter(|option| {
        line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '`' && c != '{' && c != '.')
            .any(|word| word == option.as_str())
    });
    unknown.extend(bare.cloned());
    if line.contains("(!") && !line.contains("`columns`") {
        unknown.push("!column".to_owned());
    }
    unknown
}

#[test]
fn every_option_in_a_message_of_a_library_is_shown_by_its_flag() {
    let all = host_fit::cli::subcommands();
    let arguments = all.iter().flat_map(|(_, subcommand)| subcommand.get_arguments());
    let mut options: Vec<String> = arguments
        .filter(|option| option.get_long().is_some())
        .map(|option| option.get_id().to_string())
        .collect();
    options.sort();
    options.dedup();
    let mut found = Vec::new();
    for (path, text) in
        &sources(&["data/src", "fit/src", "calibrate/src", "simulate/src", "diagnose/src", "fleet/src"])
    {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        found.extend(
            code.flat_map(|line| unknown_words(line, &options)).map(|word| format!("{path}: {word}")),
        );
    }
    assert_eq!(found, [""; 0]);
    // negative control: former messages
    for before in [
        "\"help: or give the sample rate (rate_hz) if there is none\"",
        "\"help: leave the column out (!t_s)\"",
        "\"help: a larger `trian`\"",
    ] {
        assert_eq!(unknown_words(before, &options).len(), 1, "{before}");
    }
    println!(
        "attack: options in messages | all messages of the libraries: every option in them is one of the program's {} and is printed as a flag | negative control: 3 messages with library names are detected",
        options.len(),
    );
}

/// The libraries are also used without the program, from a page or from another program: their messages name options by
/// the names of their fields.
#[test]
fn no_library_names_a_flag_or_a_subcommand() {
    let all = host_fit::cli::subcommands();
    let flags = all.iter().flat_map(|(_, subcommand)| subcommand.get_arguments());
    let mut stderr: Vec<String> =
        flags.filter_map(|flag| flag.get_long()).map(|flag| format!("--{flag}")).collect();
    stderr.extend(all.iter().map(|(words, _)| format!("fos {words}")));
    let named = |line: &str| stderr.iter().find(|stderr| line.contains(stderr.as_str())).cloned();
    assert_eq!(named("\"help: a larger --train\"").as_deref(), Some("--train"));

    let libraries = sources(&["data/src", "fit/src", "calibrate/src", "simulate/src", "diagnose/src"]);
    assert!(libraries.len() > 100, "{}", libraries.len());
    let mut found = Vec::new();
    for (path, text) in &libraries {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        found.extend(code.filter_map(named).map(|stderr| format!("{path}: {stderr}")));
    }
    assert_eq!(found, [""; 0]);
}
