//! Tables in docs/faults.md, written by the tests that compute them.

/// Holds `table` against what stands on the page between `begin` and `end`; with `FOS_WRITE_DOCS` set it writes it
/// there.
pub(crate) fn holds(begin: &str, end: &str, table: &str) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/faults.md");
    let page = std::fs::read_to_string(path).expect("docs/faults.md");
    let (before, rest) = page.split_once(begin).expect("the beginning of the table");
    let (written, after) = rest.split_once(end).expect("the end of the table");
    if std::env::var_os("FOS_WRITE_DOCS").is_some() {
        std::fs::write(path, [before, begin, table, end, after].concat()).expect("written");
    } else {
        assert_eq!(written, table, "FOS_WRITE_DOCS=1 writes docs/faults.md anew");
    }
}
