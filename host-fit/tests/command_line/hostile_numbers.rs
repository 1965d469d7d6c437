//! Every numeric option, with meaningless numbers: an answer, or a clear refusal; no panic, and bounded memory.

use std::any::TypeId;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use fos_testkit::is_thorough;
use fos_testkit::turned::turned_log;
use rayon::prelude::*;

const NUMBERS: [&str; 12] = [
    "inf",
    "-inf",
    "NaN",
    "1e300",
    "-1e300",
    "1e-300",
    "0",
    "-1",
    "65535",
    "4294967295",
    "18446744073709551615",
    "-9223372036854775808",
];

/// Time after which a running program counts as at work.
const LONG: Duration = Duration::from_secs(1);

/// Limit of the address space, kilobytes: several times the need of any of these commands.
const LIMIT_KB: u32 = 4_000_000;

/// A valid command line, to which one option is added. An option that it contains is replaced.
fn line_of(subcommand: &str, option: &str) -> Option<&'static str> {
    Some(match (subcommand, option) {
        ("simulate", "size" | "effect") => "simulate --case case --effect thermal_lag",
        ("simulate", "suite") => "simulate suite",
        ("simulate", _) => "simulate out.csv --at-rest --minutes 0.1",
        ("fit", "denoise") => "fit log.csv --axis gx -o other.json --max-terms 2 --method burg",
        ("fit", "input-lags") => "fit log.csv --axis gx -o other.json --input temp_c",
        ("fit", _) => "fit log.csv --axis gx -o other.json --max-terms 2",
        ("table", _) => {
            "table log.csv --axis gx --train 40 --evaluate 20 --degree 1 --max-order 1 --repeats 1"
        }
        ("compare", _) => "compare unit.json log.csv",
        ("diagnose", _) => "diagnose log.csv --axis gx",
        ("add", _) => "add unit.json temp_linear --from log.csv",
        ("replay", _) => "replay unit.fosm log.csv",
        ("report", _) => "report unit.json --from log.csv",
        ("record", _) => "record none.stream -o recorded.csv",
        ("calibrate", _) => "calibrate --cases 1",
        ("export", _) => "export unit.json --instance 0 --px4 unit.params --evaluate-on log.csv",
        ("fleet", _) => "fleet . -o population.json",
        ("noise", _) => "noise log.csv --axis gx",
        ("plan", _) => "plan log.csv --axis gx",
        ("calibrate-imu", "rate-table") => "calibrate-imu turned.csv",
        ("calibrate-imu", "height") => "calibrate-imu turned.csv --latitude 45",
        ("calibrate-imu", _) => "calibrate-imu turned.csv --px4 turned.params",
        ("convert", _) => "convert log.csv -o out.csv",
        ("demo", _) => "demo",
        ("serve", _) => "serve",
        ("bench", _) => "bench",
        _ => return None,
    })
}

/// Options whose text contains numbers, at the places marked by `#`.
const TEXTS: [(&str, &str, &[&str]); 11] = [
    ("calibrate-imu", "rate-table", &["#rpm", "33.3333rpm,#dps"]),
    ("calibrate-imu", "accuracy", &["#mg"]),
    ("fleet", "regressor", &["temp_c:lowpass(#)", "temp_c:rate(#)"]),
    ("fit", "train", &["#%", "#s", "#"]),
    ("fit", "memory", &["#", "1,#"]),
    (
        "fit",
        "input",
        &[
            "temp_c:lowpass(#)",
            "temp_c:rate(#)",
            "temp_c:variance(#)",
            "temp_c:backlash(#)",
            "clock:decay(#)",
            "clock:sine(#)",
        ],
    ),
    ("fit", "physical", &["temp_c:lowpass(#)", "clock:decay(#)"]),
    ("fit", "denoise", &["db4:#:soft"]),
    ("fit", "map", &["gx_rads=gx_rads:*#", "gx_rads=gx_rads:/#", "gx_rads=gx_rads:+#"]),
    ("table", "denoise", &["db4:#:soft"]),
    ("simulate", "effect", &["thermal_lag:tau_s=#", "spectral_line:frequency_hz=#"]),
];

/// Options that take text without a number, or one of a list of words.
const WORDS: [&str; 18] = [
    "device", "date", "axis", "axes", "sensor", "part", "target", "method", "search", "stop", "listen",
    "map", "effect", "input", "physical", "rostopic", "format", "topic",
];

/// Result of a command line.
#[derive(Debug, PartialEq, Clone, Copy)]
enum End {
    Done,
    Refused,
    AtWork,
    Fell,
}

fn run(folder: &Path, program: &str, arguments: &[String]) -> (End, String) {
    let err = folder.join(format!("err-{:?}", thread::current().id()));
    let limited = format!("ulimit -v {LIMIT_KB}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, program])
        .args(arguments)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&err).expect("made"))
        .spawn()
        .expect("it starts");
    let began = Instant::now();
    let status = loop {
        match child.try_wait().expect("it can be waited for") {
            Some(status) => break Some(status),
            None if began.elapsed() > LONG => {
                let _ = (child.kill(), child.wait());
                break None;
            }
            None => thread::sleep(Duration::from_millis(5)),
        }
    };
    let message = std::fs::read_to_string(&err).unwrap_or_default();
    let end = match status.map(|status| status.code()) {
        _ if message.contains("panicked") => End::Fell,
        None => End::AtWork,
        Some(Some(0)) => End::Done,
        Some(Some(1 | 2)) if message.starts_with("error: ") => End::Refused,
        _ => End::Fell,
    };
    (end, message)
}

/// Runs the command lines on four threads, each in its own copy of the prepared files: they write files of the same
/// name.
fn run_all(folder: &Path, program: &str, lines: &[Vec<String>]) -> Vec<(End, String)> {
    let run_in_copy = |line: &Vec<String>| {
        let own = tempfile::tempdir().expect("a folder");
        for file in ["log.csv", "unit.json", "unit.fosm", "none.stream", "turned.csv"] {
            std::fs::copy(folder.join(file), own.path().join(file)).expect("copied");
        }
        run(own.path(), program, line)
    };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(4).build().expect("threads");
    threads.install(|| lines.par_iter().map(run_in_copy).collect())
}

/// `line` with the option set to `value`.
fn with(line: &str, flag: &str, value: &str) -> Vec<String> {
    let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
    if let Some(at) = words.iter().position(|word| *word == format!("--{flag}")) {
        words.drain(at..at + 2);
    }
    words.push(format!("--{flag}={value}"));
    words
}

fn command_lines() -> (Vec<Vec<String>>, Vec<String>) {
    let (mut lines, mut options) = (Vec::new(), Vec::new());
    for (name, subcommand) in host_fit::cli::subcommands() {
        let name = name.as_str();
        for argument in subcommand.get_arguments().filter(|argument| argument.get_action().takes_values()) {
            let kind = argument.get_value_parser().type_id();
            let is = |of: TypeId| kind == of;
            let numeric = is(TypeId::of::<f64>())
                || is(TypeId::of::<usize>())
                || is(TypeId::of::<u64>())
                || is(TypeId::of::<u32>())
                || is(TypeId::of::<u16>())
                || is(TypeId::of::<u8>());
            let Some(flag) = argument.get_long() else {
                assert!(!numeric, "{name} {}: a number without a name", argument.get_id());
                continue;
            };
            let texts =
                TEXTS.iter().find(|(of, option, _)| (*of, *option) == (name, flag)).map(|(.., texts)| *texts);
            let texts: &[&str] = match (numeric, texts) {
                (true, _) => &["#"],
                (false, Some(texts)) => texts,
                (false, None) => {
                    let known = host_fit::cli::files::role_of(argument).is_some()
                        || WORDS.contains(&flag)
                        || !argument.get_possible_values().is_empty();
                    assert!(known, "{name} --{flag}: does it take a number? It is in no table of this test");
                    continue;
                }
            };
            let line = line_of(name, flag)
                .unwrap_or_else(|| panic!("{name} --{flag}: no command line in this test"));
            options.push(format!("{name} --{flag}"));
            for text in texts {
                // one number for each option; all numbers in a thorough run
                let first = lines.len() % NUMBERS.len();
                let numbers = if is_thorough() { &NUMBERS[..] } else { &NUMBERS[first..=first] };
                lines.extend(numbers.iter().map(|number| with(line, flag, &text.replace('#', number))));
            }
        }
    }
    (lines, options)
}

#[test]
#[cfg(unix)]
fn meaningless_numbers_are_rejected_safely() {
    let program = env!("CARGO_BIN_EXE_fos");
    let folder = tempfile::tempdir().expect("a folder");
    let prepare = |line: &str| {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let made = Command::new(program).args(&words).current_dir(folder.path()).output().expect("it starts");
        assert!(made.status.success(), "{line}: {}", String::from_utf8_lossy(&made.stderr));
    };
    prepare("simulate log.csv --minutes 2 --at-rest");
    prepare("fit log.csv --axis gx --max-terms 2 -o unit.json");
    prepare("export unit.json --image unit.fosm");
    std::fs::write(folder.path().join("none.stream"), "").expect("written");
    std::fs::write(folder.path().join("turned.csv"), turned_log()).expect("written");

    let (lines, options) = command_lines();
    // without the option each of them works, so that a refusal is due to the number
    let mut sound: Vec<&str> = options
        .iter()
        .filter_map(|option| option.split_once(" --"))
        .filter_map(|(name, flag)| line_of(name, flag))
        .collect();
    sound.sort_unstable();
    sound.dedup();
    // a stream without a sample gives no log, and two minutes of warm-up are too short for a table
    sound.retain(|line| !line.starts_with("record") && !line.starts_with("export"));
    let sound: Vec<Vec<String>> = sound
        .into_iter()
        .map(|line| match line {
            "simulate suite" => with(line, "suite", "0"),
            _ => line.split(' ').map(str::to_owned).collect(),
        })
        .collect();
    for (line, (end, message)) in sound.iter().zip(run_all(folder.path(), program, &sound)) {
        assert!(matches!(end, End::Done | End::AtWork), "{line:?}: {message}");
    }
    let ends = run_all(folder.path(), program, &lines);
    for (line, (end, message)) in lines.iter().zip(&ends) {
        assert_ne!(*end, End::Fell, "{line:?}: {message}");
    }
    let count = |end: End| ends.iter().filter(|(found, _)| *found == end).count();

    // negative controls: a panic, and unbounded memory
    let sh = |script: &str| run(folder.path(), "sh", &["-c".to_owned(), script.to_owned()]).0;
    let panicked = sh("echo \"thread 'main' panicked at\" >&2; exit 101");
    let endless = sh("exec dd if=/dev/zero of=/dev/null bs=8000000000 count=1");
    assert_eq!(panicked, End::Fell);
    assert_eq!(endless, End::Fell);
    println!(
        "attack: hostile numbers | {} numeric options, listed by the command line parser, each with {} values (infinite, NaN, too large, negative, 0): {} command lines with at most {} MB: {} refused with a reason and exit code 1 or 2, {} completed, {} still running after {} s; no panic | negative control: a program that panics and one that takes 8 GB are detected",
        options.len(),
        NUMBERS.len(),
        lines.len(),
        LIMIT_KB / 1000,
        count(End::Refused),
        count(End::Done),
        count(End::AtWork),
        LONG.as_secs()
    );
}
