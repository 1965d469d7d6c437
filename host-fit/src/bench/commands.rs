//! What whole commands take, as somebody waits for them, beside those of another build of the program in the same run.
//!
//! Both run in turn, in folders of the same names, so that what they write can be held against each other byte by byte.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::Serialize;
use wait4::{ResourceUsage, Wait4};

use super::{BenchError, Settings, measure};

/// What is run.
#[derive(Debug, Clone)]
pub struct CommandSettings {
    /// Length of the logs, min.
    pub minutes: u32,
    /// Length of a long log that is fitted too, h; 0 for none.
    pub long_hours: u32,
    /// Runs of each command; the least time counts.
    pub repeats: usize,
    /// Another build of the program.
    pub against: Option<PathBuf>,
}

/// What the commands took.
#[derive(Debug, Clone, Serialize)]
pub struct CommandTimes {
    /// Length of the logs, min.
    pub minutes: u32,
    /// In the order in which they were run.
    pub commands: Vec<CommandTime>,
    /// Moments, search and refit of six axes over the rows that `fit` fits, on one thread, s: what nothing else of a fit is for.
    pub engine_s: f64,
}

/// What one command took.
#[derive(Debug, Clone, Serialize)]
pub struct CommandTime {
    /// What it does.
    pub name: String,
    /// Its arguments.
    pub arguments: String,
    /// By this build.
    pub took: Took,
    /// By the other one.
    pub before: Option<Took>,
    /// Whether both wrote and said the same; none without another build.
    pub is_same: Option<bool>,
}

/// The least of several runs.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Took {
    /// From its start to its end, s.
    pub wall_s: f64,
    /// Of all threads, in the program and in the system, s.
    pub processor_s: f64,
    /// Most memory at a time, bytes; 0 where the system does not say.
    pub peak_bytes: u64,
}

/// Why the commands could not be timed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A file or a process.
    #[error("{doing}: {source}")]
    Io {
        /// What was being done.
        doing: String,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A command ended with an error of its own.
    #[error(
        "{program} {arguments}: {said}\nhelp: run it by hand; `against` takes a program that knows the same commands"
    )]
    Failed {
        /// The program.
        program: String,
        /// What it was given.
        arguments: String,
        /// Its last line.
        said: String,
    },
    /// The engine alone.
    #[error(transparent)]
    Bench(#[from] BenchError),
}

/// A command of the table.
struct Row {
    name: &'static str,
    arguments: &'static str,
    /// The file that it writes, if one run writes the same as the next.
    writes: Option<&'static str>,
    /// What it prints is the same, but for times.
    prints: bool,
}

/// Commands that are timed, without the long log.
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

/// Samples a second of the logs.
const RATE_HZ: u32 = 200;

/// Makes logs in `folder`, runs every command over them as a process, by this build and by the other in turn.
///
/// # Errors
///
/// A process cannot be started or ends with an error, or a file cannot be written.
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
        let mut said = Vec::new();
        for _ in 0..(*repeats).max(1) {
            said.clear();
            for ((program, place), least) in programs.iter().zip(&places).zip(&mut took) {
                let (once, text) = run(program, place, row.arguments)?;
                said.push(text);
                *least = Some(least.map_or(once, |least| least.least(once)));
            }
        }
        done();
        let [this, before] = [0, 1].map(|place| took.get(place).copied().flatten());
        let is_same = match &said[..] {
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

/// Whether a file that each place has says the same.
fn is_same_file(name: Option<&str>, places: &[PathBuf]) -> Result<bool, CommandError> {
    let Some(name) = name else { return Ok(true) };
    let texts = places.iter().map(|place| fs::read(place.join(name)).map_err(io("read what was written")));
    let texts = texts.collect::<Result<Vec<_>, _>>()?;
    Ok(texts.windows(2).all(|pair| pair[0] == pair[1]))
}

/// The same file, read only, under another path: the logs are large.
fn link(from: &Path, to: &Path) -> Result<(), CommandError> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(io("make a folder"))?;
    }
    fs::hard_link(from, to).map_err(io("lay a log into a folder"))
}

/// Runs a command in `place`: what it took and what it printed.
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
            said: text.lines().last().unwrap_or("nothing said").to_owned(),
        });
    }
    let ResourceUsage { utime, stime, maxrss, .. } = ended.rusage;
    Ok((Took { wall_s, processor_s: (utime + stime).as_secs_f64(), peak_bytes: maxrss }, text))
}

fn io(doing: &str) -> impl FnOnce(std::io::Error) -> CommandError {
    move |source| CommandError::Io { doing: doing.to_owned(), source }
}
