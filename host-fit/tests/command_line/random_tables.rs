//! Every command on random tables: an answer or a clear refusal, never a panic, within bounded processor time and memory.
//!
//! `FOS_RANDOM_TABLES=5000 cargo test --workspace --test command_line random_tables::` runs that many tables, starting
//! at seed `FOS_RANDOM_SEED`. A failure reports its seed.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use fos_data::column::AXES;
use fos_testkit::is_thorough;

/// Number of tables in an ordinary and in a thorough run.
const TABLES: u64 = 3;
const THOROUGH: u64 = 12;

/// Limit of the processor time of a command, s; the slowest takes a tenth of it, and the time does not depend on other
/// load of the machine.
const CPU_S: u32 = 60;

/// Limit of the address space of a command, kilobytes.
const MEMORY_KB: u32 = 4_000_000;

const OTHERS: [&str; 10] = [
    "temp_c",
    "supply_v",
    "load_pct",
    "mag_x_ut",
    "mag_y_ut",
    "mag_z_ut",
    "ref_gx_rads",
    "ref_ax_mps2",
    "still",
    "segment",
];

struct Table {
    columns: Vec<(String, Vec<f64>)>,
}

struct Draw(ChaCha8Rng);

impl Draw {
    fn of(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    fn below(&mut self, end: usize) -> usize {
        self.0.random_range(0..end.max(1))
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

impl Table {
    fn random(seed: u64, longest: f64) -> Self {
        let draw = &mut Draw::of(seed);
        let rate_hz = 10_f64.powf(draw.between(-1.0, 4.0));
        let rows = match draw.chance(0.05) {
            true => draw.below(4),
            false => 10_f64.powf(draw.between(0.0, longest.log10())) as usize,
        };
        let mut columns = vec![("t_s".to_owned(), times(draw, rows, rate_hz))];
        let few = draw.chance(0.1);
        let mut pattern = (0, 2, 0.5);
        for name in AXES.iter().chain(&OTHERS) {
            let share = if few || OTHERS.contains(name) { 0.3 } else { 0.8 };
            if !draw.chance(share) {
                continue;
            }
            // axes of one sensor are often missing together
            if columns.len() == 1 || draw.chance(0.5) {
                pattern = (draw.below(12), 2 + draw.below(19), draw.between(0.0, 1.0));
            }
            let mut values = values(draw, name, rows);
            empty(draw, &mut values, pattern);
            columns.push(((*name).to_owned(), values));
        }
        Self { columns }
    }

    /// Six axes of noise, with values replaced by `change`.
    fn regular(rows: usize, rate_hz: f64, change: impl Fn(&str, usize, f64) -> f64) -> Self {
        let draw = &mut Draw::of(1);
        let time = ("t_s".to_owned(), (0..rows).map(|row| row as f64 / rate_hz).collect());
        let axis = |name: &&str| {
            let level = if *name == "az_mps2" { 9.81 } else { 0.0 };
            let values = (0..rows).map(|row| change(name, row, level + 0.01 * draw.normal())).collect();
            ((*name).to_owned(), values)
        };
        Self { columns: std::iter::once(time).chain(AXES.iter().map(axis)).collect() }
    }

    fn rows(&self) -> usize {
        self.columns[0].1.len()
    }

    fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (index, (_, values)) in self.columns.iter().enumerate() {
                let comma = if index > 0 { "," } else { "" };
                let value = values[row];
                let _ =
                    if value.is_nan() { write!(text, "{comma}") } else { write!(text, "{comma}{value:?}") };
            }
            text.push('\n');
        }
        text
    }

    fn axis(&self) -> &str {
        let axis = self.columns.iter().map(|(name, _)| name.as_str()).find(|name| AXES.contains(name));
        axis.unwrap_or("gx_rads")
    }
}

/// Timestamps: regular, with jitter, repeated, set back, with gaps and pauses, in bursts, in another unit.
fn times(draw: &mut Draw, rows: usize, rate_hz: f64) -> Vec<f64> {
    let mut times: Vec<f64> = (0..rows).map(|row| row as f64 / rate_hz).collect();
    let at = draw.below(rows);
    match draw.below(9) {
        0 => times.iter_mut().for_each(|time| *time += 0.2 * draw.normal() / rate_hz),
        1 => {
            for row in 1..rows {
                if draw.chance(0.1) {
                    times[row] = times[row - 1];
                }
            }
        }
        2 => times.iter_mut().skip(at).for_each(|time| *time -= 0.7 * at as f64 / rate_hz),
        3 => {
            let mut later = 0.0;
            for time in &mut times {
                later += if draw.chance(0.01) { draw.between(0.0, 100.0) / rate_hz } else { 0.0 };
                *time += later;
            }
        }
        4 => {
            let (burst, pause_s) = (2 + draw.below(200), draw.between(1.0, 1e3));
            times.iter_mut().enumerate().for_each(|(row, time)| *time += pause_s * (row / burst) as f64);
        }
        5 => {
            let unit = 10_f64.powi(draw.below(12) as i32 - 3);
            times.iter_mut().for_each(|time| *time *= unit);
        }
        // the clock was set after the start: up to a century
        6 => {
            let later_s = 10_f64.powf(draw.between(1.0, 9.5));
            times.iter_mut().skip(at).for_each(|time| *time += later_s);
        }
        _ => {}
    }
    times
}

fn values(draw: &mut Draw, name: &str, rows: usize) -> Vec<f64> {
    let size = 10_f64.powf(draw.between(-4.0, 0.0));
    let mut values: Vec<f64> = (0..rows).map(|_| size * draw.normal()).collect();
    match draw.below(10) {
        0 => values.fill(size),
        1 => {
            let mut sum = 0.0;
            values.iter_mut().for_each(|value| {
                sum += *value;
                *value = sum;
            });
        }
        2 => {
            let most = if draw.chance(0.3) { 300.0 } else { 12.0 };
            let scale = 10_f64.powf(draw.between(-most, most));
            values.iter_mut().for_each(|value| *value *= scale);
        }
        3 => values.iter_mut().for_each(|value| *value = (*value / size).round() * size),
        4 => {
            let turn = draw.between(0.0, 3.0);
            values.iter_mut().enumerate().for_each(|(row, value)| *value = size * (turn * row as f64).sin());
        }
        5 => {
            let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, 0.0][draw.below(5)];
            values.iter_mut().for_each(|value| *value = if draw.chance(0.02) { odd } else { *value });
        }
        6 => values.iter_mut().skip(rows / 2).for_each(|value| *value += 10.0 * size),
        _ => {}
    }
    match name {
        "temp_c" => values.iter_mut().for_each(|value| *value += 25.0),
        "az_mps2" if draw.chance(0.7) => values.iter_mut().for_each(|value| *value += 9.81),
        "still" | "segment" => {
            let length = 1 + rows / (1 + draw.below(20));
            let still = name == "still";
            let label = |row: usize| if still { (row / length) % 2 } else { row / length };
            values.iter_mut().enumerate().for_each(|(row, value)| *value = label(row) as f64);
        }
        _ => {}
    }
    values
}

/// Empties cells: none, the first, the last, all but every k-th, every k-th, at random, blocks, all.
fn empty(draw: &mut Draw, values: &mut [f64], (kind, every, share): (usize, usize, f64)) {
    let rows = values.len();
    let part = (share * rows as f64) as usize;
    for (row, value) in values.iter_mut().enumerate() {
        let is_empty = match kind {
            0 => row < part,
            1 => row >= part,
            2 | 3 => row % every != 0,
            4 => row % every == 0,
            5 => draw.chance(share),
            6 => (row / (1 + part / 3)) % 2 == 1,
            7 => share < 0.5,
            8 => row % every != every / 2 && draw.chance(0.99),
            _ => false,
        };
        if is_empty {
            *value = f64::NAN;
        }
    }
}

/// End of a command.
#[derive(Debug, PartialEq)]
enum End {
    Done,
    /// Refusal with the problem and a remedy.
    Refused,
    /// Exceeded its processor time.
    Endless,
    /// Any other end, with its output.
    Broken(String),
}

/// Runs a program in a folder, within the limits.
fn run(folder: &Path, cpu_s: u32, program: &str, arguments: &[&str]) -> End {
    let limited = format!("ulimit -v {MEMORY_KB}; ulimit -t {cpu_s}; exec \"$0\" \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &limited, program])
        .args(arguments)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    match output.status.code() {
        _ if text.contains("panicked") => End::Broken(text),
        // each command must be able to read the output of the previous one
        _ if text.contains("not a study") => End::Broken(text),
        Some(0) => End::Done,
        Some(1 | 2) if text.contains("error: ") && text.contains("help: ") => End::Refused,
        // ended by a signal: SIGXCPU, and SIGKILL a second later
        None | Some(152 | 137) if !text.contains("memory allocation") => End::Endless,
        _ => End::Broken(text),
    }
}

/// Runs the commands on a table in order, and returns those that neither answered nor refused.
fn failures(table: &Table, seed: u64) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), table.csv()).expect("written");
    let axis = table.axis();
    let has = |name: &str| table.columns.iter().any(|(column, _)| column == name);
    let mut fit = vec!["fit", "log.csv", "-o", "study.json"];
    match seed % 5 {
        0 => fit.extend(["--method", "burg"]),
        1 if has("temp_c") => fit.extend(["--physical", "temp_c"]),
        2 if has("temp_c") => fit.extend(["--input", "temp_c"]),
        3 => fit.extend(["--axis", axis, "--max-lag", "3"]),
        _ => {}
    }
    let lines: [&[&str]; 13] = [
        &fit,
        &["compare", "study.json"],
        &["compare", "study.json", "log.csv"],
        &["diagnose", "log.csv", "--axis", axis],
        &["add", "study.json", "bias_ramp", "--from", "log.csv"],
        &["noise", "log.csv"],
        &["calibrate-imu", "log.csv", "-o", "certificate.md"],
        &["convert", "log.csv", "-o", "other.csv"],
        &["report", "study.json", "--from", "log.csv"],
        &["table", "log.csv", "--axis", axis, "--degree", "1", "--max-order", "2", "--repeats", "1"],
        &["fleet", ".", "-o", "population.json"],
        &["export", "study.json", "--image", "unit.fosm"],
        &["replay", "unit.fosm", "log.csv"],
    ];
    let mut failed = Vec::new();
    for line in lines {
        let needs = line.iter().skip(1).take(1).find(|word| ["study.json", "unit.fosm"].contains(*word));
        if needs.is_some_and(|file| !folder.path().join(file).exists()) {
            continue;
        }
        let end = run(folder.path(), CPU_S, env!("CARGO_BIN_EXE_fos"), line);
        if !matches!(end, End::Done | End::Refused) {
            failed.push(format!("seed {seed}, {} rows: {}: {end:?}", table.rows(), line.join(" ")));
        }
    }
    failed
}

#[test]
fn every_command_answers_or_refuses_random_tables() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let tables = number("FOS_RANDOM_TABLES").or(is_thorough().then_some(THOROUGH));
    let first = number("FOS_RANDOM_SEED").unwrap_or(0);
    let longest = if number("FOS_RANDOM_TABLES").is_some() { 2e4 } else { 2e3 };
    let seeds = first..first + tables.unwrap_or(TABLES);
    let failed: Vec<String> = seeds
        .into_par_iter()
        .flat_map_iter(|seed| {
            let failed = failures(&Table::random(seed, longest), seed);
            // in a long run, print at once
            failed.iter().for_each(|failed| println!("{failed}"));
            failed
        })
        .collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    println!(
        "attack: random tables | {} tables (rates of 0.1 Hz to 10 kHz, columns, empty cells, timestamps, values) through 12 command lines: each gives a result, or an error with a remedy, within {CPU_S} s of processor time and {} MB | negative control: a panic, an endless loop and an error without a remedy are detected",
        tables.unwrap_or(TABLES),
        MEMORY_KB / 1000,
    );
}

/// Tables that once broke a command.
#[test]
fn every_command_answers_or_refuses_tables_that_broke_one() {
    let nan = f64::NAN;
    let sparse = |every: usize| {
        move |name: &str, row: usize, value: f64| {
            if name == "ax_mps2" && !row.is_multiple_of(every) { nan } else { value }
        }
    };
    let tables = [
        // between 5 and 10 samples a second
        Table::regular(600, 6.0, |_, _, value| value),
        Table::regular(600, 9.9, |_, _, value| value),
        // a log merged by hand, and an axis with few values
        Table::regular(2000, 200.0, sparse(2)),
        Table::regular(2000, 200.0, sparse(20)),
        Table::regular(2000, 200.0, |_, row, value| if (row * row + row / 3) % 11 > 0 { nan } else { value }),
        // slower than a stretch whose power is compared
        Table::regular(2500, 0.1, |_, row, value| value + 0.1 * (2.0 * row as f64).sin()),
        // constant: every regressor vanishes
        Table::regular(1500, 50.0, |_, _, _| 1.0),
    ];
    let failed: Vec<String> =
        tables.par_iter().enumerate().flat_map_iter(|(index, table)| failures(table, index as u64)).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn detects_a_panic_a_loop_and_a_refusal_without_help() {
    let folder = tempfile::tempdir().expect("a folder");
    let end = |script: &str| run(folder.path(), 1, "sh", &["-c", script]);
    assert!(matches!(end("echo 'thread main panicked at x.rs' >&2; exit 101"), End::Broken(_)));
    assert!(matches!(end("echo 'error: no' >&2; exit 1"), End::Broken(_)));
    assert!(matches!(end("echo 'error: a.json: not a study\nhelp: none' >&2; exit 1"), End::Broken(_)));
    assert_eq!(end("while :; do :; done"), End::Endless);
    assert_eq!(end("echo 'error: no\nhelp: yes' >&2; exit 1"), End::Refused);
    assert_eq!(end("exit 0"), End::Done);
}
