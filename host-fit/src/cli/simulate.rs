//! `simulate`: a log with known truth.

use std::path::PathBuf;

use clap::Args;

use super::output::Failure;
use crate::recording::write_columns;
use crate::simulate::{Simulation, simulate};

/// Write a simulated log: six axes and temperature, every number from the seed
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit simulate unit.parquet --minutes 20 --seed 7 --truth")]
pub(super) struct Simulate {
    /// The log to write: .csv, .csv.gz or .parquet
    log: PathBuf,
    /// Duration, min
    #[arg(long, default_value_t = 20.0)]
    minutes: f64,
    /// Nominal sample rate, Hz; the true one is off by up to 1 %
    #[arg(long, default_value_t = 200.0)]
    rate: f64,
    /// Seed of every random number
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Sensitivity to temperature, as a multiple of the unit's; 0 for none
    #[arg(long, default_value_t = 1.0)]
    temperature: f64,
    /// Never move the unit; else it is moved for 30 s out of every 90 s in the last third
    #[arg(long)]
    at_rest: bool,
    /// Add the true values as columns ref_ax_mps2 … ref_gz_rads
    #[arg(long)]
    truth: bool,
}

impl Simulate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if !(self.minutes > 0.0 && self.rate > 0.0) {
            return Err("--minutes and --rate must be positive".into());
        }
        let log = simulate(&Simulation {
            duration_s: self.minutes * 60.0,
            rate_hz: self.rate,
            seed: self.seed,
            temperature: self.temperature,
            motion: !self.at_rest,
        });
        let truth = if self.truth { log.truth.as_slice() } else { &[] };
        let columns: Vec<(&str, &[f64])> = log
            .columns
            .iter()
            .chain(truth)
            .map(|(name, values)| (name.as_str(), values.as_slice()))
            .collect();
        write_columns(&self.log, &columns)?;
        println!("{}: {} rows, {} columns", self.log.display(), columns[0].1.len(), columns.len());
        Ok(())
    }
}
