//! `simulate`: a log with known truth, one case, or a suite of cases.

use std::path::Path;

use clap::Args;

use super::arguments::OutputFile;
use super::numbers::within;
use super::output::{Failure, Written, print_written};
use super::simulate_case::CaseArguments;
use fos_data::recording::{RATES_HZ, write_columns};
use fos_simulate::band_limited::{self, band_limited};
use fos_simulate::{Simulation, simulate};

/// Maximum number of rows of a log, which is created in memory: some ten gigabytes.
const MOST_ROWS: f64 = 7.0 * 86_400.0 * 200.0;

/// Simulate a log with known truth
#[derive(Debug, Args)]
#[command(after_help = "Example: fos simulate unit.parquet --minutes 20 --seed 7 --truth\n         \
    fos simulate --case case_1 --setup desk --target ay --effect load_heating:tau_s=60 --size 40\n         \
    fos simulate --suite 45 cases --seed 3")]
pub(super) struct Simulate {
    /// The log to write: .csv, .csv.gz or .parquet; with --suite, the folder
    #[arg(required_unless_present = "case")]
    log: Option<OutputFile>,
    /// Duration, min
    #[arg(long, default_value_t = 20.0, value_parser = within(0.001..=20_000.0))]
    minutes: f64,
    /// Nominal sample rate, Hz; the true one is off by up to 1 %
    #[arg(long, default_value_t = 200.0, value_parser = within(RATES_HZ))]
    rate: f64,
    /// Seed of every random number
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Sensitivity to temperature, as a multiple of the simulated device's; 0 for none
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = within(-1000.0..=1000.0))]
    temperature: f64,
    /// Never move the device; otherwise it moves for 30 s of every 90 s in the last third
    #[arg(long)]
    at_rest: bool,
    /// Simulate the paper's signals instead: band-limited nonlinear error of an accelerometer and a gyro, with an innovation of 10⁻⁴ of
    /// its size
    #[arg(long, conflicts_with_all = ["rate", "temperature", "at_rest", "truth"])]
    band_limited: bool,
    /// Add the true values as columns ref_ax_mps2 … ref_gz_rads
    #[arg(long)]
    truth: bool,
    #[command(flatten)]
    case: CaseArguments,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Simulate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.case.are_given() {
            return self.case.run(self.log.as_deref(), self.seed, self.json);
        }
        let Some(log_path) = &self.log else { return Err("name the log to write".into()) };
        let rate_hz = if self.band_limited { band_limited::RATE_HZ } else { self.rate };
        let rows = self.minutes * 60.0 * rate_hz;
        if rows > MOST_ROWS {
            return Err(format!(
                "{} minutes at {rate_hz} Hz are {rows:.0} rows, more than {MOST_ROWS:.0}, a week at 200 Hz\nhelp: a smaller --minutes or --rate",
                self.minutes
            )
            .into());
        }
        if self.band_limited {
            return write(log_path, &band_limited(self.minutes * 60.0, self.seed), self.json);
        }
        let log = simulate(&Simulation {
            duration_s: self.minutes * 60.0,
            rate_hz: self.rate,
            seed: self.seed,
            temperature: self.temperature,
            motion: !self.at_rest,
        });
        let truth = if self.truth { log.truth } else { Vec::new() };
        write(log_path, &log.columns.into_iter().chain(truth).collect::<Vec<_>>(), self.json)
    }
}

fn write(log: &Path, columns: &[(String, Vec<f64>)], json: bool) -> Result<(), Failure> {
    let borrowed: Vec<(&str, &[f64])> =
        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    write_columns(log, &borrowed)?;
    let what = format!("{} rows, {} columns", columns[0].1.len(), columns.len());
    print_written(&[Written { path: log.display().to_string(), what }], json)
}
