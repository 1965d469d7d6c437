//! Finds the line of a text that names the columns, and the separator.

use std::path::Path;

use super::cell::{Cell, Cells, SPACES, parse_cell};
use super::error::RecordingError;
use super::format::is_unit;
use super::table::{check_names, column_name};

/// Number of lines searched for titles: Betaflight writes a hundred and fifty before its header.
const MAX_TITLES: usize = 400;

/// Names of the columns, and the separator.
pub(super) struct Header {
    pub(super) names: Vec<String>,
    pub(super) separator: u8,
    /// True if a comma in a number is the decimal point.
    pub(super) decimal_comma: bool,
    /// True for a text without a header, whose columns are named by position.
    pub(super) is_unnamed: bool,
}

/// Number of lines, at the end of the first ones, examined for cells separated by spaces.
const LINES_TO_SPACE: usize = 20;

/// Takes the header, and the lines above it, from the first lines of a text. `comment` is the one above the first of
/// them.
pub(super) fn take(
    path: &Path,
    comment: Option<Vec<u8>>,
    lines: &mut Vec<(u64, Vec<u8>)>,
) -> Result<Header, RecordingError> {
    let spaced = is_spaced(lines);
    let first = Shape::of(&lines[0].1, spaced);
    // EuRoC writes its header as a comment
    let comment = comment.filter(|comment| first.numbers == first.cells && names_cells(comment, &first));
    if let Some(comment) = comment {
        return parse(path, &comment, None, lines, spaced);
    }
    if let Some(at) = units_below_names(lines, spaced) {
        let taken: Vec<Vec<u8>> = lines.drain(..=at).map(|(_, line)| line).skip(at - 1).collect();
        return parse(path, &taken[0], taken.get(1).map(Vec::as_slice), lines, spaced);
    }
    let found = first_row_below_names(lines, spaced);
    if found.is_none() && first.cells > 1 && first.numbers == first.cells {
        let names = (0..first.cells).map(|index| column_name("", index)).collect();
        let decimal_comma = decimal_comma(lines, first.separator);
        return Ok(Header { names, separator: first.separator, decimal_comma, is_unnamed: true });
    }
    let header = lines.drain(..=found.unwrap_or(0)).next_back().map(|(_, line)| line).unwrap_or_default();
    parse(path, &header, None, lines, spaced)
}

/// Returns true if cells are separated by spaces: the last of the first lines split into numbers that way only.
fn is_spaced(lines: &[(u64, Vec<u8>)]) -> bool {
    let last = &lines[lines.len().saturating_sub(LINES_TO_SPACE)..];
    let is_spaced = |line: &[u8]| {
        let (spaced, separated) = (Shape::by(line, SPACES), Shape::by(line, separator(line, false)));
        spaced.cells > 1 && spaced.numbers == spaced.cells && separated.numbers < separated.cells
    };
    let spaced = last.iter().filter(|(_, line)| is_spaced(line)).count();
    2 * spaced > last.len()
}

/// Index of a row of units between the names and the first row of numbers.
fn units_below_names(lines: &[(u64, Vec<u8>)], spaced: bool) -> Option<usize> {
    let is_units = |at: usize| {
        let (names, units, row) = (&lines[at - 1].1, &lines[at].1, &lines[at + 1].1);
        let by = separator(units, spaced);
        let row = Shape::by(row, by);
        let (mut cells, mut known) = (0, 0);
        Cells::separated_by(by).for_each(units, |_, cell| {
            cells += usize::from(!cell.is_empty());
            known += usize::from(is_unit(&String::from_utf8_lossy(cell)));
        });
        2 * row.numbers >= row.cells
            && names_cells(names, &row)
            && names_cells(units, &row)
            && 2 * known > cells
    };
    (1..lines.len().saturating_sub(1).min(MAX_TITLES)).find(|at| is_units(*at))
}

/// Returns true if a comma in a number is the decimal point, that is, if no number has a point.
fn decimal_comma(rows: &[(u64, Vec<u8>)], separator: u8) -> bool {
    let mut has_point = false;
    if separator != b',' {
        let mut cells = Cells::separated_by(separator);
        for (_, row) in rows {
            cells.for_each(row, |_, cell| {
                has_point |= cell.contains(&b'.') && matches!(parse_cell(cell, false), Cell::Number(_));
            });
        }
    }
    separator != b',' && !has_point
}

fn parse(
    path: &Path,
    line: &[u8],
    units: Option<&[u8]>,
    rows: &[(u64, Vec<u8>)],
    spaced: bool,
) -> Result<Header, RecordingError> {
    let separator = separator(line, spaced);
    let mut cells = Cells::separated_by(separator);
    let mut names = Vec::new();
    cells.for_each(line, |i, cell| {
        names.push(column_name(&String::from_utf8_lossy(cell), i));
    });
    // some loggers end every row with a separator, and the header too
    let mut ends_empty = |line: &[u8]| {
        let mut is_empty = false;
        cells.for_each(line, |_, cell| is_empty = cell.is_empty());
        is_empty
    };
    if names.len() > 2 && ends_empty(line) && rows.iter().all(|(_, row)| ends_empty(row)) {
        names.pop();
    }
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        let problem = "the first line holds numbers where the names of the columns should be";
        return Err(not_a_log(path, problem.into()));
    }
    cells.for_each(units.unwrap_or_default(), |i, cell| {
        let unit = column_name(&String::from_utf8_lossy(cell), i);
        if let Some(name) = names.get_mut(i).filter(|_| !cell.is_empty()) {
            let unit = unit.trim_matches(['[', ']', '(', ')']);
            name.push_str(&format!(" [{unit}]"));
        }
    });
    check_names(path, &names)?;
    Ok(Header { names, separator, decimal_comma: decimal_comma(rows, separator), is_unnamed: false })
}

fn separator(line: &[u8], spaced: bool) -> u8 {
    if spaced {
        return SPACES;
    }
    let count = |separator: u8| line.iter().filter(|&&byte| byte == separator).count();
    [b'\t', b';', b','].into_iter().max_by_key(|&separator| count(separator)).unwrap_or(b',')
}

pub(super) fn not_a_log(path: &Path, problem: String) -> RecordingError {
    RecordingError::NotALog { path: path.to_owned(), problem }
}

/// Numbers of cells of a line by kind.
struct Shape {
    cells: usize,
    numbers: usize,
    texts: usize,
    separator: u8,
}

impl Shape {
    fn of(line: &[u8], spaced: bool) -> Self {
        Self::by(line, separator(line, spaced))
    }

    fn by(line: &[u8], separator: u8) -> Self {
        let (mut numbers, mut texts) = (0, 0);
        let cells = Cells::separated_by(separator).for_each(line, |_, cell| {
            match parse_cell(cell, separator != b',') {
                Cell::Number(_) => numbers += 1,
                Cell::Text => texts += 1,
                Cell::Empty => {}
            }
        });
        Self { cells, numbers, texts, separator }
    }
}

/// Returns true if a line names as many cells as a row has.
fn names_cells(line: &[u8], row: &Shape) -> bool {
    let names = Shape::by(line, row.separator);
    row.cells > 1 && names.cells == row.cells && names.numbers == 0 && names.texts > 1
}

/// Index of a header below titles: titles have fewer cells, and the header names those of the row below.
fn first_row_below_names(lines: &[(u64, Vec<u8>)], spaced: bool) -> Option<usize> {
    let title = Shape::of(&lines[0].1, spaced);
    let is_header = |at: usize| {
        // split by the separator of the names: the row may contain more decimal commas
        let Some((_, row)) = lines.get(at + 1) else { return false };
        let row = Shape::by(row, separator(&lines[at].1, spaced));
        // half of a row may be empty or text
        2 * row.numbers >= row.cells && row.numbers > 1 && names_cells(&lines[at].1, &row)
    };
    let is_below_titles = |at: usize| Shape::of(&lines[at].1, spaced).cells > title.cells;
    (0..lines.len().min(MAX_TITLES)).find(|&at| (at == 0 || is_below_titles(at)) && is_header(at))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(comment: Option<&str>, text: &str) -> (Vec<String>, u8, bool, usize) {
        let mut lines: Vec<(u64, Vec<u8>)> =
            text.lines().enumerate().map(|(n, line)| (n as u64 + 1, line.as_bytes().to_vec())).collect();
        let header =
            take(Path::new("x"), comment.map(|comment| comment.as_bytes().to_vec()), &mut lines).unwrap();
        (header.names, header.separator, header.decimal_comma, lines.len())
    }

    #[test]
    fn finds_the_header_below_titles() {
        assert_eq!(taken(None, "a,b\n1,2\n"), (vec!["a".into(), "b".into()], b',', false, 1));
        // an unusable first row is no title
        assert_eq!(taken(None, "a,b,c\nrubbish\n1,2,3\n").3, 2);
        assert_eq!(taken(None, "a,b,c\nd,e,f\n1,2,3\n").3, 2);
        for title in ["sep=;", "MEMS Studio 2.3", "\"Product\";\"Blackbox\""] {
            let text = format!("{title}\n{title}\nt;x;y\n1,5;2;3\n");
            let names = vec!["t".into(), "x".into(), "y".into()];
            assert_eq!(taken(None, &text), (names, b';', true, 1), "{title}");
        }
        // a single line without anything to compare
        assert_eq!(taken(None, "a,b").3, 0);
    }

    #[test]
    fn comment_with_the_names_of_the_cells_is_the_header() {
        assert_eq!(taken(Some("timestamp [ns],x,y"), "1,2,3\n").0[0], "timestamp [ns]");
        assert_eq!(taken(Some("a remark, with a comma"), "t,x\n1,2\n").0[0], "t");
        // a remark is no header
        let mut rows = vec![(1, b"1,2,3".to_vec())];
        assert!(take(Path::new("x"), Some(b"a remark".to_vec()), &mut rows).unwrap().is_unnamed);
    }

    #[test]
    fn recognises_decimal_commas_without_points() {
        assert!(taken(None, "a;b\n1,5;2\n").2);
        assert!(!taken(None, "a;b\n1.5;2\n").2);
        assert!(!taken(None, "a,b\n1,2\n").2);
        assert!(taken(None, "a\tb\n1,5\t2\n").2);
    }
}
