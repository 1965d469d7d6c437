//! Runs of both forms: logs, and controls that must fail.

use std::error::Error;

use super::limited::Limited;
use super::line::{at_most, holds, mega};

/// A simulated log in the working folder.
pub(crate) struct Log {
    pub(crate) name: &'static str,
    pub(crate) rows: u64,
    /// Size of its numbers as f64, bytes.
    pub(crate) raw: u64,
    /// Peak memory while it was written, bytes.
    pub(crate) peak: u64,
}

impl Log {
    pub(crate) fn new(limited: &Limited, name: &'static str, minutes: u32) -> Result<Self, Box<dyn Error>> {
        let ended = limited.run(&[
            "simulate",
            name,
            "--minutes",
            &minutes.to_string(),
            "--seed",
            "5",
            "--at-rest",
        ])?;
        // NAME: ROWS rows, COLUMNS columns
        let words: Vec<&str> = ended.printed.split_whitespace().collect();
        let (true, [_, rows, _, columns, ..]) = (ended.is_success(), &words[..]) else {
            return Err(format!("{name} could not be written").into());
        };
        let (rows, columns): (u64, u64) = (rows.parse()?, columns.parse()?);
        Ok(Self { name, rows, raw: rows * columns * 8, peak: ended.peak })
    }
}

/// The command fails within its time limit with a quarter of its peak memory; prints the result.
pub(crate) fn starved(limited: &Limited, arguments: &[&str], peak: u64) -> Result<bool, Box<dyn Error>> {
    let quarter = peak / 4;
    let beside = limited.to_start()?;
    let ended = limited.run_with(arguments, beside + quarter)?;
    let start = match beside {
        0 => String::new(),
        beside => format!(" (plus the {} MB of address space that it needs to start)", mega(beside)),
    };
    println!(
        "\nNegative control: `fos {}` with {} MB, a quarter of its peak{start}, {}.",
        arguments.join(" "),
        mega(quarter),
        ended.how
    );
    Ok(!ended.is_late && !ended.is_success())
}

/// Control: a command that holds its log four times exceeds the line for one. Returns that, and a description.
pub(crate) fn four_times(limited: &Limited, log: &Log) -> Result<(bool, String), Box<dyn Error>> {
    let arguments = ["fit", log.name, log.name, log.name, log.name, "--axis", "gx", "-o", "four.json"];
    let ended = limited.run(&arguments)?;
    let found_out = ended.is_success() && !holds("fit", ended.peak, log.rows);
    let description = format!(
        "\nNegative control: `fos {}` holds a log of {} rows four times and takes {} MB, {} the limit for one ({} MB).",
        arguments.join(" "),
        log.rows,
        mega(ended.peak),
        if found_out { "above" } else { "BELOW" },
        mega(at_most("fit", log.rows))
    );
    Ok((found_out, description))
}
