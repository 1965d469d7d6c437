//! How results are printed: aligned tables for people, JSON for programs, progress only on a terminal.

use std::error::Error;
use std::io::{IsTerminal, Write as _};
use std::time::Duration;

use anstyle::AnsiColor;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

pub(super) use crate::text::number;

/// Any error on its way to the exit code.
pub(super) type Failure = Box<dyn Error + Send + Sync>;

/// Prints text for people, unless JSON is asked for.
macro_rules! say {
    ($command:expr, $($text:tt)*) => {
        if !$command.json {
            println!($($text)*);
        }
    };
}

pub(super) use say;

/// A file that was written.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    /// Where.
    pub(super) path: String,
    /// What it is.
    pub(super) what: String,
}

/// Says which files were written, in the one form or the other.
pub(super) fn print_written(files: &[Written], json: bool) -> Result<(), Failure> {
    if json {
        return print_json(&files);
    }
    files.iter().for_each(|file| println!("{}: {}", file.path, file.what));
    Ok(())
}

/// The word before an error, in colour on a terminal only.
pub(super) fn print_error(failure: &Failure) {
    let style = AnsiColor::Red.on_default().bold();
    tell(format_args!("{style}error:{style:#} {failure}"));
}

/// The word before a warning, in colour on a terminal only.
pub(super) fn print_warning(text: &str) {
    let style = AnsiColor::Yellow.on_default().bold();
    tell(format_args!("{style}warning:{style:#} {text}"));
}

/// On standard error, if anybody hears it: a terminal that was closed is no reason to end otherwise.
fn tell(text: std::fmt::Arguments<'_>) {
    let _ = writeln!(anstream::stderr(), "{text}");
}

/// A word that says that all is well or not, in colour on a terminal only.
pub(super) fn verdict(text: &str, is_good: bool) -> String {
    let colour = if is_good { AnsiColor::Green } else { AnsiColor::Yellow };
    let style = colour.on_default().bold();
    format!("{style}{text}{style:#}")
}

/// Values as bars of eight heights, the largest the highest: `█▃▁`.
pub(super) fn sparkline(values: &[f64]) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let largest = values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let bar = |value: &f64| {
        let share = if largest > 0.0 { value / largest } else { 0.0 };
        BARS[((share * 8.0).ceil() as usize).clamp(1, 8) - 1]
    };
    values.iter().map(bar).collect()
}

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

#[cfg(test)]
mod tests {
    use super::sparkline;

    #[test]
    fn a_staircase_that_falls_is_seen_to_fall() {
        assert_eq!(sparkline(&[8.0, 3.0, 1.0]), "█▃▁");
        assert_eq!(sparkline(&[0.0, 0.0]), "▁▁");
        assert_eq!(sparkline(&[1.0, f64::NAN, 2.0]), "▄▁█");
    }
}
