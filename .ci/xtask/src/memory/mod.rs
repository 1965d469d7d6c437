//! `cargo xtask memory short|full`: a working day of six axes fits into a small machine.
//!
//! `short`: half an hour, whose peak stays below the line that the full run measured. `full`: 1, 2, 4 and 8 hours on a machine of
//! 2 GiB; CSV; 200 fits in one process. Prints peaks of resident memory as Markdown. With a quarter of the memory host-fit must
//! fail, and soon.

mod full;
mod limited;

use std::error::Error;
use std::path::Path;

use crate::form::{Form, host_fit};
use limited::Limited;

/// Peaks lie below this line, bytes and bytes a row: at 8 h, where fit took 1484 MB, diagnose 939 and report 1250, a fifth above.
const BASE: u64 = 40_000_000;
const BYTES_A_ROW: [(&str, u64); 3] = [("fit", 300), ("diagnose", 190), ("report", 250)];

/// Prints what was measured; an error if it is more than is promised.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    if !cfg!(target_os = "linux") {
        println!("skipped: memory is limited and measured on Linux only");
        return Ok(());
    }
    let limited = Limited::new(host_fit(root)?)?;
    println!(
        "`cargo xtask memory {}`: peaks of resident memory of logs of six axes at 200 Hz, with {} MiB of {}.\n",
        form.name(),
        limited::LIMIT >> 20,
        limited.how()
    );
    let good = if form == Form::Full { full::run(&limited)? } else { short(&limited)? };
    if good { Ok(()) } else { Err("memory is not as it is promised".into()) }
}

fn short(limited: &Limited) -> Result<bool, Box<dyn Error>> {
    let log = Log::new(limited, "log.parquet", 30)?;
    let fit = ["fit", "log.parquet", "--axis", "gx", "-o", "unit.json"];
    let diagnose = ["diagnose", "unit.json", "--from", "log.parquet"];
    let mut good = true;
    let mut fit_took = 0;
    println!("| half an hour, one axis | rows | peak, MB | at most, MB |\n|---|---|---|---|");
    for arguments in [&fit[..], &diagnose] {
        let ended = limited.run(arguments)?;
        println!(
            "| {} | {} | {} | {} |",
            arguments[0],
            log.rows,
            mega(ended.peak),
            mega(at_most(arguments[0], log.rows))
        );
        good &= ended.is_success() && holds(arguments[0], ended.peak, log.rows);
        fit_took = fit_took.max(if arguments == fit { ended.peak } else { 0 });
    }
    let (found_out, said) = four_times(limited, &log)?;
    println!("{said}");
    Ok(starved(limited, &fit, fit_took)? && found_out && good)
}

fn mega(bytes: u64) -> String {
    format!("{:.0}", bytes as f64 / 1e6)
}

/// The line of a command, bytes.
fn at_most(command: &str, rows: u64) -> u64 {
    let (_, bytes_a_row) = BYTES_A_ROW.into_iter().find(|(name, _)| *name == command).unwrap_or(("", 0));
    BASE + bytes_a_row * rows
}

fn holds(command: &str, peak: u64, rows: u64) -> bool {
    let at_most = at_most(command, rows);
    if peak > at_most {
        eprintln!("{command}: {peak} bytes, more than {at_most}");
    }
    peak <= at_most
}

/// A simulated log in the folder of the runs.
struct Log {
    name: &'static str,
    rows: u64,
    /// Of its numbers as f64, bytes.
    raw: u64,
    /// While it was written.
    peak: u64,
}

impl Log {
    fn new(limited: &Limited, name: &'static str, minutes: u32) -> Result<Self, Box<dyn Error>> {
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

/// Whether it fails with a quarter of what it took, before its time is over; says so.
fn starved(limited: &Limited, arguments: &[&str], peak: u64) -> Result<bool, Box<dyn Error>> {
    let quarter = peak / 4;
    let beside = limited.to_start()?;
    let ended = limited.run_with(arguments, beside + quarter)?;
    let start = match beside {
        0 => String::new(),
        beside => format!(" (and {} MB of address space, with which it starts)", mega(beside)),
    };
    println!(
        "\nNegative control: `host-fit {}` with {} MB, a quarter of what it took{start}, {}.",
        arguments.join(" "),
        mega(quarter),
        ended.how
    );
    Ok(!ended.is_late && !ended.is_success())
}

/// Whether a command that holds its log four times is above the line of one, and what to say of it.
fn four_times(limited: &Limited, log: &Log) -> Result<(bool, String), Box<dyn Error>> {
    let arguments = ["fit", log.name, log.name, log.name, log.name, "--axis", "gx", "-o", "four.json"];
    let ended = limited.run(&arguments)?;
    let found_out = ended.is_success() && !holds("fit", ended.peak, log.rows);
    let said = format!(
        "\nNegative control: `host-fit {}` of {} rows, four times the memory, took {} MB: {} the line ({} MB).",
        arguments.join(" "),
        log.rows,
        mega(ended.peak),
        if found_out { "above" } else { "BELOW" },
        mega(at_most("fit", log.rows))
    );
    Ok((found_out, said))
}
