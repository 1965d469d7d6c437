//! How results are printed: aligned tables for people, JSON for programs, progress only on a terminal.

use std::error::Error;
use std::io::IsTerminal;
use std::time::Duration;

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

pub(super) use crate::text::number;

/// Any error on its way to the exit code.
pub(super) type Failure = Box<dyn Error + Send + Sync>;

/// Prints `value` as JSON on standard output.
pub(super) fn print_json<T: Serialize>(value: &T) -> Result<(), Failure> {
    println!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}

/// A table without borders: the first column to the left, the others to the right.
pub(super) fn table<S: ToString>(header: &[S]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header.iter().map(ToString::to_string));
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// A number in four significant digits, or a dash where there is none.
pub(super) fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), number)
}

/// A progress bar on standard error if it is a terminal, else nothing.
pub(super) fn progress(length: u64, what: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length).with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg:32} {bar:30} {percent:>3} %  {eta}") {
        bar.set_style(style);
    }
    bar
}

/// A sign of life on standard error for work of unknown length, if it is a terminal, else nothing.
pub(super) fn spinner(what: &str) -> ProgressBar {
    let bar = progress(0, what);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}
