//! `convert`: converts a log of any format to the log format.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFile, Reading, describe};
use super::output::{Failure, Written, print_line, print_warning, print_written};
use super::units::Printed;
use fos_data::column::Triad;
use fos_data::recording::{SensorProvenance, check_log_path, write_columns};
use fos_data::stillness::find;

/// Convert a log of any supported format to CSV or Parquet
///
/// Channels are named as in the log format and in SI units; streams with separate timestamps are resampled to a common time base.
#[derive(Debug, Args)]
#[command(after_help = "Example: fos convert flight.ulg -o flight.parquet")]
pub(super) struct Convert {
    /// The log
    log: PathBuf,
    /// The file to write: .csv, .csv.gz or .parquet
    #[arg(short, long, value_name = "FILE")]
    output: OutputFile,
    #[command(flatten)]
    reading: Reading,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Convert {
    pub(super) fn run(&self) -> Result<(), Failure> {
        check_log_path(&self.output)?;
        let recording = self.reading.read(&self.log)?;
        let mut columns: Vec<(&str, &[f64])> = vec![("t_s", &recording.time_s)];
        let still: Option<Vec<f64>> = recording
            .still
            .as_ref()
            .map(|still| still.iter().map(|still| f64::from(u8::from(*still))).collect());
        columns
            .extend(recording.channels().iter().map(|channel| (channel.name.as_str(), &channel.values[..])));
        columns.extend(still.as_ref().map(|still| ("still", &still[..])));
        write_columns(&self.output, &columns)?;
        if !self.json {
            print_line!("{}", describe(&recording, &find(&recording), Printed::default()));
        }
        let by = [Triad::Accelerometers, Triad::Gyros].map(|triad| recording.provenance(triad));
        if let Some(by) = by.iter().find_map(SensorProvenance::corrected_by) {
            print_warning(&format!(
                "its values were corrected by {by}, which the log format does not state\n\
                 help: fit {} with --factory-corrected, and make no temperature table of it",
                self.output.display()
            ));
        }
        let what = format!("{} rows of {} columns", recording.n_rows(), columns.len());
        print_written(&[Written { path: self.output.display().to_string(), what }], self.json)
    }
}
