//! The rows of a fleet, each computed once and stored at once.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use fos_data::file::keyed_rows::{KeyedRow, KeyedRows, KeyedRowsError};
use fos_data::text::hexadecimal;
use fos_diagnose::effects::Library;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::row::{Asked, Unit, UnitRow, unit_row};

/// Path of the rows of `population`: the same name with `.rows` appended.
pub fn rows_beside(population: &Path) -> PathBuf {
    let mut path = population.as_os_str().to_owned();
    path.push(".rows");
    path.into()
}

/// Returns the rows of `units`, in their order. Each new row is appended to `rows_path` at once as a line of JSON; a stored row is reused if
/// its logs, the settings, the library and the program are unchanged. `build` distinguishes builds of one version. `progress` receives the
/// number of finished rows.
///
/// A unit that cannot be read is no error: its row has the reason.
pub fn rows(
    units: &[Unit],
    asked: &Asked,
    library: &Library,
    program: &str,
    build: &str,
    rows_path: &Path,
    progress: impl Fn(usize) + Sync,
) -> Result<Vec<UnitRow>, KeyedRowsError> {
    let (stored, done) = (KeyedRows::<UnitRow>::open(rows_path)?, AtomicUsize::new(0));
    let rows: Vec<KeyedRow<UnitRow>> = units
        .par_iter()
        .map(|unit| {
            let key = key(unit, asked, library, build);
            let row = match stored.get(&key) {
                Some(row) => KeyedRow { key, row: row.clone() },
                None => {
                    let row = KeyedRow { key, row: unit_row(unit, asked, library, program) };
                    stored.append(&row)?;
                    row
                }
            };
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ok(row)
        })
        .collect::<Result<_, KeyedRowsError>>()?;
    // in the order of the units, one line each
    stored.replace(&rows)?;
    Ok(rows.into_iter().map(|stored| stored.row).collect())
}

/// Digest of everything a row depends on: name, size and modification time of its logs, settings, program and library.
fn key(unit: &Unit, asked: &Asked, library: &Library, build: &str) -> String {
    let of_file =
        |log: &PathBuf| std::fs::metadata(log).ok().map(|about| (about.len(), about.modified().ok()));
    let about: Vec<_> = unit.logs.iter().map(of_file).collect();
    let mut digest = Sha256::new();
    digest.update(format!("{build} {unit:?} {about:?}"));
    digest.update(serde_json::to_vec(asked).unwrap_or_default());
    if asked.diagnosed {
        digest.update(serde_json::to_vec(library.effects()).unwrap_or_default());
    }
    hexadecimal(&digest.finalize())
}
