//! Arguments that several subcommands share.

use std::ffi::OsString;
use std::io::Read as _;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, first, print_warning, warning_in_words};
use super::units::{Printed, three};
use fos_data::recording::{ColumnMap, Format, LoadOptions, Rate, Recording, RecordingError, Stamps, load};
use fos_data::stillness::Stillness;
use fos_data::text::counted;
use fos_data::{disturbance, file};
use fos_diagnose::effects::{EffectError, Library};

/// A file that a command writes.
#[derive(Debug, Clone)]
pub(super) struct OutputFile(PathBuf);

/// A folder that a command writes into.
#[derive(Debug, Clone)]
pub(super) struct OutputFolder(PathBuf);

macro_rules! path {
    ($name:ident) => {
        impl From<OsString> for $name {
            fn from(path: OsString) -> Self {
                Self(path.into())
            }
        }

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }

        impl AsRef<Path> for $name {
            fn as_ref(&self) -> &Path {
                &self.0
            }
        }
    };
}

path!(OutputFile);
path!(OutputFolder);

/// # Errors
///
/// The name of the file has another ending than those of the formats that can be written. A name without one is taken.
pub(super) fn only_ends_in(path: &Path, option: &str, known: &[&str]) -> Result<(), Failure> {
    let Some(ending) = path.extension().and_then(|ending| ending.to_str()) else { return Ok(()) };
    if known.contains(&ending.to_ascii_lowercase().as_str()) {
        return Ok(());
    }
    let dotted: Vec<String> = known.iter().map(|one| format!(".{one}")).collect();
    Err(format!(
        "{option} {}: .{ending} cannot be written, only {}\nhelp: {option} {}",
        path.display(),
        dotted.join(" and "),
        path.with_extension(known[0]).display()
    )
    .into())
}

/// Options for reading a log.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct Reading {
    /// Read another column as one of the log format, converted: gx_rads=gyro_x:mdps, t_s=time:us,
    /// gx_rads=gx_cnt:*1.33e-4:rad/s; quote a column with a colon in its name, gx_rads="gyro:x":mdps. May be
    /// repeated
    #[arg(long = "map", id = "columns", value_name = "COLUMN=SOURCE[:ARITHMETIC][:UNIT]")]
    pub(super) map: Vec<String>,
    /// Column map from a TOML file
    #[arg(long, value_name = "FILE")]
    pub(super) map_file: Option<PathBuf>,
    /// The format of the log, if its content is ambiguous; `fos formats` lists them
    #[arg(long)]
    pub(super) format: Option<Format>,
    /// The sensor, if a log has several: the number of an instance, or the name of a topic
    #[arg(long, value_name = "NAME")]
    pub(super) topic: Option<String>,
    /// Sampling rate, Hz; needed if the log has no timestamps. It replaces timestamps that show another rate or are
    /// impossible; rows then count in their order
    #[arg(long = "rate", id = "rate_hz", value_name = "HZ")]
    pub(super) rate: Option<f64>,
    /// Refuse the first row that cannot be read instead of skipping and counting
    #[arg(long)]
    pub(super) strict: bool,
    /// Keep rows with detected motion (knocks, steps, hands)
    #[arg(long)]
    pub(super) keep_moved: bool,
}

impl Reading {
    /// Reads `log`.
    pub(super) fn read(&self, log: &Path) -> Result<Recording, Failure> {
        load_log(log, &self.options()?)
    }

    /// Reads a log of the arguments, with options from [`options_or`](Self::options_or). A sensor chosen for an earlier log does not
    /// apply to a log without a choice of sensors.
    pub(super) fn read_named(&self, log: &Path, read: &LoadOptions) -> Result<Recording, Failure> {
        let any_topic = LoadOptions { topic: None, ..read.clone() };
        match load(log, read) {
            Err(RecordingError::NoEffect { .. }) if self.topic.is_none() => load_log(log, &any_topic),
            found => found.map_err(|error| not_a_log(log, error)),
        }
    }

    /// Options as stated in the arguments.
    pub(super) fn options(&self) -> Result<LoadOptions, Failure> {
        let mut columns = match &self.map_file {
            Some(path) => ColumnMap::from_file(path)?,
            None => ColumnMap::default(),
        };
        for spec in &self.map {
            columns.add(spec)?;
        }
        Ok(LoadOptions {
            columns,
            rate_hz: self.rate,
            format: self.format,
            topic: self.topic.clone(),
            strict: self.strict,
            keep_moved: self.keep_moved,
        })
    }

    /// Options as stated in the arguments, with unstated columns and rate from `before`.
    pub(super) fn options_or(&self, before: &LoadOptions) -> Result<LoadOptions, Failure> {
        let given = self.options()?;
        Ok(LoadOptions {
            columns: if given.columns.is_empty() { before.columns.clone() } else { given.columns },
            rate_hz: given.rate_hz.or(before.rate_hz),
            format: given.format.or(before.format),
            topic: given.topic.or_else(|| before.topic.clone()),
            strict: given.strict,
            keep_moved: given.keep_moved || before.keep_moved,
        })
    }
}

/// The built-in effects and those of these files.
pub(super) fn library(files: &[PathBuf]) -> Result<Library, Failure> {
    Library::with_files(files).map_err(|error| match error {
        EffectError::NotAnEffect { place, reason } => format!(
            "{place}: not an effect: {reason}\nhelp: `fos effects --example` prints a complete file to start from"
        )
        .into(),
        _ => error.into(),
    })
}

fn load_log(log: &Path, options: &LoadOptions) -> Result<Recording, Failure> {
    load(log, options).map_err(|error| not_a_log(log, error))
}

/// Error for a file that is not a log, with a hint if it is a study.
fn not_a_log(log: &Path, error: RecordingError) -> Failure {
    match is_study(log) {
        true => format!(
            "{0}: a study, not a log\nhelp: give a log; `fos compare {0} LOG` and `fos diagnose {0} --from LOG` take both",
            log.display()
        )
        .into(),
        false => error.into(),
    }
}

/// The file begins like a study.
pub(super) fn is_study(path: &Path) -> bool {
    let mut begin = Vec::new();
    let Ok(file) = file::open(path) else { return false };
    file.take(200).read_to_end(&mut begin).is_ok()
        && begin.starts_with(b"{")
        && String::from_utf8_lossy(&begin).contains("fos-study/")
}

/// Reads several logs of one device as one recording.
pub(super) fn read_all(logs: &[PathBuf], options: &LoadOptions) -> Result<Recording, Failure> {
    let recordings = logs.iter().map(|log| load_log(log, options)).collect::<Result<Vec<_>, _>>()?;
    Ok(Recording::join(recordings)?)
}

/// Axes of `--axis`: one, several with commas, or all in the log.
pub(super) fn axes(recording: &Recording, names: &str) -> Result<Vec<String>, Failure> {
    if names != "all" {
        let axes: Result<Vec<String>, _> = names
            .split(',')
            .map(|name| recording.axis(name.trim()).map(|channel| channel.name.clone()))
            .collect();
        return Ok(axes?);
    }
    Ok(recording.axes()?)
}

/// Results of the axes in `names`. With all axes, one that cannot be used (for example stuck, or nearly empty) does not
/// prevent the others: it is excluded with a warning.
pub(super) fn usable<T, E: Into<Failure>>(
    names: &str,
    results: impl IntoIterator<Item = Result<T, E>>,
) -> Result<Vec<T>, Failure> {
    let (mut answers, mut refused) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(answer) => answers.push(answer),
            Err(error) if names == "all" => refused.push(error.into()),
            Err(error) => return Err(error.into()),
        }
    }
    if answers.is_empty() && !refused.is_empty() {
        return Err(refused.swap_remove(0));
    }
    refused.iter().for_each(print_excluded);
    Ok(answers)
}

/// Warns of an axis that is excluded.
pub(super) fn print_excluded(error: &Failure) {
    // the help of an error suggests the current command
    let message = error.to_string();
    print_warning(&format!("excluded: {}", message.split("\nhelp: ").next().unwrap_or_default()));
}

/// Description of a recording in a few lines.
pub(super) fn describe(recording: &Recording, stillness: &Stillness, printed: Printed) -> String {
    let rate = &recording.rate;
    let missing = recording.samples_missing();
    let read_as = recording.sources.iter().filter_map(|source| source.read_as.as_ref());
    let read_as: String = read_as.map(|read_as| format!("\n  {read_as}")).collect();
    format!(
        "{}: {} rows in {:.1} s, {}, {missing} samples missing{read_as}\n  true rate {:.4} Hz, {}{}",
        recording.paths(),
        recording.n_rows(),
        recording.duration_s(),
        counted(recording.segments.len(), "segment"),
        rate.true_hz,
        timestamps(rate),
        quality(recording, stillness, printed),
    )
}

fn timestamps(rate: &Rate) -> String {
    let kind = match rate.stamps {
        Stamps::Absent => return "no timestamps: the time is the row number over the rate".to_owned(),
        Stamps::Regular => "regular timestamps",
        Stamps::Jittered => "timestamps of every sample",
        Stamps::Bursts => "timestamps in bursts",
    };
    let jitter = match rate.jitter_s < 1e-3 {
        true => format!("{} µs", three(1e6 * rate.jitter_s)),
        false => format!("{} ms", three(1e3 * rate.jitter_s)),
    };
    format!("{kind} with {jitter} of jitter")
}

fn quality(recording: &Recording, stillness: &Stillness, printed: Printed) -> String {
    let quality = recording.quality.to_string();
    let options = Reading::augment_args(clap::Command::new("options"));
    let warnings = recording.warnings(&stillness.still).into_iter();
    let warnings =
        warnings.map(|warning| format!("caution: {}", warning_in_words(&warning, options.get_arguments())));
    let moved = disturbance::describe_disturbances(recording, &stillness.disturbances);
    let moved = first(moved, printed.at_most(3)).into_iter();
    let joined = recording.alignment.as_ref().map_or_else(String::new, ToString::to_string);
    let lines = joined.lines().chain(quality.lines()).map(str::to_owned).chain(warnings);
    lines.chain(moved.map(|moved| format!("motion: {moved}"))).map(|line| format!("\n  {line}")).collect()
}
