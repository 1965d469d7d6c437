//! Choice among several sensors of a log, and the description of the others.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::table::Table;
use super::Format;

/// Instance number in an option, alone or after one of `names`; the first instance by default.
#[cfg(any(feature = "dataflash", feature = "ulog"))]
pub(super) fn instance(
    path: &Path,
    format: Format,
    topic: Option<&str>,
    names: &[&str],
) -> Result<u8, RecordingError> {
    let Some(topic) = topic else { return Ok(0) };
    let number = names.iter().fold(topic, |rest, name| rest.trim_start_matches(name));
    number.trim().parse().map_err(|_| {
        let problem = format!("there is no instance \"{topic}\"");
        no_sensors(path, format, problem, "name the number of an instance, as in 1")
    })
}

/// Names the other instances out of `count`.
#[cfg(any(feature = "dataflash", feature = "ulog"))]
pub(super) fn other_instances(count: usize, taken: u8) -> String {
    let others: Vec<String> =
        (0..count).filter(|number| *number != usize::from(taken)).map(|number| number.to_string()).collect();
    others_too(&others)
}

/// Names other sensors after the chosen one; empty if there are none.
#[cfg(any(feature = "bag", feature = "dataflash", feature = "mcap", feature = "ulog"))]
pub(super) fn others_too(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!(" (there are {} too)", names.join(", ")) }
}

/// A device with fewer messages than one over this many of the fullest's is ignored: a damaged message may name any
/// device, and so few are no log of one. They are excluded, never mixed in.
#[cfg(any(feature = "bag", feature = "mcap", feature = "ulog"))]
pub(super) const SELDOM: u64 = 100;

/// Rejects the choice of a sensor if there is nothing to choose.
pub(super) fn refuse_topic(path: &Path, options: &LoadOptions, offers: &str) -> Result<(), RecordingError> {
    match &options.topic {
        None => Ok(()),
        Some(topic) => Err(RecordingError::NoEffect {
            path: path.to_owned(),
            option: format!("topic \"{topic}\""),
            offers: format!("the file is {offers}"),
            help: "leave the topic out",
        }),
    }
}

/// Description of a table, for [`refuse_topic`].
pub(super) fn describe_table(table: &Table) -> String {
    format!("one table with the columns {}", table.names().join(", "))
}

/// Rejects a log that is damaged, or has unreadable messages, if the user wants none skipped.
pub(super) fn refuse_damage(
    path: &Path,
    format: Format,
    strict: bool,
    damage: Option<&str>,
    unreadable: u64,
) -> Result<(), RecordingError> {
    let problem = match (damage, unreadable) {
        (Some(damage), _) => damage.to_owned(),
        (None, 0) => return Ok(()),
        (None, n) => format!("{n} messages cannot be read"),
    };
    let format = format.knowledge().name;
    if strict {
        Err(RecordingError::Damaged { path: path.to_owned(), format, at: None, problem })
    } else {
        Ok(())
    }
}

/// Error for a log of `format` without the required sensors: the problem, and data to record instead.
pub(super) fn no_sensors(path: &Path, format: Format, problem: String, help: &str) -> RecordingError {
    RecordingError::NoSensors {
        path: path.to_owned(),
        format: format.knowledge().name,
        problem,
        help: help.to_owned(),
    }
}
