//! The devices in a folder: those of its `units.csv`, or one per log or case.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

use fos_data::case::{CaseError, CaseMeta};
use fos_data::file::{self, FileError};
use fos_data::recording::may_be_log;
use serde::Deserialize;

use crate::row::Unit;

/// File name of the table of a fleet.
pub const UNITS: &str = "units.csv";

/// A folder that cannot be read as a fleet.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("{}: {source}", path.display())]
    List { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Case(#[from] CaseError),
    #[error("{}:{line}: {reason}\nhelp: write a header `unit,part,lot,log`, then a line for each log of each device; part and lot may be empty, and paths of logs are relative to the table", path.display())]
    Table {
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        reason: String,
    },
    #[error("{}: no logs in it, nor in the folders in it\nhelp: put a log for each device into it, in a folder for each lot, or a table {UNITS} with a header `unit,part,lot,log`", .0.display())]
    Empty(PathBuf),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    unit: String,
    #[serde(default)]
    part: String,
    #[serde(default)]
    lot: Option<String>,
    log: PathBuf,
}

/// Returns the devices of a folder, by part and name.
///
/// With a table [`UNITS`] they are those of the table, whose logs need not exist; a device on several lines has a log on each. Otherwise
/// every log is a device with the name of the log, and its subfolder is the lot. A case folder, one with `meta.json`, is one device with
/// the logs of the case.
///
/// # Errors
///
/// The folder cannot be listed, its table cannot be read, a log of a unit occurs twice, a unit has two lots, or there are no devices.
pub fn units_in(folder: &Path) -> Result<Vec<Unit>, FolderError> {
    let table = folder.join(UNITS);
    let mut units = if table.is_file() { of_table(folder, &table)? } else { of_logs(folder)? };
    units.sort_by(|a, b| (&a.part, &a.name).cmp(&(&b.part, &b.name)));
    if units.is_empty() { Err(FolderError::Empty(folder.to_owned())) } else { Ok(units) }
}

fn of_table(folder: &Path, table: &Path) -> Result<Vec<Unit>, FolderError> {
    let wrong = |line: u64, reason: String| FolderError::Table { path: table.to_owned(), line, reason };
    let bytes = file::read(table)?;
    let mut lines = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let (mut units, mut places) = (Vec::<Unit>::new(), HashMap::new());
    for (index, line) in lines.deserialize::<Line>().enumerate() {
        let at = index as u64 + 2;
        let Line { unit, part, lot, log } =
            line.map_err(|error| wrong(error.position().map_or(at, csv::Position::line), error.to_string()))?;
        let (lot, log) = (lot.filter(|lot| !lot.is_empty()), folder.join(log));
        match places.entry((part.clone(), unit.clone())) {
            Entry::Vacant(entry) => {
                entry.insert(units.len());
                units.push(Unit { name: unit, part, lot, logs: vec![log] });
            }
            Entry::Occupied(entry) => {
                let known = &mut units[*entry.get()];
                if known.logs.contains(&log) {
                    return Err(wrong(
                        at,
                        format!("the device {unit:?} has the log {} twice", log.display()),
                    ));
                }
                if known.lot != lot {
                    let [one, other] =
                        [&known.lot, &lot].map(|lot| lot.as_deref().unwrap_or("none").to_owned());
                    return Err(wrong(at, format!("the device {unit:?} is of two lots: {one} and {other}")));
                }
                known.logs.push(log);
            }
        }
    }
    Ok(units)
}

fn of_logs(folder: &Path) -> Result<Vec<Unit>, FolderError> {
    if is_case(folder) {
        return Ok(vec![unit_of_case(folder, None)?]);
    }
    let mut units = Vec::new();
    for path in listed(folder)? {
        if is_case(&path) {
            units.push(unit_of_case(&path, None)?);
        } else if path.is_dir() {
            let lot = name_of(&path);
            for path in listed(&path)? {
                match is_case(&path) {
                    true => units.push(unit_of_case(&path, Some(&lot))?),
                    false => units.extend(unit_of(&path, Some(&lot))),
                }
            }
        } else {
            units.extend(unit_of(&path, None));
        }
    }
    Ok(units)
}

fn is_case(folder: &Path) -> bool {
    folder.join("meta.json").is_file()
}

fn unit_of_case(folder: &Path, lot: Option<&str>) -> Result<Unit, FolderError> {
    let logs = CaseMeta::read(folder)?.paths(folder)?;
    Ok(Unit { name: named(lot, name_of(folder)), part: String::new(), lot: lot.map(str::to_owned), logs })
}

/// Prefixes the lot: two lots may have devices of one name.
fn named(lot: Option<&str>, name: String) -> String {
    lot.map_or_else(|| name.clone(), |lot| format!("{lot}/{name}"))
}

fn unit_of(log: &Path, lot: Option<&str>) -> Option<Unit> {
    if !log.is_file() || !may_be_log(&log.to_string_lossy()) {
        return None;
    }
    let stem = log.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let lot_of = lot.map(str::to_owned);
    Some(Unit { name: named(lot, stem), part: String::new(), lot: lot_of, logs: vec![log.to_owned()] })
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let failed = |source| FolderError::List { path: folder.to_owned(), source };
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect())
        .map_err(failed)?;
    paths.sort_unstable();
    Ok(paths)
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touched(folder: &Path, names: &[&str]) {
        for name in names {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, "t_s,gx_rads\n").expect("a file");
        }
    }

    #[test]
    fn logs_are_units_and_subfolders_are_lots() {
        let folder = tempfile::tempdir().expect("a folder");
        touched(folder.path(), &["b/7.csv", "a/7.csv", "a/8.parquet", "alone.csv", "notes.md"]);
        let units = units_in(folder.path()).expect("devices");
        let named: Vec<_> = units.iter().map(|unit| (unit.name.as_str(), unit.lot.as_deref())).collect();
        assert_eq!(named, [("a/7", Some("a")), ("a/8", Some("a")), ("alone", None), ("b/7", Some("b"))]);
    }

    #[test]
    fn case_is_one_device_without_its_truth() {
        let folder = tempfile::tempdir().expect("a folder");
        let logs = ["reference.csv", "log.csv", "truth_log.csv"];
        for case in ["one", "w7/two"] {
            touched(folder.path(), &logs.map(|log| format!("{case}/{log}")).each_ref().map(String::as_str));
            let meta = r#"{"case": "x", "target": "gx_rads", "nominal_rate_hz": 200, "files": {"baseline": "reference", "field": "log"}}"#;
            std::fs::write(folder.path().join(case).join("meta.json"), meta).expect("a file");
        }
        let units = units_in(folder.path()).expect("devices");
        let named: Vec<_> =
            units.iter().map(|unit| (unit.name.as_str(), unit.lot.as_deref(), unit.logs.len())).collect();
        assert_eq!(named, [("one", None, 2), ("w7/two", Some("w7"), 2)]);
        let alone = units_in(&folder.path().join("one")).expect("a device");
        assert_eq!((alone[0].name.as_str(), alone[0].logs.len()), ("one", 2));
    }

    #[test]
    fn table_lists_units_and_errors_have_line_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |text: &str| std::fs::write(folder.path().join(UNITS), text).expect("a table");
        write("unit,part,lot,log\n7, bmi270, w12, x/7.csv\n8,,,8.csv\n");
        let units = units_in(folder.path()).expect("devices");
        assert_eq!((units[0].name.as_str(), units[0].lot.as_deref()), ("8", None));
        assert_eq!((units[1].part.as_str(), units[1].lot.as_deref()), ("bmi270", Some("w12")));
        assert_eq!(units[1].logs, [folder.path().join("x/7.csv")]);
        write("unit,part,lot,log\n7,,a,7.csv\n8,,a,8.csv\n7,,a,later.csv\n7,other,b,7.csv\n");
        let units = units_in(folder.path()).expect("devices");
        let logs: Vec<_> = units.iter().map(|unit| unit.logs.len()).collect();
        assert_eq!((logs, &units[0].logs[1]), (vec![2, 1, 1], &folder.path().join("later.csv")));
        for (table, line) in [
            ("unit,part,lot,log\n7,,,7.csv\n7,,,7.csv\n", ":3: the device \"7\" has the log "),
            ("unit,part,lot,log\n7,,a,7.csv\n7,,,8.csv\n", ":3: the device \"7\" is of two lots: a and none"),
            ("unit,part,lot\n7,,\n", ":2: "),
            ("unit,part,lot,log\n7,,,7.csv\n8,7.csv\n", ":3: "),
        ] {
            write(table);
            let error = units_in(folder.path()).expect_err("a wrong table").to_string();
            assert!(error.contains(line) && error.contains("help: "), "{error}");
        }
    }

    #[test]
    fn empty_folder_error_explains_the_layout() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(units_in(folder.path()).expect_err("nothing").to_string().contains("units.csv"));
        assert!(units_in(&folder.path().join("none")).is_err());
    }
}
