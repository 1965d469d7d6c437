//! Errors of loading and writing logs, each with a remedy.

use std::path::PathBuf;

use thiserror::Error;

use super::column_map::{MapError, quoted};
use super::format::Format;
use super::quality::BadRow;
use super::rate::RATES_HZ;
use crate::file::FileError;

/// Error of loading, using or writing a log.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// A format that this build excludes.
    #[error("{}: this build knows nothing of {feature}\nhelp: build fos-data with its feature {feature:?}, which is on by default", path.display())]
    NotBuiltIn {
        path: PathBuf,
        /// Cargo feature that includes the format.
        feature: &'static str,
    },
    /// The system refused to read or write.
    #[error(transparent)]
    File(#[from] FileError),
    /// An empty list of recordings.
    #[error("no log was given\nhelp: name at least one")]
    NothingToJoin,
    /// Recordings with different sampling rates.
    #[error(
        "{path} runs at {rate_hz:.3} Hz, the logs before it at {expected_hz:.3} Hz: the lags of one model cannot serve both\nhelp: fit them one by one"
    )]
    RatesDiffer {
        path: String,
        /// Rate of this log, Hz.
        rate_hz: f64,
        /// Rate of the others, Hz.
        expected_hz: f64,
    },
    /// Recordings of different sensors, or of differently corrected values.
    #[error(
        "{path} and {others} do not go together: the {sensor} of {others} are {here}, those of {path} {there}\nhelp: fit logs of one sensor, recorded in one way; `topic` chooses the sensor of a log"
    )]
    OtherSensor {
        path: String,
        others: String,
        /// Accelerometers or gyros.
        sensor: &'static str,
        /// Provenance of the logs before it, in words.
        here: Box<str>,
        /// Provenance of this log, in words.
        there: Box<str>,
    },
    /// A column whose header states a unit that cannot be read.
    #[error(
        "{}: column {column:?}: its header states the unit {unit:?}, which is none of {target}\nhelp: state it in the column map, as in '{target}={}:{example}'",
        path.display(), quoted(column)
    )]
    HeaderUnit {
        path: PathBuf,
        column: String,
        /// Unit stated in the header.
        unit: Box<str>,
        /// Channel of the column, such as `gx_rads`.
        target: &'static str,
        /// Example of a unit of the channel.
        example: &'static str,
    },
    /// Accelerometers whose values contradict their unit.
    #[error(
        "{}: the accelerometers are in {unit} by {stated}, and show {magnitude:.4} together (median), which is gravity in {fits}\nhelp: if they are in {fits}, map them: {}; if gravity is missing in them, record the accelerometers with gravity",
        path.display(), map.join(" ")
    )]
    GravityUnit {
        path: PathBuf,
        /// Stated unit.
        unit: Box<str>,
        stated: &'static str,
        /// Median of the magnitude, in the unit of the file.
        magnitude: f64,
        /// Unit in which the magnitude is gravity.
        fits: &'static str,
        /// Entries of a column map with that unit, in quotes.
        map: Box<[String]>,
    },
    /// Recordings without a channel in common.
    #[error(
        "{path} and {others} have no channel in common\nhelp: name their columns in the column map, as in gx_rads=gyro_x:dps"
    )]
    NothingInCommon { path: String, others: String },
    #[cfg(feature = "parquet")]
    /// Parquet that cannot be read or written.
    #[error("{}: Parquet: {source}\nhelp: if it was cut short while being written or copied, export or copy it again", path.display())]
    Parquet {
        path: PathBuf,
        /// Error of the library.
        source: parquet::errors::ParquetError,
    },
    /// Neither a table of text nor another known format.
    #[error("{}: {problem}\nhelp: a log is CSV (a header line, then numbers), gzip'd CSV or Parquet, or in a known format of others", path.display())]
    NotALog {
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// A known format that is no log.
    #[error("{}: {is}\nhelp: {help}", path.display())]
    OtherFormat {
        path: PathBuf,
        /// Description of the format, in a sentence.
        is: String,
        /// Instructions for converting it to a log.
        help: &'static str,
    },
    /// Not of the stated format.
    #[error("{}: it is not of the format {format} ({}): there are {}\nhelp: leave the format out, so that it is found by the content, or name the columns in the column map", path.display(), format.id(), available.join(", "))]
    NotOfFormat {
        path: PathBuf,
        format: Format,
        /// Columns of the file.
        available: Vec<String>,
    },
    /// A damaged file of a known format.
    #[error(
        "{}{}: the {format} is damaged: {problem}\nhelp: if it was cut short while being written or copied, copy it again",
        path.display(),
        at.map_or_else(String::new, |at| format!(", byte {at}"))
    )]
    Damaged {
        path: PathBuf,
        format: &'static str,
        /// Position of the damage, bytes from the begin.
        at: Option<u64>,
        /// Description of the damage.
        problem: String,
    },
    /// A known format without the required sensors.
    #[error("{}: {format}: {problem}\nhelp: {help}", path.display())]
    NoSensors {
        path: PathBuf,
        format: &'static str,
        /// Description of the missing and the existing data.
        problem: String,
        /// Data to record instead, or to choose.
        help: String,
    },
    /// Equally good candidates for a channel that hold different data.
    #[error(
        "{}: {problem}\nhelp: choose by a column map, {}",
        path.display(),
        maps.iter().map(|map| map.join(" ")).collect::<Vec<_>>().join("; or ")
    )]
    Undecided {
        path: PathBuf,
        /// The channels and their candidates.
        problem: String,
        /// Complete column maps, one per choice.
        maps: Vec<Vec<String>>,
    },
    /// A table without a header whose values do not determine the columns.
    #[error(
        "{}: it has no header{}; the medians of its columns are {shows}\nhelp: {}{}",
        path.display(),
        if *needs_rate { " and no column of time" } else { "" },
        if maps.is_empty() {
            "name its columns in the column map, as in gx_rads=column_1:dps".to_owned()
        } else {
            format!("choose by a column map, {}", maps.iter().map(|map| map.join(" ")).collect::<Vec<_>>().join("; or "))
        },
        if *needs_rate { "; and give the sample rate (`rate_hz`)" } else { "" }
    )]
    NoHeader {
        path: PathBuf,
        /// The columns and their medians.
        shows: String,
        /// Complete column maps, the most probable first.
        maps: Vec<Vec<String>>,
        /// True if there is no time either, and no stated rate.
        needs_rate: bool,
    },
    /// Alternating rows of two devices.
    #[error("{}: every second row differs in its stamp and in its values: the rows are of two devices in turn\nhelp: give the rows of each device as a log of its own, or record each on a topic of its own", path.display())]
    TwoDevices { path: PathBuf },
    /// An option without effect on this file.
    #[error("{}: {option} has no effect here: {offers}\nhelp: {help}", path.display())]
    NoEffect {
        path: PathBuf,
        /// The option and its value.
        option: String,
        /// Available alternatives in the file.
        offers: String,
        help: &'static str,
    },
    /// A folder or an archive with more than one log.
    #[error("{}: there is more than one log in it: {}\nhelp: choose one of them as the topic, as in {}, or give the logs one by one", path.display(), logs.join(", "), logs.first().map_or("", String::as_str))]
    SeveralLogs { path: PathBuf, logs: Vec<String> },
    /// A channel without a single number.
    #[error(
        "{path}: {name}: every cell of its {rows} rows is empty or not a number\nhelp: choose other axes, or name the column that holds it in the column map, as in {name}=column"
    )]
    NoValues {
        path: String,
        /// Channel in the log format, such as `gx_rads`.
        name: String,
        /// Number of rows of the log.
        rows: usize,
    },
    /// The device moves all along, and no true motion is logged.
    #[error(
        "{path}: the device moves from {from_s:.1} s to {to_s:.1} s: the 1-s means of {column} scatter by {scatter:.2} {unit}, those of a MEMS sensor at rest by less than {limit:.2} {unit}; {rest_s:.0} s at rest remain\nhelp: record the device lying still; or log its true motion in reference columns, as ref_gx_rads; or read the log with `keep_moved` if the device did lie still"
    )]
    Moves {
        path: String,
        /// Timestamp of the begin of the longest motion, s.
        from_s: f64,
        /// Timestamp of its end, s.
        to_s: f64,
        /// Axis with the largest motion, such as `gx_rads`.
        column: Box<str>,
        /// Scatter of its 1-s means, in `unit`.
        scatter: f64,
        /// Upper limit of a sensor at rest, in `unit`.
        limit: f64,
        /// Unit of scatter and limit: °/s or m/s².
        unit: &'static str,
        /// Remaining time at rest, s.
        rest_s: f64,
    },
    /// A compressed log that cannot be decompressed.
    #[error(
        "{}:{line}: it cannot be unpacked beyond this line: {source}\nhelp: if it was cut short while being written or copied, copy it again; `gzip -dc` unpacks what is there",
        path.display()
    )]
    NotUnpacked {
        path: PathBuf,
        /// Last readable line, from 1; 0 if there is none.
        line: u64,
        /// Error of the library.
        source: std::io::Error,
    },
    /// Rows out of the order of time.
    #[error("{}: {column} goes back {backs} times in {rows} rows: they are not in the order of time, or two logs are mixed\nhelp: sort the rows by {column}; give logs that were merged one by one", path.display())]
    OutOfOrder {
        path: PathBuf,
        /// Column of the timestamps.
        column: String,
        /// Number of times that it goes back by more than a sample.
        backs: u64,
        /// Total number of rows.
        rows: usize,
    },
    /// Two columns with one name.
    #[error("{}: two columns are named \"{name}\"\nhelp: rename one in the header", path.display())]
    DuplicateColumn {
        path: PathBuf,
        /// Name in the header.
        name: String,
    },
    /// A column named in the column map that does not exist.
    #[error("{}: the column map names \"{column}\", which the log does not have{}\nhelp: names are those of the header, with its capitals", path.display(), suggest(closest, available))]
    UnknownColumn {
        path: PathBuf,
        /// Name in the file or the column map.
        column: String,
        closest: Option<String>,
        /// Columns of the log.
        available: Vec<String>,
    },
    /// A column that must hold numbers holds text.
    #[error(
        "{}: column \"{column}\" is needed as numbers and holds text{}\nhelp: {}",
        path.display(),
        first.as_ref().map_or_else(String::new, |row| format!("; the first is {}:{row}", path.display())),
        if first.as_ref().is_some_and(|row| row.has_decimal_comma()) {
            "write decimals with a point: 0.25, not 0,25"
        } else {
            "check the header, map another column to it (target=column:unit), or leave it out (`columns` '!column')"
        }
    )]
    TextColumn {
        path: PathBuf,
        /// Name in the file or the column map.
        column: String,
        /// First cell of text in it; `None` in a file without lines.
        first: Option<Box<BadRow>>,
    },
    /// No timestamps, and no rate to replace them.
    #[error(
        "{}: no column t_s{}\nhelp: name the time column in the column map, as in t_s=time:ms, or give the sample rate (`rate_hz`) if there is none{}",
        path.display(),
        suggest(closest, available),
        perhaps_of(perhaps)
    )]
    NoTime {
        path: PathBuf,
        /// Column most similar to a time.
        closest: Option<String>,
        /// Columns of the log.
        available: Vec<String>,
        /// Column map entries that may be right.
        perhaps: Vec<String>,
    },
    /// Timestamps that do not run forward.
    #[error(
        "{}: the timestamps (column \"{column}\") do not increase, so there is no sample rate\nhelp: check the column map, or give the rate of the rows (`rate_hz`): it replaces invalid timestamps, such as those that a spreadsheet rounded to 1.40364E+18",
        path.display()
    )]
    NoClock {
        path: PathBuf,
        /// Column of the timestamps.
        column: String,
    },
    /// Timestamps in another unit than stated.
    #[error(
        "{}: by its timestamps (column \"{column}\") the log has a sample every {period_s:e} s, which no sensor gives\nhelp: name their unit in the column map, as in t_s={column}:ms, or give the rate of the rows (`rate_hz`), which replaces the stamps",
        path.display()
    )]
    NoSuchClock {
        path: PathBuf,
        /// Column of the timestamps.
        column: String,
        /// Time between two samples, s.
        period_s: f64,
    },
    #[error("a sample rate of {rate_hz:?} Hz is out of range\nhelp: give the samples per second, from {} to {}", RATES_HZ.start(), RATES_HZ.end())]
    BadRate { rate_hz: f64 },
    #[error("{}: {rows} usable rows\nhelp: a log has at least 2; was it cut short?", path.display())]
    TooFewRows {
        path: PathBuf,
        /// Number of usable rows.
        rows: usize,
    },
    /// An unusable row, in strict mode.
    #[error("{}:{row}\nhelp: correct or remove that row, or load without `strict` to skip such rows", path.display())]
    BadRow { path: PathBuf, row: Box<BadRow> },
    /// Too many unusable rows.
    #[error(
        "{}: {unusable} of {rows} rows cannot be used (at most {} % are skipped); the first is {}:{first}\nhelp: check the separator and the column map; a column that is not needed can be excluded (`columns` '!column')",
        path.display(),
        limit * 100.0,
        path.display()
    )]
    TooManyBadRows {
        path: PathBuf,
        /// Number of unusable rows.
        unusable: u64,
        /// Number of rows in the file.
        rows: u64,
        first: Box<BadRow>,
        /// Largest share that is skipped.
        limit: f64,
    },
    /// A channel that the recording does not have.
    #[error(
        "no channel \"{name}\"{}\nhelp: name a channel of the log, or map a column to it, as in gx_rads=column:unit",
        suggest(closest, available)
    )]
    NoChannel {
        /// Channel in the log format, such as `gx_rads`.
        name: String,
        closest: Option<String>,
        /// Channels of the recording.
        available: Vec<String>,
    },
    /// No usable inertial channel.
    #[error(
        "{path}: the log has none of the columns ax_mps2 … gz_rads as numbers{}\nhelp: name the column to take as the axis, or name the columns in the column map, as in gx_rads=gyro_x:dps{}",
        left_out(text_columns, first.as_deref()),
        perhaps_of(perhaps)
    )]
    NoAxes {
        path: String,
        /// Columns that hold text.
        text_columns: Vec<String>,
        /// First text found in one of them.
        first: Option<Box<BadRow>>,
        /// Column map entries that may be right.
        perhaps: Vec<String>,
    },
    /// Columns of different lengths.
    #[error(
        "column \"{name}\" has {found} values where the first has {expected}\nhelp: give all columns one length"
    )]
    Lengths {
        /// First column with another length.
        name: String,
        /// Number of values in the first column.
        expected: usize,
        found: usize,
    },
    /// A file name without the ending of a known output format.
    #[error("{}: cannot tell the format from the name\nhelp: end it in .csv, .csv.gz or .parquet", path.display())]
    UnknownFormat { path: PathBuf },
    /// An invalid column map.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl RecordingError {
    #[cfg(not(all(
        feature = "gzip",
        feature = "parquet",
        feature = "zip",
        feature = "ulog",
        feature = "dataflash",
        feature = "mcap",
        feature = "bag"
    )))]
    pub(super) fn not_built_in(path: &std::path::Path, feature: &'static str) -> Self {
        Self::NotBuiltIn { path: path.to_owned(), feature }
    }
}

/// Suggestion of a similar name, and the available names.
fn suggest(closest: &Option<String>, available: &[String]) -> String {
    let meant = closest.as_ref().map_or(String::new(), |name| format!(" (did you mean \"{name}\"?)"));
    format!("{meant}; there are {}", available.join(", "))
}

/// Column map entries that may be right, to be checked by the user.
fn perhaps_of(entries: &[String]) -> String {
    match entries {
        [] => String::new(),
        entries => format!("; by names and values it may be {}", entries.join(", ")),
    }
}

fn left_out(text_columns: &[String], first: Option<&BadRow>) -> String {
    let place = first.map_or_else(String::new, |row| format!("; the first is {row}"));
    match text_columns {
        [] => String::new(),
        names => format!("; excluded because they hold text: {}{place}", names.join(", ")),
    }
}
