//! The built-in example: three logs of a simulated device with hidden effects, written as files so that the command
//! lines on the page can be used.

use std::path::Path;

use fos_data::file::make_folder;
use fos_data::recording::LoadOptions;
use fos_diagnose::refine::Logs;
use fos_simulate::hidden_effects;

pub(super) use fos_simulate::HIDDEN_IN as AXIS;

/// Seed of the example.
const SEED: u64 = 1;

/// Writes and reads the logs.
///
/// # Errors
///
/// The folder cannot be written.
pub(super) fn logs(folder: &Path) -> Result<Logs, String> {
    make_folder(folder).map_err(|error| error.to_string())?;
    let [reference, log, later] = hidden_effects(folder, SEED).map_err(|error| error.to_string())?;
    Ok(Logs { log, reference: Some(reference), evaluation: Some(later), read: LoadOptions::default() })
}
