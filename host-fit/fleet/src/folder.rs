//! The units in a folder: those of its `units.csv`, or a log each.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

use fos_data::file::{self, FileError};
use fos_data::recording::may_be_log;
use serde::Deserialize;

use crate::row::Unit;

/// The table of a fleet.
pub const UNITS: &str = "units.csv";

/// Why a folder is no fleet.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("{}: {source}", path.display())]
    List {
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Its table cannot be opened.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its table cannot be read.
    #[error("{}:{line}: {reason}\nhelp: a header `unit,part,lot,log`, then a line for each log of each unit; part and lot may be empty, and logs are looked for beside the table", path.display())]
    Table {
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        reason: String,
    },
    #[error("{}: no logs in it, nor in the folders in it\nhelp: a log for each unit, in a folder for each lot, or a table {UNITS} with a header `unit,part,lot,log`", .0.display())]
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

/// The units of a folder, by name.
///
/// With a table [`UNITS`] those that it names, whose logs need not be there: a unit on several lines has a log on each. Else every log is a unit of its name, and the folder that it
/// lies in, within `folder`, its lot.
///
/// # Errors
///
/// The folder cannot be listed, its table cannot be read, names a log of a unit twice or a unit in two lots, or there is nothing.
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
                    return Err(wrong(at, format!("the unit {unit:?} has the log {} twice", log.display())));
                }
                if known.lot != lot {
                    let [one, other] =
                        [&known.lot, &lot].map(|lot| lot.as_deref().unwrap_or("none").to_owned());
                    return Err(wrong(at, format!("the unit {unit:?} is of two lots: {one} and {other}")));
                }
                known.logs.push(log);
            }
        }
    }
    Ok(units)
}

fn of_logs(folder: &Path) -> Result<Vec<Unit>, FolderError> {
    let mut units = Vec::new();
    for path in listed(folder)? {
        if path.is_dir() {
            let lot = name_of(&path);
            units.extend(listed(&path)?.iter().filter_map(|log| unit_of(log, Some(&lot))));
        } else {
            units.extend(unit_of(&path, None));
        }
    }
    Ok(units)
}

fn unit_of(log: &Path, lot: Option<&str>) -> Option<Unit> {
    if !log.is_file() || !may_be_log(&log.to_string_lossy()) {
        return None;
    }
    let stem = log.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    // two lots may have logs of one name
    let name = lot.map_or_else(|| stem.clone(), |lot| format!("{lot}/{stem}"));
    Some(Unit { name, part: String::new(), lot: lot.map(str::to_owned), logs: vec![log.to_owned()] })
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
    fn a_log_is_a_unit_and_its_folder_a_lot() {
        let folder = tempfile::tempdir().expect("a folder");
        touched(folder.path(), &["b/7.csv", "a/7.csv", "a/8.parquet", "alone.csv", "notes.md"]);
        let units = units_in(folder.path()).expect("units");
        let named: Vec<_> = units.iter().map(|unit| (unit.name.as_str(), unit.lot.as_deref())).collect();
        assert_eq!(named, [("a/7", Some("a")), ("a/8", Some("a")), ("alone", None), ("b/7", Some("b"))]);
    }

    #[test]
    fn a_table_names_units_and_what_is_wrong_with_it_is_said_with_its_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |text: &str| std::fs::write(folder.path().join(UNITS), text).expect("a table");
        write("unit,part,lot,log\n7, bmi270, w12, x/7.csv\n8,,,8.csv\n");
        let units = units_in(folder.path()).expect("units");
        assert_eq!((units[0].name.as_str(), units[0].lot.as_deref()), ("8", None));
        assert_eq!((units[1].part.as_str(), units[1].lot.as_deref()), ("bmi270", Some("w12")));
        assert_eq!(units[1].logs, [folder.path().join("x/7.csv")]);
        write("unit,part,lot,log\n7,,a,7.csv\n8,,a,8.csv\n7,,a,later.csv\n7,other,b,7.csv\n");
        let units = units_in(folder.path()).expect("units");
        let logs: Vec<_> = units.iter().map(|unit| unit.logs.len()).collect();
        assert_eq!((logs, &units[0].logs[1]), (vec![2, 1, 1], &folder.path().join("later.csv")));
        for (table, line) in [
            ("unit,part,lot,log\n7,,,7.csv\n7,,,7.csv\n", ":3: the unit \"7\" has the log "),
            ("unit,part,lot,log\n7,,a,7.csv\n7,,,8.csv\n", ":3: the unit \"7\" is of two lots: a and none"),
            ("unit,part,lot\n7,,\n", ":2: "),
            ("unit,part,lot,log\n7,,,7.csv\n8,7.csv\n", ":3: "),
        ] {
            write(table);
            let error = units_in(folder.path()).expect_err("a wrong table").to_string();
            assert!(error.contains(line) && error.contains("help: "), "{error}");
        }
    }

    #[test]
    fn an_empty_folder_says_what_belongs_in_it() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(units_in(folder.path()).expect_err("nothing").to_string().contains("units.csv"));
        assert!(units_in(&folder.path().join("none")).is_err());
    }
}
