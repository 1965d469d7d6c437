//! Columns of numbers as stored in a file, before interpretation.

use std::path::Path;

use super::column_map::ColumnMap;
use super::error::RecordingError;
use super::quality::{BadRow, MissingCells, Place, Problem, Quality};

/// Columns of numbers of equal length. NaN: the cell is empty or not finite.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) columns: Vec<Column>,
    /// Skipped rows of the file, in order.
    pub(super) skipped: Vec<Skipped>,
    pub(super) quality: Quality,
    /// Columns of the file that a map ignores.
    pub(super) ignored: Vec<String>,
    /// The file has no header; columns are named by their position.
    pub(super) is_unnamed: bool,
}

#[derive(Debug)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) values: Vec<f64>,
}

/// Rows of the file skipped just before a row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Skipped {
    pub(super) before_row: usize,
    pub(super) rows: u64,
}

/// Returns true if text in this column is an error.
pub(super) fn must_be_numeric(name: &str, map: &ColumnMap) -> bool {
    map.uses(name) || (["t_s", "still"].contains(&name) && map.column_of(name) == name)
}

/// Names unnamed columns (the index column that some programs write) by their position, and replaces control characters,
/// which terminals would execute.
pub(super) fn column_name(raw: &str, index: usize) -> String {
    let shown = |letter: char| if letter.is_control() { char::REPLACEMENT_CHARACTER } else { letter };
    let name: String = raw.trim().chars().map(shown).collect();
    if name.is_empty() { format!("column_{}", index + 1) } else { name }
}

/// Rejects two columns of one name.
pub(super) fn check_names(path: &Path, names: &[String]) -> Result<(), RecordingError> {
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(RecordingError::DuplicateColumn { path: path.to_owned(), name: pair[0].clone() }),
        None => Ok(()),
    }
}

impl Table {
    pub(super) fn n_rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    pub(super) fn index_of(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Counts cells without a number; infinities become NaN.
    pub(super) fn note_missing_cells(&mut self, column: usize, empty: u64) {
        let column = &mut self.columns[column];
        let mut missing = 0;
        for value in column.values.iter_mut().filter(|value| !value.is_finite()) {
            missing += 1;
            if value.is_infinite() {
                *value = f64::NAN;
            }
        }
        if missing > 0 {
            let column = column.name.clone();
            self.quality.missing_cells.push(MissingCells { column, empty, not_finite: missing - empty });
        }
    }

    /// Drops rows whose cell in column `time` is NaN, since their time is unknown.
    pub(super) fn drop_rows_without_time(&mut self, time: usize) {
        let keep: Vec<bool> = self.columns[time].values.iter().map(|stamp| stamp.is_finite()).collect();
        if keep.iter().all(|&keep| keep) {
            return;
        }
        let mut skipped_before = self.skipped.iter().peekable();
        let mut skipped = Vec::new();
        let (mut kept, mut run, mut rows_skipped) = (0, 0, 0);
        for (row, &keep) in keep.iter().enumerate() {
            if let Some(found) = skipped_before.next_if(|found| found.before_row == row) {
                run += found.rows;
                rows_skipped += found.rows;
            }
            if keep {
                if run > 0 {
                    skipped.push(Skipped { before_row: kept, rows: run });
                }
                (kept, run) = (kept + 1, 0);
            } else {
                run += 1;
                let place = Place::Row(row as u64 + rows_skipped + 1);
                let name = self.columns[time].name.clone();
                self.quality.note_unusable(BadRow::new(place, Some(&name), b"", Problem::NoTime));
            }
        }
        self.skipped = skipped;
        self.keep_rows(&keep);
    }

    /// Keeps the rows marked in `keep`.
    pub(super) fn keep_rows(&mut self, keep: &[bool]) {
        for column in &mut self.columns {
            let mut marks = keep.iter();
            column.values.retain(|_| *marks.next().unwrap_or(&true));
        }
    }
}
