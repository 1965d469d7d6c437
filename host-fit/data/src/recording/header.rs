//! Which line of a text names the columns, and what stands between them.

use std::path::Path;

use super::cell::{Cell, for_each_cell, parse_cell};
use super::error::RecordingError;
use super::table::{check_names, column_name};

/// Titles are looked for in so many lines: Betaflight writes a hundred and fifty before its header.
const MOST_TITLES: usize = 400;

/// Names of the columns, and what stands between them.
pub(super) struct Header {
    pub(super) names: Vec<String>,
    pub(super) separator: u8,
    /// A comma in a number is the decimal one.
    pub(super) decimal_comma: bool,
}

/// Takes the header, and what stands above it, from the first lines of a text. `comment` is the one above the first of
/// them.
///
/// # Errors
/// There is none, or it names two columns alike.
pub(super) fn take(
    path: &Path,
    comment: Option<Vec<u8>>,
    lines: &mut Vec<(u64, Vec<u8>)>,
) -> Result<Header, RecordingError> {
    let first = Shape::of(&lines[0].1);
    // EuRoC writes its header as a comment
    let comment = comment.filter(|comment| first.numbers == first.cells && names_cells(comment, &first));
    let header = match comment {
        Some(comment) => comment,
        None => {
            let at = first_row_below_names(lines).unwrap_or(0);
            lines.drain(..=at).next_back().map(|(_, line)| line).unwrap_or_default()
        }
    };
    parse(path, &header, lines)
}

fn parse(path: &Path, line: &[u8], rows: &[(u64, Vec<u8>)]) -> Result<Header, RecordingError> {
    let separator = separator(line);
    let mut names = Vec::new();
    for_each_cell(line, separator, |i, cell| {
        names.push(column_name(&String::from_utf8_lossy(cell), i));
    });
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        let problem = "the first line holds numbers where the names of the columns should be";
        return Err(not_a_log(path, problem.into()));
    }
    check_names(path, &names)?;
    // where a point is the decimal one, a comma is not
    let mut has_point = false;
    if separator != b',' {
        for (_, row) in rows {
            for_each_cell(row, separator, |_, cell| {
                has_point |= cell.contains(&b'.') && matches!(parse_cell(cell, false), Cell::Number(_));
            });
        }
    }
    Ok(Header { names, separator, decimal_comma: separator != b',' && !has_point })
}

fn separator(line: &[u8]) -> u8 {
    let count = |separator: u8| line.iter().filter(|&&byte| byte == separator).count();
    [b'\t', b';', b','].into_iter().max_by_key(|&separator| count(separator)).unwrap_or(b',')
}

pub(super) fn not_a_log(path: &Path, problem: String) -> RecordingError {
    RecordingError::NotALog { path: path.to_owned(), problem }
}

/// How many cells a line has, and how many of them are numbers.
struct Shape {
    cells: usize,
    numbers: usize,
    texts: usize,
    separator: u8,
}

impl Shape {
    fn of(line: &[u8]) -> Self {
        Self::by(line, separator(line))
    }

    fn by(line: &[u8], separator: u8) -> Self {
        let (mut numbers, mut texts) = (0, 0);
        let cells = for_each_cell(line, separator, |_, cell| match parse_cell(cell, separator != b',') {
            Cell::Number(_) => numbers += 1,
            Cell::Text => texts += 1,
            Cell::Empty => {}
        });
        Self { cells, numbers, texts, separator }
    }
}

/// Whether a line names as many cells as a row has.
fn names_cells(line: &[u8], row: &Shape) -> bool {
    let names = Shape::by(line, row.separator);
    row.cells > 1 && names.cells == row.cells && names.numbers == 0 && names.texts > 1
}

/// The place of the header where titles stand above it: they have fewer cells, and it names those of the row below.
fn first_row_below_names(lines: &[(u64, Vec<u8>)]) -> Option<usize> {
    let title = Shape::of(&lines[0].1);
    let is_header = |at: usize| {
        // by the separator of the names: in the row there may be more decimal commas
        let Some((_, row)) = lines.get(at + 1) else { return false };
        let row = Shape::by(row, separator(&lines[at].1));
        // half of a row may be empty or text
        2 * row.numbers >= row.cells && row.numbers > 1 && names_cells(&lines[at].1, &row)
    };
    let is_below_titles = |at: usize| Shape::of(&lines[at].1).cells > title.cells;
    (0..lines.len().min(MOST_TITLES)).find(|&at| (at == 0 || is_below_titles(at)) && is_header(at))
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
    fn the_first_line_is_the_header_unless_titles_stand_above() {
        assert_eq!(taken(None, "a,b\n1,2\n"), (vec!["a".into(), "b".into()], b',', false, 1));
        // a first row that cannot be used is no title
        assert_eq!(taken(None, "a,b,c\nrubbish\n1,2,3\n").3, 2);
        assert_eq!(taken(None, "a,b,c\nd,e,f\n1,2,3\n").3, 2);
        for title in ["sep=;", "MEMS Studio 2.3", "\"Product\";\"Blackbox\""] {
            let text = format!("{title}\n{title}\nt;x;y\n1,5;2;3\n");
            let names = vec!["t".into(), "x".into(), "y".into()];
            assert_eq!(taken(None, &text), (names, b';', true, 1), "{title}");
        }
        // one line, and nothing to hold it against
        assert_eq!(taken(None, "a,b").3, 0);
    }

    #[test]
    fn a_comment_that_names_the_cells_of_the_numbers_below_is_the_header() {
        assert_eq!(taken(Some("timestamp [ns],x,y"), "1,2,3\n").0[0], "timestamp [ns]");
        assert_eq!(taken(Some("a remark, with a comma"), "t,x\n1,2\n").0[0], "t");
        let mut rows = vec![(1, b"1,2,3".to_vec())];
        assert!(take(Path::new("x"), Some(b"a remark".to_vec()), &mut rows).is_err());
    }

    #[test]
    fn a_decimal_comma_is_one_where_no_point_is() {
        assert!(taken(None, "a;b\n1,5;2\n").2);
        assert!(!taken(None, "a;b\n1.5;2\n").2);
        assert!(!taken(None, "a,b\n1,2\n").2);
        assert!(taken(None, "a\tb\n1,5\t2\n").2);
    }
}
