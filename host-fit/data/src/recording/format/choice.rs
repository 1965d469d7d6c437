//! Which of several sensors of a log is read, and what is said of the others.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::table::Table;
use super::Format;

/// The number of the instance that an option names, alone or after one of `names`; the first if it names none.
///
/// # Errors
///
/// It is no number.
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

/// What is said of the other ones of so many instances.
#[cfg(any(feature = "dataflash", feature = "ulog"))]
pub(super) fn other_instances(count: usize, taken: u8) -> String {
    let others: Vec<String> =
        (0..count).filter(|number| *number != usize::from(taken)).map(|number| number.to_string()).collect();
    others_too(&others)
}

/// What is said, behind the sensor that is read, of others by their names: nothing where there are none.
#[cfg(any(feature = "bag", feature = "dataflash", feature = "mcap", feature = "ulog"))]
pub(super) fn others_too(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!(" (there are {} too)", names.join(", ")) }
}

/// A device with fewer messages than one over this many of the fullest's is none: a damaged message may name any device, and so
/// few are no log of one. They are left out, never mixed in.
#[cfg(any(feature = "bag", feature = "mcap", feature = "ulog"))]
pub(super) const SELDOM: u64 = 100;

/// Refuses the choice of a sensor where there is none to choose.
///
/// # Errors
///
/// A topic is named; the error says what the file offers.
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

/// A table, for [`refuse_topic`].
pub(super) fn offers_of(table: &Table) -> String {
    format!("one table with the columns {}", table.names().join(", "))
}

/// Refuses a log that is damaged, or of which some messages cannot be read, where the user wants none skipped.
///
/// # Errors
///
/// `strict`, and there is damage or an unreadable message.
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

/// What is missing in a log of `format`, what is there, and what to record instead.
pub(super) fn no_sensors(path: &Path, format: Format, problem: String, help: &str) -> RecordingError {
    RecordingError::NoSensors {
        path: path.to_owned(),
        format: format.knowledge().name,
        problem,
        help: help.to_owned(),
    }
}
