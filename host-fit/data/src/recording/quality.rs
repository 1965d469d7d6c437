//! What was wrong with a log, counted and placed.

use std::fmt;

use serde::Serialize;

use super::clock_check::ClockProblem;
use super::failed_reads::FailedReads;

/// How many rows that could not be used are kept with their place and content.
const PLACES_KEPT: usize = 5;

/// Longest content of a bad cell that is kept, characters.
const CONTENT_KEPT: usize = 40;

/// What was wrong with a log. All counts are zero for a clean one.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Quality {
    /// Data rows in the file, used or not (not the header, comments or blank lines).
    pub rows_in_file: u64,
    /// Rows that could not be used: a cell that is no number, a wrong number of cells, no time.
    pub rows_unusable: u64,
    /// The first few of them.
    pub first_unusable: Vec<BadRow>,
    /// Rows dropped since they repeat the stamp and the sample of the row before.
    pub rows_repeated: u64,
    /// Rows kept although their time stamp repeats the one before: the clock of the log is coarse.
    pub stamps_repeated: u64,
    /// Times that the stamps go back by more than one sample period.
    pub clock_back: u64,
    /// Empty or not finite cells, by column; only columns that have any.
    pub missing_cells: Vec<MissingCells>,
    /// Axes without a single number, which are left out: the recording has no channel of these names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub empty_axes: Vec<String>,
    /// Readings of thermometers that failed, by column; they read NaN.
    pub failed_reads: Vec<FailedReads>,
    /// Reasons why the stamps are not the time of the samples.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clock: Vec<ClockProblem>,
    /// Stretches of missing samples.
    pub gaps: u64,
    /// Samples missing in them, counted on the regular sample grid.
    pub samples_missing: u64,
    /// Times that nothing was recorded for a while, which is no loss.
    pub pauses: u64,
    /// How long in all, s.
    pub paused_s: f64,
    /// Columns that hold text and were left out.
    pub text_columns: Vec<String>,
    /// The first text that was seen in one of them, in a file with lines.
    pub first_text: Option<BadRow>,
    /// Entries of a column map that may be right, by names and values: nothing states them, and they are not followed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub perhaps: Vec<String>,
    /// Entries of a column map that were assumed by the values of a file without a header.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumed_map: Vec<String>,
}

/// Cells of one channel without a usable number; they read NaN.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissingCells {
    /// The column, as named in the file.
    pub column: String,
    /// Cells with nothing in them (also `NA`, `null`, `none`).
    pub empty: u64,
    /// Cells with NaN or an infinity.
    pub not_finite: u64,
}

/// A row that could not be used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BadRow {
    /// Line of a text, row of a table.
    pub place: Place,
    /// Name of the column that gave the reason, if one did.
    pub column: Option<String>,
    /// The content, shortened.
    pub content: String,
    /// What is wrong with it.
    pub problem: Problem,
}

/// Where a row is in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// Line of a text file, the first is 1, and the cell in it, the first is 1 (0: the whole line).
    Line { line: u64, cell: u64 },
    /// Data row, the first is 1; for files without lines.
    Row(u64),
}

/// Why a row could not be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Problem {
    NotANumber,
    /// The row has more or fewer cells than the header.
    CellCount {
        /// Cells in the header.
        expected: usize,
        /// Cells in the row.
        found: usize,
    },
    /// The time stamp is empty or not finite.
    NoTime,
}

impl BadRow {
    pub(super) fn new(place: Place, column: Option<&str>, content: &[u8], problem: Problem) -> BadRow {
        let content = String::from_utf8_lossy(content).chars().take(CONTENT_KEPT).collect();
        BadRow { place, column: column.map(str::to_owned), content, problem }
    }

    /// Whether a point instead of the comma would make it a number.
    pub(super) fn has_decimal_comma(&self) -> bool {
        self.content.contains(',') && self.content.replacen(',', ".", 1).parse::<f64>().is_ok()
    }
}

impl fmt::Display for BadRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Line { line, cell: 0 } => write!(f, "{line}: ")?,
            Place::Line { line, cell } => write!(f, "{line}:{cell}: ")?,
            Place::Row(row) => write!(f, "row {row}: ")?,
        }
        if let Some(column) = &self.column {
            write!(f, "{column}: ")?;
        }
        match self.problem {
            Problem::NotANumber => write!(f, "\"{}\" is not a number", self.content),
            Problem::CellCount { expected, found } => {
                write!(f, "{found} cells where the header has {expected}: \"{}\"", self.content)
            }
            Problem::NoTime => write!(f, "no time stamp"),
        }
    }
}

impl Quality {
    /// Counts a row that could not be used, and keeps it if it is among the first.
    pub(super) fn note_unusable(&mut self, row: BadRow) {
        self.rows_unusable += 1;
        if self.first_unusable.len() < PLACES_KEPT {
            self.first_unusable.push(row);
        }
    }
}

impl fmt::Display for Quality {
    /// One line per kind of trouble; nothing at all for a log without any.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = Vec::new();
        if self.rows_unusable > 0 {
            lines.push(format!(
                "{} of {} rows could not be read and were skipped",
                self.rows_unusable, self.rows_in_file
            ));
            lines.extend(self.first_unusable.iter().map(|row| format!("  {row}")));
        }
        let counts = [
            (self.rows_repeated, "rows repeat the one before and were dropped"),
            (self.stamps_repeated, "rows repeat the time stamp before them and were kept"),
            (self.clock_back, "times the stamps go back; where they stay back a segment ends"),
        ];
        lines.extend(counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
        if self.gaps > 0 {
            lines.push(format!("{} gaps: {} samples are missing", self.gaps, self.samples_missing));
        }
        if self.pauses > 0 {
            lines.push(format!(
                "{} pauses, {:.1} s in all, in which nothing was recorded",
                self.pauses, self.paused_s
            ));
        }
        for cells in &self.missing_cells {
            let MissingCells { column, empty, not_finite } = cells;
            lines.push(format!("{column}: {empty} cells empty, {not_finite} not finite"));
        }
        for axis in &self.empty_axes {
            lines.push(format!("{axis}: every cell is empty or not a number; this axis is excluded"));
        }
        if !self.text_columns.is_empty() {
            lines.push(format!("excluded columns of text: {}", self.text_columns.join(", ")));
        }
        f.write_str(&lines.join("\n"))
    }
}
