//! `replay`: runs an image over a log on fos-core in f32, as a device does.

use std::path::PathBuf;

use clap::Args;
use fos_core::Image;
use fos_data::unit::MG_MPS2;
use serde::Serialize;

use super::arguments::{OutputFile, Reading};
use super::inspect::not_an_image;
use super::output::{Failure, print_json, print_line, spinner, table};
use super::units::{ErrorUnit, UnitsOption, percent, three};
use fos_data::file;
use fos_data::recording::{Recording, write_columns};
use fos_data::stillness::{self, Stillness};
use fos_data::text::counted;
use fos_device_io::hub_log::hub_log;
use fos_device_io::replay::{CostOfScalar, Replay as Replayed, Summary, replay};

/// Run an image over a log as on the device, and write the corrected log
#[derive(Debug, Args)]
#[command(after_help = "Example: fos replay unit.fosm log.parquet -o corrected.parquet")]
pub(super) struct Replay {
    /// The image
    image: PathBuf,
    /// The log, in any format that `fos formats` lists
    log: PathBuf,
    /// The corrected log to write: .csv, .csv.gz or .parquet
    #[arg(short, long)]
    output: Option<OutputFile>,
    /// Write the log as raw samples for test firmware with a hub, in Rust or C, and print the digest of its outputs
    #[arg(long, value_name = "FILE")]
    hub_log: Option<OutputFile>,
    /// Columns of the axes and quantities, if the names in the image do not fit: gx_rads,gy_rads
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS")]
    axes: Vec<String>,
    #[command(flatten)]
    shown: UnitsOption,
    #[command(flatten)]
    reading: Reading,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Replay {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let bytes = file::read(&self.image)?;
        let of_image = |error| not_an_image(&self.image, &error);
        let image = Image::parse(&bytes).map_err(of_image)?;
        let recording = self.reading.read(&self.log)?;
        let stillness = stillness::find(&recording);
        let spinner = spinner("replaying");
        let replayed = replay(&image, &recording, &stillness, &self.axes)?;
        spinner.finish_and_clear();
        if let Some(path) = &self.output {
            write_columns(path, &replayed.columns(&recording))?;
        }
        let hub_log = self.hub_log.as_ref();
        let hub_log =
            hub_log.map(|path| self.write_hub_log(path, &bytes, &recording, &stillness)).transpose()?;
        if self.json {
            return print_json(&Printed { summary: &replayed.summary, hub_outputs_digest: hub_log });
        }
        self.print(&replayed);
        if let Some((path, digest)) = self.hub_log.as_ref().zip(hub_log) {
            print_line!(
                "raw samples for a hub written to {}; digest of its outputs {digest}",
                path.display()
            );
        }
        Ok(())
    }

    /// Returns the digest of the outputs of a hub over the log.
    fn write_hub_log(
        &self,
        path: &OutputFile,
        image: &[u8],
        recording: &Recording,
        stillness: &Stillness,
    ) -> Result<String, Failure> {
        let log = hub_log(image, &self.axes, recording, stillness)?;
        file::write_atomically(path, &log.bytes)?;
        Ok(format!("{:016x}", log.outputs))
    }

    fn print(&self, replayed: &Replayed) {
        let summary = &replayed.summary;
        print_line!(
            "{} rows: {} tracked at rest, {} coasted in motion; rest known {}",
            summary.rows,
            summary.tracked,
            summary.rows - summary.tracked,
            summary.still_known_by.describe()
        );
        let header = [
            "  axis",
            "innovations",
            "RMS f32",
            "RMS f64",
            "f32 costs",
            "fixed costs",
            "valid rows",
            "slow error",
            "after 60 s",
            "unit",
        ];
        let mut rows = table(&header);
        for axis in &summary.axes {
            let errors = axis.errors.as_ref();
            let slow = errors.and_then(|errors| errors.slow_error_coast);
            let longest = errors.and_then(|errors| errors.coast.last()).map(|at| at.mse);
            let square = |rms: f64| known(rms).map(|rms| rms * rms);
            let (single, double) = (square(axis.innovation_rms_f32), square(axis.innovation_rms_f64));
            let largest = [single, double, slow, longest].into_iter().flatten().fold(0.0, f64::max);
            let unit = ErrorUnit::of(&axis.column, largest.sqrt(), self.shown.units);
            rows.add_row(vec![
                format!("  {}", axis.column),
                axis.innovations.to_string(),
                unit.root(single),
                unit.root(double),
                cost(axis.cost_of_f32()),
                cost(axis.cost_of_fixed()),
                known(axis.valid_share).map_or_else(|| "–".to_owned(), percent),
                unit.root(slow),
                unit.root(longest),
                unit.label.to_owned(),
            ]);
        }
        print_line!("{rows}");
        print_line!(
            "  slow error: RMS of 1-s means in a free run; after 60 s: RMS at the end of the longest free run, 60 s or less; in f32"
        );
        print_line!(
            "  f32 costs, fixed costs: largest difference of an innovation from f64, divided by their RMS"
        );
        if let Some(reason) = &summary.not_in_fixed_point {
            print_line!("  not in fixed point: {reason}");
        }
        if summary.axes.iter().any(|axis| matches!(axis.cost_of_f32(), CostOfScalar::NothingLeft(_))) {
            print_line!(
                "  of 0: the model predicts this log exactly, so the difference has nothing to be divided by"
            );
        }
        if summary.axes.iter().any(|axis| axis.cost_of_f32() == CostOfScalar::NotKnown) {
            print_line!(
                "  –: no row at rest has its whole history before it, so there is no error to compare\n  \
                 help: use a log with rests, or mark them in a column `still`"
            );
        }
        if let Some(gravity) = summary.gravity.filter(|gravity| gravity.rests > 0) {
            let [measured, corrected] = gravity.residual_mps2.map(|residual| three(residual / MG_MPS2));
            print_line!(
                "  |a| − g, RMS over {}: {measured} mg measured, {corrected} mg corrected",
                counted(gravity.rests, "rest")
            );
        }
        if let Some(gravity) = summary.gravity.filter(|gravity| gravity.rests_away > 0) {
            print_line!(
                "  away from gravity: in {} of {} rests, {} of {} rows, the accelerometers are further from 9.81 m/s² corrected than as measured\n  \
                 help: the model was fitted to something else, for example to two orientations: fit it again to a log in one orientation, or with ref_ columns",
                gravity.rests_away,
                gravity.rests,
                gravity.rows_away,
                gravity.rows
            );
        }
        print_line!("predictor: digest of the innovations  {:016x}", summary.innovations_digest);
        print_line!("predictor: digest of all corrections  {:016x}", summary.corrections_digest);
        if let Some(path) = &self.output {
            print_line!("corrected log written to {}", path.display());
        }
    }
}

/// JSON of a replay.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    hub_outputs_digest: Option<String>,
}

/// A number that is known.
fn known(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

fn cost(of: CostOfScalar) -> String {
    match of {
        CostOfScalar::Relative(cost) => format!("{cost:.1e}"),
        CostOfScalar::NothingLeft(difference) => format!("{difference:.1e} of 0"),
        CostOfScalar::NotKnown => "–".to_owned(),
    }
}
