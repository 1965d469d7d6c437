//! Position in a text file.

use std::ops::Range;

/// Returns the start of a span of `text` as `path:line:column`, both from 1, the column in characters; `path` alone
/// without a span.
pub(super) fn place(path: &str, text: &str, span: Option<Range<usize>>) -> String {
    let Some(before) = span.and_then(|span| text.get(..span.start)) else { return path.to_owned() };
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or(before).chars().count() + 1;
    format!("{path}:{line}:{column}")
}
