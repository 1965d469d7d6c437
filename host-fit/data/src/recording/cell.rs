//! Cells of a line of text, and their parsing.

/// Separator value for cells separated by any number of spaces or tabs.
pub(super) const SPACES: u8 = b' ';

/// Splits lines into cells.
pub(super) struct Cells {
    separator: u8,
    /// Made at the first quotation mark: a reader is a table, and building one for every line took longer than the line.
    quoted: Option<Quoted>,
}

struct Quoted {
    reader: csv_core::Reader,
    text: Vec<u8>,
    ends: Vec<usize>,
}

impl Cells {
    pub(super) const fn separated_by(separator: u8) -> Self {
        Self { separator, quoted: None }
    }

    /// Passes every cell of a line to `take` with its index, without spaces around it; returns the number of cells.
    pub(super) fn for_each(&mut self, line: &[u8], mut take: impl FnMut(usize, &[u8])) -> usize {
        let mut n = 0;
        let mut next = |cell: &[u8]| {
            take(n, cell);
            n += 1;
        };
        if line.contains(&b'"') {
            let quoted = self.quoted.get_or_insert_with(|| Quoted::separated_by(self.separator));
            quoted.for_each(line, |cell| next(cell.trim_ascii()));
        } else if self.separator == SPACES {
            line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty()).for_each(next);
        } else {
            line.split(|&byte| byte == self.separator).for_each(|cell| next(cell.trim_ascii()));
        }
        n
    }
}

impl Quoted {
    fn separated_by(separator: u8) -> Self {
        let reader = csv_core::ReaderBuilder::new().delimiter(separator).build();
        Self { reader, text: Vec::new(), ends: Vec::new() }
    }

    fn for_each(&mut self, line: &[u8], mut take: impl FnMut(&[u8])) {
        // no cell is longer than its text, and each but the last takes a separator
        self.text.resize(line.len(), 0);
        self.ends.resize(line.len() + 1, 0);
        self.reader.reset();
        let (_, _, written, ended) = self.reader.read_record(line, &mut self.text, &mut self.ends);
        // the end of the line, which ends the last cell
        let (_, _, _, last) =
            self.reader.read_record(&[], &mut self.text[written..], &mut self.ends[ended..]);
        let mut start = 0;
        for &end in &self.ends[..ended + last] {
            take(&self.text[start..end]);
            start = end;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The cells of every line in turn are those that a fresh reader of the csv crate finds.
    #[test]
    fn quoted_cells_are_those_of_the_csv_crate() {
        let lines = [
            r#"a,"b,c",d"#,
            r#""","x""y"," z ""#,
            "plain,1.5,",
            r#""never closed,1,2"#,
            r#"1," 2 " ,"3"#,
            r#""","#,
            r#"a"b,c"#,
            "\u{feff}\"t_s\",\"gx\"",
        ];
        for separator in [b',', b';', b'\t'] {
            let mut cells = Cells::separated_by(separator);
            for line in lines {
                let line = line.replace(',', &char::from(separator).to_string());
                let mut found = Vec::new();
                let count = cells.for_each(line.as_bytes(), |i, cell| {
                    assert_eq!(i, found.len());
                    found.push(cell.to_vec());
                });
                let mut reader = csv::ReaderBuilder::new()
                    .has_headers(false)
                    .delimiter(separator)
                    .from_reader(line.as_bytes());
                let mut record = csv::ByteRecord::new();
                assert!(reader.read_byte_record(&mut record).unwrap());
                let expected: Vec<Vec<u8>> = record.iter().map(|cell| cell.trim_ascii().to_vec()).collect();
                assert_eq!(found, expected, "{line}");
                assert_eq!(count, expected.len());
            }
        }
    }
}
