//! Cells of a line of text, and their parsing.

/// Separator value for cells separated by any number of spaces or tabs.
pub(super) const SPACES: u8 = b' ';

/// Passes every cell of a line to `take` with its index, without spaces around it; returns the number of cells.
pub(super) fn for_each_cell(line: &[u8], separator: u8, mut take: impl FnMut(usize, &[u8])) -> usize {
    let mut n = 0;
    if line.contains(&b'"') {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).delimiter(separator).from_reader(line);
        let mut record = csv::ByteRecord::new();
        if let Ok(true) = reader.read_byte_record(&mut record) {
            for cell in &record {
                take(n, cell.trim_ascii());
                n += 1;
            }
        }
    } else if separator == SPACES {
        for cell in line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty()) {
            take(n, cell);
            n += 1;
        }
    } else {
        for cell in line.split(|&byte| byte == separator) {
            take(n, cell.trim_ascii());
            n += 1;
        }
    }
    n
}

pub(super) enum Cell {
    Number(f64),
    Empty,
    Text,
}

/// Parses a cell. With `decimal_comma` a comma in a number is the decimal point.
pub(super) fn parse_cell(cell: &[u8], decimal_comma: bool) -> Cell {
    if cell.is_empty() {
        return Cell::Empty;
    }
    let Ok(text) = std::str::from_utf8(cell) else { return Cell::Text };
    if let Ok(number) = text.parse() {
        return Cell::Number(number);
    }
    if decimal_comma && let Ok(number) = text.replacen(',', ".", 1).parse() {
        return Cell::Number(number);
    }
    let is = |word: &str| text.eq_ignore_ascii_case(word);
    match () {
        () if is("true") => Cell::Number(1.0),
        () if is("false") => Cell::Number(0.0),
        () if is("na") || is("null") || is("none") => Cell::Empty,
        () => Cell::Text,
    }
}
