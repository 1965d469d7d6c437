//! Tables in docs/faults.md, written by the tests that compute them.

/// Compares `table` with the text of the page between `begin` and `end`; with `FOS_WRITE_DOCS` set, writes it there.
pub(crate) fn holds(begin: &str, end: &str, table: &str) {
    fos_testkit::page::holds("faults.md", begin, end, table);
}
