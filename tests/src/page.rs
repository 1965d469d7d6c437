//! Tables in pages of `docs/`, written by the tests that compute them.

/// Compares `table` with the text of the page `docs/{page}` between `begin` and `end`; with `FOS_WRITE_DOCS` set it
/// replaces that text.
///
/// # Panics
///
/// The page has another table, or lacks the markers.
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

/// Holds the text of the file `docs/{file}` against `content`; with `FOS_WRITE_DOCS` set it writes it there.
///
/// # Panics
///
/// Another text stands there, or none.
pub fn file_holds(file: &str, content: &str) {
    let path = format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("FOS_WRITE_DOCS").is_some() {
        std::fs::write(path, content).expect("written");
    } else {
        let written = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("docs/{file}: {error}"));
        assert!(written == content, "FOS_WRITE_DOCS=1 writes docs/{file} anew");
    }
}
