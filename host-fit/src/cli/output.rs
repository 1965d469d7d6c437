//! Output of results: aligned tables for people, JSON for programs, progress only on a terminal.
//!
//! Nothing else prints. Logs, studies and images contain names of columns, files and effects, whose control characters must not reach a
//! terminal; they are made visible here ([`visible_lines`]), and colours are added afterwards.

use fos_diagnose::detect::rms_reduction;
use std::error::Error;
use std::fmt::{Arguments, Display};
use std::io::{ErrorKind, IsTerminal, Write as _};
use std::ops::Deref;
use std::time::Duration;

use anstyle::AnsiColor;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::units::{self, Printed};
use fos_data::escaping::{quoted, visible_json};
use fos_data::recording::{LogWarning, RecordingError};
pub(super) use fos_data::text::number;
use fos_data::visible::{visible, visible_lines};
use fos_diagnose::study::StudyError;

/// Any error before it becomes the exit code.
pub(super) type Failure = Box<dyn Error + Send + Sync>;

/// Prints a line of text for people on standard output.
macro_rules! print_line {
    () => {
        $crate::cli::output::print(format_args!("\n"))
    };
    ($($text:tt)*) => {
        $crate::cli::output::print(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// Prints text for people on standard output, including its line ends.
macro_rules! print_text {
    ($($text:tt)*) => {
        $crate::cli::output::print(format_args!($($text)*))
    };
}

/// Prints a line on standard error.
macro_rules! print_note {
    ($($text:tt)*) => {
        $crate::cli::output::print_aside(format_args!($($text)*))
    };
}

/// Prints text for people, unless the output is JSON.
macro_rules! say {
    ($command:expr, $($text:tt)*) => {
        if !$command.json {
            $crate::cli::output::print(format_args!("{}\n", format_args!($($text)*)))
        }
    };
}

pub(super) use {print_line, print_note, print_text, say};

/// A closed pipe is not an error; another failure to write, such as a full disk, ends with exit code 1.
pub(super) fn print(text: Arguments<'_>) {
    let text = text.to_string();
    match std::io::stdout().write_all(visible_lines(&text).as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            print_error(&format!(
                "standard output: {error}\nhelp: make room where it goes to, and run the command again"
            ));
            std::process::exit(1);
        }
        _ => {}
    }
}

pub(super) fn print_aside(text: Arguments<'_>) {
    tell(format_args!("{}", visible_lines(&text.to_string())));
}

/// A file that was written.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    /// Path as in the arguments.
    pub(super) path: String,
    /// Kind of file, as in `manual page`.
    pub(super) what: String,
}

/// Lists the written files, as text or JSON.
pub(super) fn print_written(files: &[Written], json: bool) -> Result<(), Failure> {
    if json {
        return print_json(&files);
    }
    files.iter().for_each(|file| print_line!("{}: {}", file.path, file.what));
    Ok(())
}

/// An error in the terms of the command line: entries of a column map, and suggested maps, become arguments to paste.
pub(super) fn in_words(failure: &Failure) -> String {
    let message = failure.to_string();
    if let Some(StudyError::NotAStudy { path, .. }) = failure.downcast_ref()
        && !path.ends_with(".json")
    {
        return format!(
            "{path}: a log, not a study\nhelp: `fos fit {path} -o unit.json` makes a study of a log"
        );
    }
    let (maps, with_rate) = match failure.downcast_ref() {
        Some(RecordingError::Undecided { maps, .. }) => (maps, false),
        Some(RecordingError::NoHeader { maps, needs_rate, .. }) if !maps.is_empty() => (maps, *needs_rate),
        Some(RecordingError::GravityUnit { map, .. }) => {
            return map
                .iter()
                .fold(message, |message, entry| message.replace(entry, &format!("--map {entry}")));
        }
        Some(RecordingError::NoTime { perhaps, .. } | RecordingError::NoAxes { perhaps, .. })
            if !perhaps.is_empty() =>
        {
            return message.replace(&perhaps.join(", "), &map_arguments(perhaps));
        }
        _ => return message,
    };
    let arguments: Vec<String> = maps.iter().map(|map| map_arguments(map)).collect();
    let problem = message.split("\nhelp: ").next().unwrap_or_default();
    let rate = if with_rate { "\n  with the sample rate, as in --rate 100" } else { "" };
    format!("{problem}\nhelp: choose one: {}{rate}", arguments.join("\n  or: "))
}

/// Entries of a column map as arguments to paste.
fn map_arguments(map: &[String]) -> String {
    map.iter().map(|entry| format!("--map {}", quoted(entry))).collect::<Vec<_>>().join(" ")
}

/// A warning about a log in the terms of the command line.
pub(super) fn warning_in_words<'a>(
    warning: &LogWarning,
    arguments: impl IntoIterator<Item = &'a clap::Arg>,
) -> String {
    let message = match warning {
        LogWarning::AssumedMap(map) => {
            format!(
                "the file has no header; its values show {}. Check it, and pass it with the file",
                map_arguments(map)
            )
        }
        _ => warning.to_string(),
    };
    with_flags(&message, arguments)
}

/// Prints an error, with its label in colour on a terminal only.
pub(super) fn print_error(failure: &dyn Display) {
    let style = AnsiColor::Red.on_default().bold();
    tell(format_args!("{style}error:{style:#} {}", visible_lines(&failure.to_string())));
}

/// Terms of the libraries, and the corresponding options of the command line.
const IN_WORDS: [(&str, &str); 2] = [("in the column map", "with --map"), ("the column map", "--map")];

/// Replaces the names of option fields in messages of the libraries, such as `` `max_lag` ``, by options of the command line: `--max-lag`.
/// Other subcommands may have the option.
pub(super) fn with_flags<'a>(
    message: &impl ToString,
    arguments: impl IntoIterator<Item = &'a clap::Arg>,
) -> String {
    let message =
        IN_WORDS.iter().fold(message.to_string(), |text, (words, option)| text.replace(words, option));
    arguments.into_iter().fold(message, |text, argument| match argument.get_long() {
        Some(long) => text.replace(&format!("`{}`", argument.get_id()), &format!("--{long}")),
        None => text,
    })
}

/// Prints a warning, with its label in colour on a terminal only.
pub(super) fn print_warning(text: &str) {
    let style = AnsiColor::Yellow.on_default().bold();
    tell(format_args!("{style}warning:{style:#} {}", visible_lines(text)));
}

/// Prints on standard error; a closed terminal is not an error.
fn tell(text: Arguments<'_>) {
    let _ = writeln!(anstream::stderr(), "{text}");
}

/// Prints a line whose end states success or failure, in colour on a terminal only.
pub(super) fn print_verdict(of: &str, text: &str, is_good: bool) {
    let colour = if is_good { AnsiColor::Green } else { AnsiColor::Yellow };
    let style = colour.on_default().bold();
    anstream::println!("{}: {style}{}{style:#}", visible(of), visible(text));
}

/// Values as bars of eight heights, relative to the largest: `█▃▁`.
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
    print_line!("{}", visible_json(&serde_json::to_string_pretty(value)?));
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

/// Remarks on axes, each once with its axes; those on all of `axes` axes without names.
pub(super) fn grouped<'a>(remarks: impl IntoIterator<Item = (&'a str, String)>, axes: usize) -> Vec<String> {
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for (axis, remark) in remarks {
        // some name their axis themselves
        let remark = remark.strip_prefix(&format!("{axis}: ")).map_or(remark.clone(), str::to_owned);
        match found.iter_mut().find(|(known, _)| *known == remark) {
            Some((_, of)) => of.push(axis),
            None => found.push((remark, vec![axis])),
        }
    }
    let line = |(remark, of): (String, Vec<&str>)| match of.len() == axes {
        true => remark,
        false => format!("{}: {remark}", of.join(", ")),
    };
    found.into_iter().map(line).collect()
}

/// Last line of a summary: how to print the rest.
pub(super) fn print_hint(printed: Printed) {
    if !printed.details {
        print_line!("--details prints the rest");
    }
}

/// The first `most` lines; the last states the number of further ones.
pub(super) fn first(mut lines: Vec<String>, most: usize) -> Vec<String> {
    let more = lines.len().saturating_sub(most);
    if more > 0 {
        lines.truncate(most);
        lines.push(format!("and {more} more"));
    }
    lines
}

/// A progress bar that makes control characters in its message visible.
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub(super) fn set_message(&self, text: &str) {
        self.0.set_message(visible(text).into_owned());
    }
}

impl Deref for Bar {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.0
    }
}

/// A progress bar on standard error if it is a terminal, else nothing.
pub(super) fn progress(length: u64, what: &str) -> Bar {
    styled(
        ProgressBar::with_draw_target(Some(length), terminal()),
        what,
        "{msg:32} {bar:30} {percent:>3} %  {eta}",
    )
}

/// A spinner on standard error for work of unknown length, if it is a terminal, else nothing.
pub(super) fn spinner(what: &str) -> Bar {
    let bar = styled(ProgressBar::with_draw_target(None, terminal()), what, "{spinner} {msg} ({elapsed})");
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// Standard error if it is a terminal, else nothing.
fn terminal() -> ProgressDrawTarget {
    if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() }
}

/// Sets the style before the message, because a message is drawn at once.
fn styled(bar: ProgressBar, what: &str, template: &str) -> Bar {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    Bar(bar)
}

/// Converts a reduction of variance to one of the RMS, in per cent.
pub(super) fn percent(of_variance: f64) -> String {
    units::percent(rms_reduction(of_variance))
}

#[cfg(test)]
mod tests {
    use super::{first, grouped, sparkline};

    #[test]
    fn groups_equal_remarks_of_several_axes() {
        let remarks =
            [("gx", "short"), ("gy", "short"), ("gx", "hot")].map(|(axis, text)| (axis, text.to_owned()));
        assert_eq!(grouped(remarks.clone(), 2), ["short", "gx: hot"]);
        assert_eq!(first(grouped(remarks, 3), 1), ["gx, gy: short", "and 1 more"]);
    }

    #[test]
    fn sparkline_shows_decreasing_values() {
        assert_eq!(sparkline(&[8.0, 3.0, 1.0]), "█▃▁");
        assert_eq!(sparkline(&[0.0, 0.0]), "▁▁");
        assert_eq!(sparkline(&[1.0, f64::NAN, 2.0]), "▄▁█");
    }
}
