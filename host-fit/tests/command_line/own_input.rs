//! No output of a command replaces an input: every subcommand, every input, every output, under any path.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fos_testkit::is_thorough;
use fos_testkit::turned::turned_log;
use rayon::prelude::*;

use crate::session::{done, fails};
use crate::sources::sources;
use host_fit::cli::files::{Role, role_of};
use host_fit::cli::subcommands;

/// A command with its outputs. Words in braces are input arguments, with a file for each; inputs without an argument have
/// an empty name.
struct WritingCommand {
    words: &'static str,
    inputs: &'static [(&'static str, &'static str)],
    /// Name of the argument, its option, and the file that is written.
    outputs: &'static [(&'static str, &'static str, &'static str)],
}

/// A command line that writes to `at` for its argument `output`.
struct Line {
    output: &'static str,
    at: &'static str,
    words: String,
    inputs: &'static [(&'static str, &'static str)],
}

const UNIT: (&str, &str) = ("study", "unit.json");
const REFINED: (&str, &str) = ("study", "refined.json");
const LOG: (&str, &str) = ("log", "log.parquet");
const MAP: (&str, &str) = ("map_file", "map.toml");
const IMAGE: (&str, &str) = ("image", "unit.fosm");
const EFFECTS: (&str, &str) = ("effects", "effect.toml");
const FROM: (&str, &str) = ("from", "field.parquet");
const REFERENCE: (&str, &str) = ("reference", "log.parquet");
const EVALUATION: (&str, &str) = ("evaluate_on", "later.parquet");
const TURNED: (&str, &str) = ("logs", "turned.csv");
/// Read since the study names it.
const FITTED: (&str, &str) = ("", "log.parquet");

const COMMANDS: [WritingCommand; 22] = [
    WritingCommand {
        words: "calibrate-imu {logs} --map-file {map_file} --study {study}",
        inputs: &[TURNED, MAP, UNIT],
        outputs: &[
            ("output", "-o out.html", "out.html"),
            ("px4", "--px4 out", "out"),
            ("ardupilot", "--ardupilot out", "out"),
            ("kalibr", "--kalibr out", "out"),
            ("imu_tk_acc", "--imu-tk-acc out", "out"),
            ("imu_tk_gyro", "--imu-tk-gyro out", "out"),
        ],
    },
    WritingCommand {
        words: "convert {log} --map-file {map_file}",
        inputs: &[LOG, MAP],
        outputs: &[("output", "-o out.csv", "out.csv")],
    },
    WritingCommand {
        words: "table {log} --map-file {map_file} --axis gx --train 10 --evaluate 5 --max-order 1 --degree 1 --repeats 1",
        inputs: &[LOG, MAP],
        outputs: &[("figures", "--figures figures", "figures/gx_rads_autocorrelation.svg")],
    },
    WritingCommand {
        words: "fit {log} --map-file {map_file} --axis gx --max-terms 2 --memory none",
        inputs: &[LOG, MAP],
        outputs: &[("output", "-o out.json", "out.json")],
    },
    WritingCommand {
        words: "compare {study} {log} --map-file {map_file}",
        inputs: &[UNIT, LOG, MAP],
        outputs: &[("figures", "--figures figures", "figures/gx_rads_1_over_time.svg")],
    },
    WritingCommand {
        words: "compare {study}",
        inputs: &[UNIT, FITTED],
        outputs: &[("figures", "--figures figures", "figures/gx_rads_1_over_time.svg")],
    },
    WritingCommand {
        words: "add {study} temp_linear --from {from} --reference {reference} --evaluate-on {evaluate_on} --effect {effect_files} --map-file {map_file}",
        inputs: &[UNIT, FROM, REFERENCE, EVALUATION, ("effect_files", "effect.toml"), MAP],
        outputs: &[("figures", "--figures figures", "figures/gx_rads_staircase.svg")],
    },
    WritingCommand {
        words: "history {study}",
        inputs: &[REFINED],
        outputs: &[("figures", "--figures figures", "figures/gx_rads_staircase.svg")],
    },
    WritingCommand {
        words: "batch cases --effect {effects}",
        inputs: &[EFFECTS, ("folder", "cases/one/field.parquet"), ("folder", "cases/one/meta.json")],
        outputs: &[("output", "-o answers", "answers/answers.json")],
    },
    WritingCommand {
        words: "fleet cases --effect {effects} --map-file {map_file}",
        inputs: &[EFFECTS, MAP, ("folder", "cases/one/field.parquet")],
        outputs: &[("output", "-o out.json", "out.json")],
    },
    WritingCommand {
        words: "fleet export {population}",
        inputs: &[("population", "population.json"), ("", "population.json.rows")],
        outputs: &[("output", "-o shipment", "shipment/part.fosm")],
    },
    WritingCommand {
        words: "fleet report {population}",
        inputs: &[("population", "population.json"), ("", "population.json.rows")],
        outputs: &[("output", "-o out.html", "out.html")],
    },
    WritingCommand {
        words: "calibrate --cases 1 --effect {effects}",
        inputs: &[EFFECTS],
        outputs: &[("outcomes", "--outcomes out.json", "out.json")],
    },
    WritingCommand {
        words: "export {study} --instance 0 --px4 table --evaluate-on {evaluate_on}",
        inputs: &[UNIT, EVALUATION],
        outputs: &[
            ("image", "--image out", "out"),
            ("rust", "--rust out", "out"),
            ("c", "--c out.h", "out.h"),
        ],
    },
    WritingCommand {
        words: "export {study} --instance 0 --evaluate-on {evaluate_on}",
        inputs: &[UNIT, EVALUATION],
        outputs: &[("px4", "--px4 out", "out"), ("ardupilot", "--ardupilot out", "out")],
    },
    WritingCommand {
        words: "noise {log} --map-file {map_file} --axis gx",
        inputs: &[LOG, MAP],
        outputs: &[("csv", "--csv out", "out"), ("svg", "--svg out", "out")],
    },
    WritingCommand {
        words: "noise {log} --map-file {map_file}",
        inputs: &[LOG, MAP],
        outputs: &[
            ("imu_yaml", "--imu-yaml out", "out"),
            ("orb_slam3", "--orb-slam3 out", "out"),
            ("vins", "--vins out", "out"),
        ],
    },
    WritingCommand {
        words: "replay {image} {log} --map-file {map_file}",
        inputs: &[IMAGE, LOG, MAP],
        outputs: &[("output", "-o out.csv", "out.csv"), ("hub_log", "--hub-log out", "out")],
    },
    WritingCommand {
        words: "record {stream}",
        inputs: &[("stream", "device.stream")],
        outputs: &[("output", "-o out.csv", "out.csv")],
    },
    WritingCommand {
        words: "report {study} --from {from} --reference {reference} --evaluate-on {evaluate_on} --effect {effects} --map-file {map_file}",
        inputs: &[UNIT, FROM, REFERENCE, EVALUATION, EFFECTS, MAP],
        outputs: &[("output", "-o out.md", "out.md")],
    },
    WritingCommand {
        words: "report {study} --from {from}",
        inputs: &[UNIT, FROM, FITTED],
        outputs: &[("output", "-o out.md", "out.md")],
    },
    WritingCommand {
        words: "report {study}",
        inputs: &[REFINED, ("", "field.parquet")],
        outputs: &[("output", "-o out.md", "out.md")],
    },
];

/// A command line for every output of every command.
fn lines() -> Vec<Line> {
    let of = |command: &WritingCommand| {
        let WritingCommand { words, inputs, outputs } = *command;
        let line = move |(output, option, at): &(&'static str, &str, &'static str)| Line {
            output,
            at,
            words: format!("{words} {option}"),
            inputs,
        };
        outputs.iter().map(line).collect::<Vec<_>>()
    };
    COMMANDS.iter().flat_map(of).collect()
}

impl Line {
    /// Longest subcommand at the begin of the words: `fleet report`, not `fleet`.
    fn subcommand(&self) -> String {
        let is_of = |name: &String| format!("{} ", self.words).starts_with(&format!("{name} "));
        let of_line = subcommands().into_iter().map(|(name, _)| name).filter(is_of);
        of_line.max_by_key(String::len).expect("a subcommand")
    }

    /// Returns true if an argument names the file of the input `id`, so that it can have another name.
    fn names(&self, id: &str) -> bool {
        self.words.contains(&format!("{{{id}}}"))
    }

    /// Arguments with `given` naming a file in this way.
    fn arguments(&self, given: (&str, &str)) -> Vec<String> {
        let inputs = |word: &str| {
            let name = word.strip_prefix('{')?.strip_suffix('}')?;
            let file = self.inputs.iter().find(|(id, _)| *id == name).expect("in the table").1;
            Some(if given.0 == name { given.1 } else { file }.to_owned())
        };
        self.words.split(' ').map(|word| inputs(word).unwrap_or_else(|| word.to_owned())).collect()
    }
}

/// Ways in which an output path can lead to an input; the first two need an argument that names the input.
const SPELLINGS: [&str; 4] = ["as it is", "by another way", "by a symbolic link", "by a hard link"];

/// Makes `output` lead to the file `input` in `folder`; returns the new name of the input. `None` if no argument names
/// the file, so that it cannot have another name.
fn lead(folder: &Path, spelling: &str, input: &str, output: &str, is_named: bool) -> Option<String> {
    let (from, to) = (folder.join(input), folder.join(output));
    fs::create_dir_all(to.parent()?).expect("made");
    match spelling {
        "as it is" if is_named => {
            fs::rename(&from, &to).expect("moved");
            // others may read it too
            fs::copy(&to, &from).expect("copied");
            Some(output.to_owned())
        }
        "by another way" if is_named => {
            fs::rename(&from, &to).expect("moved");
            fs::copy(&to, &from).expect("copied");
            Some(format!("./cases/../{output}"))
        }
        "by a symbolic link" => {
            symlink(&from, &to).expect("linked");
            Some(input.to_owned())
        }
        "by a hard link" => {
            fs::hard_link(&from, &to).expect("linked");
            Some(input.to_owned())
        }
        _ => None,
    }
}

fn run(folder: &Path, arguments: &[String]) -> Output {
    let host_fit = Command::new(env!("CARGO_BIN_EXE_fos")).current_dir(folder).args(arguments).output();
    host_fit.expect("it starts")
}

/// Prepares all inputs of the command lines.
fn prepare(folder: &Path) {
    let write = |name: &str, text: &[u8]| fs::write(folder.join(name), text).expect("written");
    for (log, seed) in [("log.parquet", "1"), ("field.parquet", "2"), ("later.parquet", "3")] {
        done(folder, &["simulate", log, "--minutes", "1", "--seed", seed, "--at-rest"]);
    }
    let fit = ["fit", "log.parquet", "--axis", "gx", "--max-terms", "2", "--memory", "none"];
    done(folder, &[&fit[..], &["-o", "unit.json"]].concat());
    fs::copy(folder.join("unit.json"), folder.join("refined.json")).expect("copied");
    done(folder, &["add", "refined.json", "temp_linear", "--from", "field.parquet"]);
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    write("turned.csv", turned_log().as_bytes());
    write("map.toml", b"[columns]\ngx_rads = \"gx_rads\"\n");
    write("effect.toml", done(folder, &["effects", "--example"]).as_bytes());
    let stream = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/telemetry_v1.stream");
    fs::copy(stream, folder.join("device.stream")).expect("copied");
    fs::create_dir_all(folder.join("cases/one")).expect("made");
    fs::copy(folder.join("field.parquet"), folder.join("cases/one/field.parquet")).expect("copied");
    let meta = r#"{"case": "one", "target": "gx_rads", "nominal_rate_hz": 200, "files": {"field": "field"}}"#;
    write("cases/one/meta.json", meta.as_bytes());
    fs::create_dir_all(folder.join("line")).expect("made");
    for log in ["log.parquet", "field.parquet", "later.parquet"] {
        fs::copy(folder.join(log), folder.join("line").join(log)).expect("copied");
    }
    done(folder, &["fleet", "line", "-o", "population.json"]);
}

fn copy_all(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let copy = to.join(path.file_name().expect("a name"));
        match path.is_dir() {
            true => {
                fs::create_dir_all(&copy).expect("made");
                copy_all(&path, &copy);
            }
            false => drop(fs::copy(&path, &copy).expect("copied")),
        }
    }
}

/// Checks that the file at `output` still holds `before` after a command with this output.
fn check_unchanged(folder: &Path, output: &str, before: &[u8], ended: &Output) -> Result<(), String> {
    let message = String::from_utf8_lossy(&ended.stderr);
    let now = fs::read(folder.join(output)).unwrap_or_default();
    match ended.status.code() {
        _ if now != before => Err(format!("the input is lost, exit code {:?}", ended.status.code())),
        Some(1) if message.contains("help: ") && message.contains("another file") => Ok(()),
        code => Err(format!("exit code {code:?}: {message}")),
    }
}

/// Arguments of a subcommand with one of these roles, by their names in the program.
fn arguments_of(subcommand: &clap::Command, roles: &[Role]) -> BTreeSet<String> {
    let of_role = |argument: &&clap::Arg| role_of(argument).is_some_and(|role| roles.contains(&role));
    subcommand.get_arguments().filter(of_role).map(|argument| argument.get_id().to_string()).collect()
}

/// Every new path argument must be added to the table.
#[test]
fn the_table_has_every_input_and_every_output() {
    let (all, mut outputs) = (lines(), 0);
    for (name, subcommand) in subcommands() {
        let read = arguments_of(&subcommand, &[Role::Input]);
        let written = arguments_of(&subcommand, &[Role::OutputFile, Role::OutputFolder]);
        outputs += written.len();
        // a server never ends; it chooses the names of its outputs itself (workbench/folders.rs)
        if name == "serve" || read.is_empty() {
            assert!(!all.iter().any(|line| line.subcommand() == name), "{name}");
            continue;
        }
        for output in &written {
            let lines = all.iter().filter(|line| line.subcommand() == name && line.output == output);
            let inputs = lines.flat_map(|line| line.inputs).map(|(id, _)| (*id).to_owned());
            let inputs: BTreeSet<String> = inputs.filter(|id| !id.is_empty()).collect();
            assert_eq!(inputs, read, "inputs of {name} in the table of its output {output}");
        }
        let in_table = all.iter().filter(|line| line.subcommand() == name);
        let in_table: BTreeSet<String> = in_table.map(|line| line.output.to_owned()).collect();
        assert_eq!(in_table, written, "outputs of {name} in the table");
    }
    assert!(outputs >= 18, "{outputs}");
}

#[test]
fn no_output_replaces_an_input() {
    let source = tempfile::tempdir().expect("a folder");
    prepare(source.path());
    let (lines, mut cases) = (lines(), Vec::new());
    for line in &lines {
        for input in line.inputs {
            let possible = if line.names(input.0) { &SPELLINGS[..] } else { &SPELLINGS[2..] };
            // one spelling for each input in turn; all in a thorough run
            let one = std::slice::from_ref(&possible[cases.len() % possible.len()]);
            let spellings = if is_thorough() { possible } else { one };
            cases.extend(spellings.iter().map(|spelling| (line, input, *spelling)));
        }
    }
    // whether a comparison of names would have missed the input, and what is wrong
    let results: Vec<(bool, Result<(), String>)> = cases
        .par_iter()
        .filter_map(|(line, (id, file), spelling)| {
            let folder = tempfile::tempdir().expect("a folder");
            let folder = folder.path();
            copy_all(source.path(), folder);
            let given = lead(folder, spelling, file, line.at, line.names(id))?;
            let before = fs::read(folder.join(line.at)).expect("there");
            let ended = run(folder, &line.arguments((id, &given)));
            let unchanged = check_unchanged(folder, line.at, &before, &ended);
            let in_words = |what| format!("{} ({id} {spelling}): {what}", line.words);
            Some((given != line.at, unchanged.map_err(in_words)))
        })
        .collect();
    let tried = results.len();
    let of_names = results.iter().filter(|(is_missed, _)| *is_missed).count();
    let wrong: Vec<String> = results.into_iter().filter_map(|(_, unchanged)| unchanged.err()).collect();
    assert!(wrong.is_empty(), "{} of {tried}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(of_names > tried / 2);

    // another file with the same content is no input
    let mut replaced = 0;
    for (words, output) in [
        ("fit log.parquet --axis gx --max-terms 2 --memory none -o out.json", "out.json"),
        ("export unit.json --image out.json", "out.json"),
        ("replay unit.fosm log.parquet -o out.csv", "out.csv"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        copy_all(source.path(), folder.path());
        fs::copy(folder.path().join("log.parquet"), folder.path().join(output)).expect("copied");
        done(folder.path(), &words.split(' ').collect::<Vec<_>>());
        assert_ne!(
            fs::read(folder.path().join(output)).expect("there"),
            fs::read(source.path().join("log.parquet")).expect("there")
        );
        replaced += 1;
    }

    // negative control: a writer without the check is detected
    let mut found_out = 0;
    for spelling in SPELLINGS {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        copy_all(source.path(), folder);
        let given = lead(folder, spelling, "log.parquet", "out.json", true).expect("named");
        let before = fs::read(folder.join("out.json")).expect("there");
        let script = format!(
            "{} fit {given} --axis gx --max-terms 2 --memory none -o new && cat new > out.json",
            env!("CARGO_BIN_EXE_fos")
        );
        let ended = Command::new("sh").args(["-c", &script]).current_dir(folder).output().expect("a shell");
        found_out += usize::from(check_unchanged(folder, "out.json", &before, &ended).is_err());
    }
    assert_eq!(found_out, SPELLINGS.len());
    println!(
        "attack: own input | {tried} command lines whose output is one of their inputs ({} subcommands, {} outputs; same path, another path, symbolic link, hard link): all refused with exit code 1, all inputs unchanged; {replaced} copies that are separate files are replaced | negative control: a comparison of names would accept {of_names} of {tried}; a writer without the check is detected {found_out} of {} times",
        lines.iter().map(Line::subcommand).collect::<BTreeSet<_>>().len(),
        lines.iter().map(|line| (line.subcommand(), line.output)).collect::<BTreeSet<_>>().len(),
        SPELLINGS.len()
    );
}

#[test]
fn two_outputs_are_two_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepare(folder);
    fs::create_dir(folder.join("real")).expect("made");
    symlink(folder.join("real"), folder.join("linked")).expect("linked");
    fs::write(folder.join("old"), "old").expect("written");
    fs::hard_link(folder.join("old"), folder.join("hard")).expect("linked");
    for (first, second) in
        [("new", "new"), ("new", "./real/../new"), ("real/new", "linked/new"), ("old", "hard")]
    {
        for [one, other] in [["--image", "--rust"], ["--rust", "--c"], ["--image", "--c"]] {
            let message = fails(folder, 1, &["export", "unit.json", one, first, other, second]);
            assert!(
                message.contains(&format!("{one} and {other} are one file")) && message.contains("help: "),
                "{message}"
            );
        }
        let message =
            fails(folder, 1, &["replay", "unit.fosm", "log.parquet", "-o", first, "--hub-log", second]);
        assert!(message.contains("--output and --hub-log are one file"), "{message}");
    }
    assert!(!folder.join("new").exists() && !folder.join("real/new").exists(), "nothing was written");
    assert_eq!(fs::read(folder.join("old")).expect("there"), b"old");
    let written: Vec<PathBuf> = ["a", "b", "c.h"].map(|name| folder.join(name)).to_vec();
    done(folder, &["export", "unit.json", "--image", "a", "--rust", "b", "--c", "c.h"]);
    assert!(written.iter().all(|path| path.exists()));
}

/// Other files that read without recording the input: none of them reads data of the user.
const OTHER_DOORS: [&str; 7] = [
    "data/src/file/read.rs",                 // the module that records inputs
    "data/src/file/paths.rs",                // a folder, to sync its names to the disk
    "data/src/file/replace.rs",              // the file to be replaced, and leftovers of killed writers
    "data/src/file/compare_and_swap.rs",     // whether a study is unchanged
    "data/src/file/keyed_rows.rs",           // rows of an interrupted run
    "device-io/src/record/received_file.rs", // whether another recording runs
    "device-io/src/record/end.rs",           // state of this process by the system
];

fn opens_a_file(source: &str) -> bool {
    let program = source.split("\nmod tests {").next().unwrap_or_default();
    ["File::open(", "fs::read(", "fs::read_to_string(", ".read(true)"]
        .iter()
        .any(|call| program.contains(call))
}

#[test]
fn only_one_module_opens_user_files() {
    let all = sources(&[
        "src",
        "data/src",
        "fit/src",
        "calibrate/src",
        "simulate/src",
        "diagnose/src",
        "fleet/src",
        "export/src",
        "figures/src",
        "report/src",
        "device-io/src",
        "workbench/src",
    ]);
    let mut seen = 0;
    for (name, text) in all.iter().filter(|(name, _)| !name.ends_with("tests.rs")) {
        assert_eq!(
            opens_a_file(text),
            OTHER_DOORS.contains(&name.as_str()),
            "{name} opens a file: fos_data::file::open notes which"
        );
        seen += 1;
    }
    assert!(seen > 150, "{seen}");
    assert!(opens_a_file("let log = File::open(path)?;"));
}
