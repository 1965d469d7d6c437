//! Where something stands in a file.

use std::ops::Range;

/// Where a span of `text` begins: `path:line:column`, both from 1, the column in characters; `path` alone of no span.
pub(super) fn place(path: &str, text: &str, span: Option<Range<usize>>) -> String {
    let Some(before) = span.and_then(|span| text.get(..span.start)) else { return path.to_owned() };
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or(before).chars().count() + 1;
    format!("{path}:{line}:{column}")
}
