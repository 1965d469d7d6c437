//! Requests and answers on populations, which are read again for every request and never changed.

use std::path::Path;
use std::sync::Arc;

use axum::extract::{Query, State};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::api::{Answer, Refused, answer, forbidden, not_found, wrong};
use super::folders::{Folders, Listed};
use super::workspace::Workspace;
use fos_data::file::open;
use fos_data::text::hexadecimal;
use fos_fleet::{Fleet, UnitRow, rows_beside};
use fos_report::fleet::{FleetReport, UnitReport};

/// A population, as `fos fleet report --json` prints it, and its units.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct PopulationPage {
    report: FleetReport,
    /// Units in the order of parts and names.
    units: Vec<UnitEntry>,
}

/// A unit in a list.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct UnitEntry {
    part: String,
    unit: String,
    lot: Option<String>,
}

/// A unit, and its log.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct UnitPage {
    report: UnitReport,
    /// Path by which its log is opened; none if it is not in a folder that may be read.
    log: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct Wanted {
    path: String,
}

#[derive(Deserialize)]
pub(super) struct UnitWanted {
    path: String,
    part: String,
    unit: String,
}

/// Lists the populations that may be opened.
pub(super) async fn listed(State(workspace): State<Arc<Workspace>>) -> Answer<Vec<Listed>> {
    answer(move || Ok(workspace.folders.populations())).await
}

pub(super) async fn population(
    State(workspace): State<Arc<Workspace>>,
    Query(Wanted { path }): Query<Wanted>,
) -> Answer<PopulationPage> {
    answer(move || {
        let (fleet, rows) = read(&workspace.folders, &path)?;
        let report = FleetReport::of(&fleet, &rows, Path::new(&path));
        let entry = |row: UnitRow| UnitEntry { part: row.part, unit: row.unit, lot: row.lot };
        Ok(PopulationPage { report, units: rows.into_iter().map(entry).collect() })
    })
    .await
}

pub(super) async fn unit(
    State(workspace): State<Arc<Workspace>>,
    Query(wanted): Query<UnitWanted>,
) -> Answer<UnitPage> {
    answer(move || {
        let (fleet, rows) = read(&workspace.folders, &wanted.path)?;
        let row = rows.iter().find(|row| row.unit == wanted.unit && row.part == wanted.part);
        let part = fleet.parts.iter().find(|part| part.part == wanted.part);
        let Some((row, part)) = row.zip(part) else {
            return Err(not_found(format!("{}: no unit {:?} in it", wanted.path, wanted.unit)));
        };
        Ok(UnitPage { report: UnitReport::of(row, part), log: log_of(row, &workspace.folders) })
    })
    .await
}

/// Reads a population and its rows, both in folders that may be read.
fn read(folders: &Folders, path: &str) -> Result<(Fleet, Vec<UnitRow>), Refused> {
    let population = folders.permitted(path).map_err(forbidden)?;
    let beside = rows_beside(&population);
    if beside.exists() {
        folders.permitted(&beside.display().to_string()).map_err(forbidden)?;
    }
    Fleet::read(&population).map_err(wrong)
}

/// Finds the log of a row: it has the unit's name, and the digest of the row.
fn log_of(row: &UnitRow, folders: &Folders) -> Option<String> {
    let mut logs = folders.logs_named(&row.unit).into_iter().map(|log| log.path);
    logs.find(|path| digest_of(Path::new(path)).is_some_and(|digest| digest == row.sha256))
}

fn digest_of(path: &Path) -> Option<String> {
    let (mut file, mut digest) = (open(path).ok()?, Sha256::new());
    let mut piece = vec![0; 1 << 16];
    loop {
        match std::io::Read::read(&mut file, &mut piece).ok()? {
            0 => return Some(hexadecimal(&digest.finalize())),
            length => digest.update(&piece[..length]),
        }
    }
}
