//! Tables in pages of `docs/`, written by the tests that compute them.

/// Compares `table` with the text of `docs/{page}` between `begin` and `end`; with `FOS_WRITE_DOCS` set it writes it
/// there.
///
/// # Panics
///
/// The page has another table, or lacks the marks.
pub fn holds(page: &str, begin: &str, end: &str, table: &str) {
    let path = format!("{}/../docs/{page}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("docs/{page}: {error}"));
    let (before, rest) = text.split_once(begin).expect("the beginning of the table");
    let (written, after) = rest.split_once(end).expect("the end of the table");
    if std::env::var_os("FOS_WRITE_DOCS").is_some() {
        std::fs::write(path, [before, begin, table, end, after].concat()).expect("written");
    } else {
        assert_eq!(written, table, "FOS_WRITE_DOCS=1 writes docs/{page} anew");
    }
}
