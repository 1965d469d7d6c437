//! Defects of a log, counted and located.

use std::fmt;

use crate::text::counted;

use super::clock_check::ClockProblem;
use super::failed_reads::FailedReads;

/// Number of unusable rows stored with their position and content.
const PLACES_KEPT: usize = 5;

/// Longest stored content of a bad cell, characters.
const CONTENT_KEPT: usize = 40;

/// Defects of a log. All counts are zero for a clean one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quality {
    /// Data rows in the file, used or not (not the header, comments or blank lines).
    pub rows_in_file: u64,
    /// Unusable rows: a cell that is no number, a wrong number of cells, no time.
    pub rows_unusable: u64,
    /// First few unusable rows.
    pub first_unusable: Vec<BadRow>,
    /// Rows dropped since they repeat the timestamp and the sample of the previous row.
    pub rows_repeated: u64,
    /// Rows kept although they repeat the previous timestamp: the clock of the log is coarse.
    pub stamps_repeated: u64,
    /// Number of times that the timestamps go back by more than one sample period.
    pub clock_back: u64,
    /// Empty or not finite cells, by column; only columns that have any.
    pub missing_cells: Vec<MissingCells>,
    /// Axes without a single number, which are excluded: the recording has no channel of these names.
    pub empty_axes: Vec<String>,
    /// Failed reads of thermometers, by column; they read NaN.
    pub failed_reads: Vec<FailedReads>,
    /// Reasons why the timestamps are not the time of the samples.
    pub clock: Vec<ClockProblem>,
    /// Number of stretches of missing samples.
    pub gaps: u64,
    /// Samples missing in them, counted on the regular sample grid.
    pub samples_missing: u64,
    /// Number of pauses in which nothing was recorded, without loss.
    pub pauses: u64,
    /// Total duration of the pauses, s.
    pub paused_s: f64,
    /// Columns of text, which are ignored.
    pub text_columns: Vec<String>,
    /// First text found in one of them, in a file with lines.
    pub first_text: Option<BadRow>,
    /// Column map entries that may be right, by names and values: they are suggestions, and not applied.
    pub perhaps: Vec<String>,
    /// Column map entries inferred from the values of a file without a header.
    pub assumed_map: Vec<String>,
}

/// Cells of one channel without a usable number; they read NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingCells {
    /// Column name in the file.
    pub column: String,
    /// Number of empty cells (also `NA`, `null`, `none`).
    pub empty: u64,
    /// Number of cells with NaN or an infinity.
    pub not_finite: u64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct BadRow {
    /// Line of a text, row of a table.
    pub place: Place,
    pub column: Option<String>,
    /// Content, shortened.
    pub content: String,
    pub problem: Problem,
}

/// Position of a row in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, from 1, and cell in it, from 1 (0: the whole line).
    Line { line: u64, cell: u64 },
    /// Data row, from 1; for files without lines.
    Row(u64),
}

/// Reason why a row is unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    NotANumber,
    /// The row has more or fewer cells than the header.
    CellCount {
        expected: usize,
        found: usize,
    },
    /// The timestamp is empty or not finite.
    NoTime,
}

impl BadRow {
    pub(super) fn new(place: Place, column: Option<&str>, content: &[u8], problem: Problem) -> BadRow {
        let content = String::from_utf8_lossy(content).chars().take(CONTENT_KEPT).collect();
        BadRow { place, column: column.map(str::to_owned), content, problem }
    }

    /// Returns true if a point instead of the comma would make it a number.
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
    /// Counts an unusable row, and stores it if it is among the first.
    pub(super) fn note_unusable(&mut self, row: BadRow) {
        self.rows_unusable += 1;
        if self.first_unusable.len() < PLACES_KEPT {
            self.first_unusable.push(row);
        }
    }
}

impl fmt::Display for Quality {
    /// Writes one line per kind of defect; nothing for a log without any.
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
            (self.rows_repeated, "repeated row", "dropped"),
            (self.stamps_repeated, "repeated timestamp", "with different values: kept"),
            (self.clock_back, "backward jump", "of the timestamps; a segment ends where they stay back"),
        ];
        let counts = counts.into_iter().filter(|(n, ..)| *n > 0);
        lines.extend(counts.map(|(n, one, then)| format!("{} {then}", counted(n as usize, one))));
        if self.gaps > 0 {
            let missing = counted(self.samples_missing as usize, "missing sample");
            lines.push(format!("{} with {missing}", counted(self.gaps as usize, "gap")));
        }
        if self.pauses > 0 {
            let pauses = counted(self.pauses as usize, "pause");
            lines.push(format!("{pauses} in the recording, {:.1} s in total", self.paused_s));
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
