//! Times whole commands as a user waits for them, optionally against another build of the program in the same run.
//!
//! Both builds run in turn, in folders of the same names, so that their output can be compared byte by byte.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::Serialize;
use wait4::{ResourceUsage, Wait4};

use super::{BenchError, Settings, measure};

/// Settings of the measurement.
#[derive(Debug, Clone)]
pub struct CommandSettings {
    /// Length of the logs, min.
    pub minutes: u32,
    /// Length of a long log that is also fitted, h; 0 for none.
    pub long_hours: u32,
    /// Runs of each command; the shortest time counts.
    pub repeats: usize,
    /// Other build to compare with.
    pub against: Option<PathBuf>,
}

/// Times of all commands.
#[derive(Debug, Clone, Serialize)]
pub struct CommandTimes {
    /// Length of the logs, min.
    pub minutes: u32,
    /// Times in the order of the runs.
    pub commands: Vec<CommandTime>,
    /// Moments, search and refit of six axes over the fitted rows, on one thread, s: the numerical part of `fit`.
    pub engine_s: f64,
}

/// Time and memory of one command.
#[derive(Debug, Clone, Serialize)]
pub struct CommandTime {
    /// Description of the command.
    pub name: String,
    /// Arguments of the command.
    pub arguments: String,
    /// Cost in this build.
    pub took: Took,
    /// Cost in the other build.
    pub before: Option<Took>,
    /// Both builds wrote and printed the same; none without another build.
    pub is_same: Option<bool>,
}

/// Least time and memory of several runs.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Took {
    /// Time from start to end, s.
    pub wall_s: f64,
    /// Processor time of all threads, user and system, s.
    pub processor_s: f64,
    /// Peak memory, bytes; 0 if the system does not report it.
    pub peak_bytes: u64,
}

/// The commands could not be timed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A file operation or the start of a process failed.
    #[error("{doing}: {source}")]
    Io {
        /// Operation that failed.
        doing: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A command ended with an error.
    #[error(
        "{program} {arguments}: {last_line}\nhelp: run it by hand; `against` takes a program that knows the same commands"
    )]
    Failed {
        /// Path of the program.
        program: String,
        /// Arguments of the command.
        arguments: String,
        /// Last line of its output.
        last_line: String,
    },
    /// The numerical part failed.
    #[error(transparent)]
    Bench(#[from] BenchError),
}

/// A command of the table.
struct Row {
    name: &'static str,
    arguments: &'static str,
    /// Output file, if it is the same in every run.
    writes: Option<&'static str>,
    /// The printed text is the same in every run, except for times.
    prints: bool,
}

/// Number of timed commands, without those on the long log.
pub const COMMANDS: usize = ROWS.len();

const ROWS: [Row; 9] = [
    Row {
        name: "fit, six axes",
        arguments: "fit log.parquet --axis all -o unit.json",
        writes: Some("unit.json"),
        prints: true,
    },
    Row {
        name: "fit, one axis, one term",
        arguments: "fit log.parquet --axis gx --degree 1 --max-terms 1 -o one.json",
        writes: Some("one.json"),
        prints: true,
    },
    Row {
        name: "fit, six axes and temperature",
        arguments: "fit log.parquet --axis all --physical temp_c -o warm.json",
        writes: Some("warm.json"),
        prints: true,
    },
    Row { name: "compare, six axes", arguments: "compare unit.json --json", writes: None, prints: true },
    Row {
        name: "report, one axis",
        arguments: "report one.json --from later.parquet --axis gx -o report.html",
        writes: Some("report.html"),
        prints: false,
    },
    Row {
        name: "diagnose, one axis",
        arguments: "diagnose one.json --from later.parquet",
        writes: None,
        prints: true,
    },
    Row {
        name: "fit of a case",
        arguments: "fit unit/reference.parquet --axis gx -o case.json",
        writes: Some("case.json"),
        prints: true,
    },
    Row {
        name: "diagnose a case",
        arguments: "diagnose case.json --from unit/log.parquet",
        writes: None,
        prints: true,
    },
    Row { name: "demo", arguments: "demo --folder demo", writes: Some("demo/unit.fosm"), prints: false },
];

const LONG: Row = Row {
    name: "fit of the long log, six axes",
    arguments: "fit long.parquet --axis all -o long.json",
    writes: Some("long.json"),
    prints: true,
};

/// Sampling rate of the logs, Hz.
const RATE_HZ: u32 = 200;

/// Creates logs in `folder` and runs every command on them as a process, by this build and the other in turn.
///
/// # Errors
///
/// A process cannot be started, a command ends with an error, or a file cannot be written.
pub fn time_commands(
    program: &Path,
    folder: &Path,
    settings: &CommandSettings,
    mut done: impl FnMut(),
) -> Result<CommandTimes, CommandError> {
    let CommandSettings { minutes, long_hours, repeats, against } = settings;
    let programs: Vec<&Path> = [Some(program), against.as_deref()].into_iter().flatten().collect();
    let places: Vec<PathBuf> =
        ["this", "other"].map(|name| folder.join(name)).into_iter().take(programs.len()).collect();
    let first = &places[0];
    fs::create_dir_all(first).map_err(io("make a folder"))?;
    let mut simulated = vec![
        format!("simulate log.parquet --minutes {minutes} --seed 5"),
        format!("simulate later.parquet --minutes {minutes} --seed 6"),
        "simulate --case unit --setup desk --effect thermal_lag".to_owned(),
    ];
    if *long_hours > 0 {
        simulated.push(format!("simulate long.parquet --minutes {} --seed 7", 60 * long_hours));
    }
    for arguments in &simulated {
        run(program, first, arguments)?;
    }
    for other in &places[1..] {
        for name in ["log.parquet", "later.parquet", "long.parquet"] {
            if first.join(name).exists() {
                link(&first.join(name), &other.join(name))?;
            }
        }
        for file in fs::read_dir(first.join("unit")).map_err(io("read a case"))? {
            let file = file.map_err(io("read a case"))?;
            link(&file.path(), &other.join("unit").join(file.file_name()))?;
        }
    }
    let mut commands = Vec::new();
    for row in ROWS.iter().chain((*long_hours > 0).then_some(&LONG)) {
        let mut took: Vec<Option<Took>> = vec![None; programs.len()];
        let mut printed = Vec::new();
        for _ in 0..(*repeats).max(1) {
            printed.clear();
            for ((program, place), least) in programs.iter().zip(&places).zip(&mut took) {
                let (once, text) = run(program, place, row.arguments)?;
                printed.push(text);
                *least = Some(least.map_or(once, |least| least.least(once)));
            }
        }
        done();
        let [this, before] = [0, 1].map(|place| took.get(place).copied().flatten());
        let is_same = match &printed[..] {
            [this, other] => Some((!row.prints || this == other) && is_same_file(row.writes, &places)?),
            _ => None,
        };
        commands.push(CommandTime {
            name: row.name.to_owned(),
            arguments: row.arguments.to_owned(),
            took: this.expect("it was run"),
            before,
            is_same,
        });
    }
    let samples = (*minutes * 60 * RATE_HZ / 2) as usize;
    let engine = measure(&Settings { samples, repeats: 3, twin_repeats: 0, ..Settings::default() })?;
    Ok(CommandTimes { minutes: *minutes, commands, engine_s: 6.0 * engine.total_s })
}

impl Took {
    fn least(self, other: Self) -> Self {
        Self {
            wall_s: self.wall_s.min(other.wall_s),
            processor_s: self.processor_s.min(other.processor_s),
            peak_bytes: self.peak_bytes.min(other.peak_bytes),
        }
    }
}

/// The named file has the same content in all places.
fn is_same_file(name: Option<&str>, places: &[PathBuf]) -> Result<bool, CommandError> {
    let Some(name) = name else { return Ok(true) };
    let texts = places.iter().map(|place| fs::read(place.join(name)).map_err(io("read what was written")));
    let texts = texts.collect::<Result<Vec<_>, _>>()?;
    Ok(texts.windows(2).all(|pair| pair[0] == pair[1]))
}

/// Hard link to the same file, which is only read: the logs are large.
fn link(from: &Path, to: &Path) -> Result<(), CommandError> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(io("make a folder"))?;
    }
    fs::hard_link(from, to).map_err(io("lay a log into a folder"))
}

/// Runs a command in `place` and returns its cost and output.
fn run(program: &Path, place: &Path, arguments: &str) -> Result<(Took, String), CommandError> {
    let output = place.join("printed");
    let printed = File::create(&output).map_err(io("make a file"))?;
    let errors = printed.try_clone().map_err(io("make a file"))?;
    let began = Instant::now();
    let child = Command::new(program)
        .args(arguments.split(' '))
        .current_dir(place)
        .stdin(Stdio::null())
        .stdout(printed)
        .stderr(errors)
        .spawn()
        .map_err(io(&format!("start {}", program.display())))?;
    let ended = child.wait4().map_err(io("wait for a command"))?;
    let wall_s = began.elapsed().as_secs_f64();
    let text = fs::read_to_string(&output).map_err(io("read what was printed"))?;
    if !ended.status.success() {
        return Err(CommandError::Failed {
            program: program.display().to_string(),
            arguments: arguments.to_owned(),
            last_line: text.lines().last().unwrap_or("nothing said").to_owned(),
        });
    }
    let ResourceUsage { utime, stime, maxrss, .. } = ended.rusage;
    Ok((Took { wall_s, processor_s: (utime + stime).as_secs_f64(), peak_bytes: maxrss }, text))
}

fn io(doing: &str) -> impl FnOnce(std::io::Error) -> CommandError {
    move |source| CommandError::Io { doing: doing.to_owned(), source }
}
