//! `record`: from the telemetry of a device to a log.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::output::{Failure, print_json};
use crate::record::record;
use crate::recording::write_columns;

/// Turn the telemetry of a device into a log that diagnose takes
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit record /dev/ttyACM0 --seconds 600 -o field.parquet")]
pub(super) struct Record {
    /// The stream: a serial port that is set up (stty), a file, or - for standard input
    stream: PathBuf,
    /// The log to write: .csv, .csv.gz or .parquet
    #[arg(short, long)]
    output: PathBuf,
    /// Stop after so long; else at the end of the stream
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Print what came and what was lost as JSON
    #[arg(long)]
    json: bool,
}

impl Record {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let stream: Box<dyn Read> = match self.stream == Path::new("-") {
            true => Box::new(io::stdin().lock()),
            false => Box::new(
                File::open(&self.stream).map_err(|error| format!("{}: {error}", self.stream.display()))?,
            ),
        };
        let until = self.seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds.max(0.0)));
        let recorded = record(BufReader::new(stream), |_| until.is_none_or(|until| Instant::now() < until))
            .map_err(|error| format!("{}: {error}", self.stream.display()))?;
        let columns: Vec<(&str, &[f64])> =
            recorded.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        write_columns(&self.output, &columns)?;
        let report = &recorded.report;
        if self.json {
            return print_json(report);
        }
        println!(
            "{} samples, {} lost (gaps in the log), {} damaged frames, {} before what they hold was known, {} restarts",
            report.samples, report.lost, report.damaged, report.unknown, report.restarts
        );
        println!("log written to {}", self.output.display());
        Ok(())
    }
}
