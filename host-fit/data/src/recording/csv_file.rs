//! Reads CSV: a header line, then a row of numbers per line.
//!
//! Lines are split here rather than by a CSV library, so that damage stays within its line: an unpaired quotation mark
//! must not swallow the rows after it. Only a line with quotation marks goes through the library.
//!
//! Lines end in LF or CRLF, or in CR in a text without LF. A line is at most a megabyte long: a longer one, which an
//! open quotation mark may cause in a library, is rejected before it takes memory.
//!
//! The header is the first line, or below titles, the line above the first row of numbers (`header`). The separator is
//! the most frequent one in the header: comma, semicolon or tab, or spaces if only they separate numbers; unless it is
//! the separator, a comma in a number is the decimal point. A row of units below the names is appended to them. A text
//! that begins with numbers has no header: its columns are named `column_1` and so on. Blank lines and lines that start
//! with `#` are skipped. Empty cells, `NA`, `null` and `none` are empty; `true` and `false` are 1 and 0.

use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use std::path::Path;

use super::cell::{Cell, Cells, parse_cell};
use super::column_map::ColumnMap;
use super::error::RecordingError;
use super::header::{self, Header, not_a_log};
use super::other_format;
use super::quality::{BadRow, Place, Problem};
use super::table::{Column, Skipped, Table, must_be_numeric};
use crate::file::FileError;
use crate::interrupt;

/// Longest line of a row, bytes. A file with longer lines is no table of samples.
const LONGEST_LINE: u64 = 1 << 20;

/// Byte order mark that some programs write before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Number of lines between checks for a stop request: some milliseconds.
const LINES_BETWEEN_CHECKS: u64 = 8192;

/// Number of rows examined to distinguish text columns from numbers with damaged cells.
const ROWS_TO_CLASSIFY: usize = 1000;

/// Approximate limit of their size, bytes: they are held in memory until the columns are known.
const BYTES_TO_CLASSIFY: usize = 1 << 24;

/// Reads a whole file; `input` decompresses it if needed. In `strict` mode the first unusable row is an error.
pub(super) fn read(
    path: &Path,
    input: impl BufRead,
    map: &ColumnMap,
    strict: bool,
    is_packed: bool,
) -> Result<Table, RecordingError> {
    let mut lines = Lines::begin(input, path, is_packed)?;
    let mut line = Vec::new();

    // the first lines are stored as text, to determine the header and the text columns
    let (mut first_lines, mut kept) = (Vec::new(), 0);
    while first_lines.len() < ROWS_TO_CLASSIFY && kept < BYTES_TO_CLASSIFY && lines.next(&mut line)? {
        kept += line.len();
        first_lines.push((lines.number, line.clone()));
    }
    if first_lines.is_empty() {
        return Err(not_a_log(path, "the file is empty".into()));
    }
    let header = header::take(path, lines.comment.take(), &mut first_lines)?;
    let mut parser = Parser::new(path, map, &header, &first_lines)?;
    let mut take = |number, line: &[u8]| match parser.take(number, line) {
        Ok(()) => Ok(()),
        Err(row) if strict => Err(RecordingError::BadRow { path: path.to_owned(), row: Box::new(row) }),
        Err(row) => {
            parser.skip(row);
            Ok(())
        }
    };
    for (number, line) in &first_lines {
        take(*number, line)?;
    }
    drop(first_lines);
    while lines.next(&mut line)? {
        take(lines.number, &line)?;
    }
    parser.finish()
}

/// Lines that may hold data, without their line ends.
struct Lines<'a, R> {
    /// The bytes examined to determine the line ends, followed by the remaining input.
    input: io::Chain<io::Cursor<Vec<u8>>, R>,
    /// Byte that ends a line.
    end: u8,
    /// Number of the last line read, from 1.
    number: u64,
    /// The comment above the first other line: some programs write their header so.
    comment: Option<Vec<u8>>,
    has_line: bool,
    path: &'a Path,
    is_packed: bool,
}

impl<'a, R: BufRead> Lines<'a, R> {
    fn begin(mut input: R, path: &'a Path, is_packed: bool) -> Result<Self, RecordingError> {
        let mut begin = Vec::new();
        let read = (&mut input).take(LONGEST_LINE).read_until(b'\n', &mut begin);
        let only_cr = begin.contains(&b'\r') && !begin.contains(&b'\n');
        let end = if only_cr { b'\r' } else { b'\n' };
        if let Some((is, help)) = other_format::known_text(&begin) {
            return Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help });
        }
        let input = io::Cursor::new(begin).chain(input);
        let lines = Self { input, end, number: 0, comment: None, has_line: false, path, is_packed };
        match read {
            Ok(_) => Ok(lines),
            Err(error) => Err(lines.failed(error)),
        }
    }

    fn failed(&self, source: io::Error) -> RecordingError {
        if self.is_packed && is_damage(&source) {
            let (path, line) = (self.path.to_owned(), self.number);
            return RecordingError::NotUnpacked { path, line, source };
        }
        FileError::reading(self.path)(source).into()
    }

    /// Reads the next line that is not blank or a comment; returns false at the end of the file.
    fn next(&mut self, line: &mut Vec<u8>) -> Result<bool, RecordingError> {
        loop {
            line.clear();
            let n = match (&mut self.input).take(LONGEST_LINE).read_until(self.end, line) {
                Ok(n) => n,
                Err(source) => return Err(self.failed(source)),
            };
            if n == 0 {
                return Ok(false);
            }
            self.number += 1;
            if self.number.is_multiple_of(LINES_BETWEEN_CHECKS) {
                interrupt::check();
            }
            if self.number == 1 && line.starts_with(BYTE_ORDER_MARK) {
                line.drain(..BYTE_ORDER_MARK.len());
            }
            if n as u64 == LONGEST_LINE && line.last() != Some(&self.end) {
                let problem = format!("line {} is longer than {LONGEST_LINE} bytes", self.number);
                return Err(not_a_log(self.path, problem));
            }
            while line.last().is_some_and(|byte| b"\r\n".contains(byte)) {
                line.pop();
            }
            if !line.is_empty() && line[0] != b'#' {
                self.has_line = true;
                return Ok(true);
            }
            if !line.is_empty() && !self.has_line {
                self.comment = Some(line[1..].to_vec());
            }
        }
    }
}

/// Returns true if the compressed data are damaged; otherwise the system failed to read.
pub(super) fn is_damage(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    // errors of the decompressor have no number of the system
    error.raw_os_error().is_none() || matches!(error.kind(), InvalidData | InvalidInput | UnexpectedEof)
}

/// Treatment of the cells of a column.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Numbers, for the table's column of this index.
    Numbers(usize),
    /// Treated as numbers, but no cell so far distinguishes them from text.
    Undecided(usize),
    /// Labels: each distinct value gets a number, in order of appearance.
    Labels(usize),
    LeftOut,
}

/// Converts lines to rows of a table.
struct Parser<'a> {
    cells: Cells,
    decimal_comma: bool,
    names: &'a [String],
    kinds: Vec<Kind>,
    labels: HashMap<Vec<u8>, f64>,
    /// Row being read, one value per column of the table.
    row: Vec<f64>,
    /// Columns with an empty cell in the row being read.
    row_empty: Vec<usize>,
    /// Number of empty cells per column of the table.
    empty: Vec<u64>,
    time: Option<usize>,
    table: Table,
    needed: Vec<bool>,
    path: &'a Path,
}

impl<'a> Parser<'a> {
    fn new(
        path: &'a Path,
        map: &ColumnMap,
        header: &'a Header,
        first_lines: &[(u64, Vec<u8>)],
    ) -> Result<Parser<'a>, RecordingError> {
        let names = header.names.as_slice();
        let (mut numbers, mut texts) = (vec![0_u32; names.len()], vec![0_u32; names.len()]);
        let mut cells = Cells::separated_by(header.separator);
        for (_, line) in first_lines {
            cells.for_each(line, |i, cell| match parse_cell(cell, header.decimal_comma) {
                Cell::Number(_) if i < names.len() => numbers[i] += 1,
                Cell::Text if i < names.len() => texts[i] += 1,
                _ => {}
            });
        }
        let mut table = Table { is_unnamed: header.is_unnamed, ..Table::default() };
        let needed: Vec<bool> = names.iter().map(|name| must_be_numeric(name, map)).collect();
        let mut kinds = Vec::with_capacity(names.len());
        for (i, name) in names.iter().enumerate() {
            let is_text = texts[i] > numbers[i];
            let column = table.columns.len();
            let kind = if map.ignores(name) {
                table.ignored.push(name.clone());
                Kind::LeftOut
            } else if is_text && name == map.column_of("segment") {
                Kind::Labels(column)
            } else if is_text && needed[i] {
                let first = first_text(header, first_lines, i);
                return Err(RecordingError::TextColumn {
                    path: path.to_owned(),
                    column: name.clone(),
                    first,
                });
            } else if is_text {
                table.quality.text_columns.push(name.clone());
                let first = || first_text(header, first_lines, i).map(|row| *row);
                table.quality.first_text = table.quality.first_text.take().or_else(first);
                Kind::LeftOut
            } else if numbers[i] + texts[i] == 0 {
                Kind::Undecided(column)
            } else {
                Kind::Numbers(column)
            };
            if kind != Kind::LeftOut {
                table.columns.push(Column { name: name.clone(), values: Vec::new() });
            }
            kinds.push(kind);
        }
        let n = table.columns.len();
        Ok(Parser {
            cells,
            decimal_comma: header.decimal_comma,
            names,
            kinds,
            labels: HashMap::new(),
            row: vec![f64::NAN; n],
            row_empty: Vec::new(),
            empty: vec![0; n],
            time: table.index_of(map.column_of("t_s")),
            table,
            needed,
            path,
        })
    }

    /// Adds the row in `line`, or returns the reason why it is unusable.
    fn take(&mut self, number: u64, line: &[u8]) -> Result<(), BadRow> {
        self.table.quality.rows_in_file += 1;
        self.row_empty.clear();
        let names = self.names;
        let mut problem = None;
        let mut extra_is_empty = false;
        let n_cells = self.cells.for_each(line, |i, cell| {
            let Some(&kind) = self.kinds.get(i) else {
                extra_is_empty = cell.is_empty();
                return;
            };
            let (column, value) =
                match (kind, parse_cell_unless(kind == Kind::LeftOut, cell, self.decimal_comma)) {
                    (Kind::LeftOut, _) => return,
                    (Kind::Labels(column), Cell::Number(_) | Cell::Text) => {
                        let next = self.labels.len() as f64;
                        (column, *self.labels.entry(cell.to_vec()).or_insert(next))
                    }
                    (Kind::Numbers(column) | Kind::Labels(column) | Kind::Undecided(column), Cell::Empty) => {
                        self.row_empty.push(column);
                        (column, f64::NAN)
                    }
                    (Kind::Numbers(column), Cell::Number(value)) => (column, value),
                    (Kind::Undecided(column), Cell::Number(value)) => {
                        self.kinds[i] = Kind::Numbers(column);
                        (column, value)
                    }
                    (Kind::Undecided(column), Cell::Text) if !self.needed[i] => {
                        // the first content after many empty cells: remarks, not measurements
                        self.kinds[i] = Kind::LeftOut;
                        self.table.quality.text_columns.push(names[i].clone());
                        let place = Place::Line { line: number, cell: i as u64 + 1 };
                        let row = || BadRow::new(place, Some(&names[i]), cell, Problem::NotANumber);
                        self.table.quality.first_text.get_or_insert_with(row);
                        (column, f64::NAN)
                    }
                    (_, Cell::Text) => {
                        let place = Place::Line { line: number, cell: i as u64 + 1 };
                        problem.get_or_insert_with(|| {
                            BadRow::new(place, Some(&names[i]), cell, Problem::NotANumber)
                        });
                        return;
                    }
                };
            self.row[column] = value;
        });
        // some loggers end every row with a separator
        let cells_match = n_cells == names.len() || (n_cells == names.len() + 1 && extra_is_empty);
        if !cells_match {
            let problem = Problem::CellCount { expected: names.len(), found: n_cells };
            return Err(BadRow::new(Place::Line { line: number, cell: 0 }, None, line, problem));
        }
        if let Some(problem) = problem {
            return Err(problem);
        }
        if let Some(time) = self.time.filter(|&time| !self.row[time].is_finite()) {
            let name = &self.table.columns[time].name;
            let cell = names.iter().position(|other| other == name).map_or(0, |i| i as u64 + 1);
            let place = Place::Line { line: number, cell };
            return Err(BadRow::new(place, Some(name), b"", Problem::NoTime));
        }
        for (column, value) in self.table.columns.iter_mut().zip(&self.row) {
            column.values.push(*value);
        }
        self.row_empty.iter().for_each(|&column| self.empty[column] += 1);
        Ok(())
    }

    /// Skips a row and records its position.
    fn skip(&mut self, row: BadRow) {
        self.table.quality.note_unusable(row);
        let before_row = self.table.n_rows();
        match self.table.skipped.last_mut() {
            Some(last) if last.before_row == before_row => last.rows += 1,
            _ => self.table.skipped.push(Skipped { before_row, rows: 1 }),
        }
    }

    fn finish(mut self) -> Result<Table, RecordingError> {
        for i in 0..self.table.columns.len() {
            self.table.columns[i].values.shrink_to_fit();
        }
        // columns that turned out to be text after many empty cells
        let text = std::mem::take(&mut self.table.quality.text_columns);
        let is_kept = |name: &String| !text.contains(name);
        let mut empty = self.empty.iter();
        let mut kept_empty = Vec::new();
        self.table.columns.retain(|column| {
            let count = *empty.next().unwrap_or(&0);
            let keep = is_kept(&column.name);
            if keep {
                kept_empty.push(count);
            }
            keep
        });
        self.table.quality.text_columns = text;
        if self.table.columns.is_empty() {
            return Err(not_a_log(self.path, "no column holds numbers".into()));
        }
        for (i, empty) in kept_empty.into_iter().enumerate() {
            self.table.note_missing_cells(i, empty);
        }
        Ok(self.table)
    }
}

/// First row with text in a column.
fn first_text(header: &Header, lines: &[(u64, Vec<u8>)], column: usize) -> Option<Box<BadRow>> {
    let mut cells = Cells::separated_by(header.separator);
    lines.iter().find_map(|(line, text)| {
        let mut found = None;
        cells.for_each(text, |i, cell| {
            if i == column && matches!(parse_cell(cell, header.decimal_comma), Cell::Text) {
                let place = Place::Line { line: *line, cell: i as u64 + 1 };
                let name = header.names[i].as_str();
                found = Some(Box::new(BadRow::new(place, Some(name), cell, Problem::NotANumber)));
            }
        });
        found
    })
}

/// Parses a cell unless its column is ignored.
fn parse_cell_unless(left_out: bool, cell: &[u8], decimal_comma: bool) -> Cell {
    if left_out { Cell::Empty } else { parse_cell(cell, decimal_comma) }
}
