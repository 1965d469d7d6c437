//! Which of several sensors of a log is read, and what is said of the others.

use std::path::Path;

use super::super::error::RecordingError;
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
pub(super) fn others_too(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!(" (there are {} too)", names.join(", ")) }
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
