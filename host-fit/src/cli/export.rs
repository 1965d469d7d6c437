//! `export`: converts a study for a device.

use std::path::{Path, PathBuf};

use clap::Args;
use fos_core::FittedOn;
use fos_embedded::hub::{PERIOD_TOLERANCE, is_given};

use super::arguments::OutputFile;
use super::output::{Failure, Written, print_json, print_line, print_warning, print_written};
use super::temperature_tables::TableArguments;
use super::units::three;
use fos_data::file::write_atomically;
use fos_data::recording::Source;
use fos_data::text::counted;
use fos_diagnose::study::Study;
use fos_export::{Refusal, c_source, image, rust_source};
use fos_fit::model::UnitModel;

/// Export a model as an image, Rust, C, or PX4 and ArduPilot parameters
///
/// Both sources come with a test vector: raw samples and the bits that the device must compute from them. Its `check` runs
/// them at start-up. Rust source needs fos-core, its check fos-embedded; the header needs fos.h. The command prints the
/// sensor settings that the model needs, and warns if a hub refuses it.
///
/// The tables for PX4 and ArduPilot are cubics of temperature, fitted to the log of the study and evaluated on the same
/// rows as the study. These autopilots correct by nothing else.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos export unit.json --image unit.fosm --rust model.rs --c model.h\n         \
    fos export unit.json --instance 0 --px4 unit.params --ardupilot unit.parm --evaluate-on evaluation.parquet"
)]
pub(super) struct Export {
    /// The study
    study: PathBuf,
    /// The image to write
    #[arg(long, value_name = "FILE")]
    image: Option<OutputFile>,
    /// The Rust source to write
    #[arg(long, value_name = "FILE")]
    rust: Option<OutputFile>,
    /// The C header to write; everything in it is named after it: model.h has model_image, model_check
    #[arg(long, value_name = "FILE")]
    c: Option<OutputFile>,
    /// Name of the sensor, stored in the image
    #[arg(long, default_value = "")]
    sensor: String,
    #[command(flatten)]
    tables: TableArguments,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Export {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let has_model = self.image.is_some() || self.rust.is_some() || self.c.is_some();
        if !has_model && !self.tables.are_given() {
            return Err("nothing to write\nhelp: give --image FILE, --rust FILE, --c FILE, --px4 FILE, --ardupilot FILE, or several".into());
        }
        self.tables.check()?;
        let study = Study::read(&self.study)?;
        let (model, provenance) = (&study.model, study.provenance());
        // All outputs are checked before any is written.
        let image = match &self.image {
            Some(path) => Some((path, image(model, &self.sensor, &provenance)?)),
            None => None,
        };
        let header = match &self.c {
            Some(path) => {
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                Some((path, c_source(model, &name, &self.sensor, &provenance)?))
            }
            None => None,
        };
        let tables = self.tables.fit(&study, &self.study)?;
        let mut written = Vec::new();
        let mut note = |path: &Path, what: String| {
            written.push(Written { path: path.display().to_string(), what });
        };
        let terms = model.n_terms();
        if let Some((path, bytes)) = &image {
            write_atomically(path, bytes)?;
            note(path, format!("{} bytes, {}", bytes.len(), counted(terms, "term")));
        }
        if let Some(path) = &self.rust {
            write_atomically(path, rust_source(model, &provenance).as_bytes())?;
            note(path, format!("Rust source, {}", counted(terms, "term")));
        }
        if let Some((path, source)) = &header {
            write_atomically(path, source.as_bytes())?;
            note(path, format!("C header, {}", counted(terms, "term")));
        }
        if let Some(tables) = &tables {
            self.tables.write(tables, &mut written)?;
        }
        match (&tables, self.json) {
            (Some(tables), true) => {
                print_json(&serde_json::json!({ "written": written, "temperature": tables.as_json() }))?;
            }
            (Some(tables), false) => {
                print_written(&written, false)?;
                tables.print();
            }
            (None, json) => print_written(&written, json)?,
        }
        if !has_model {
            return Ok(());
        }
        // The format omits unknown values; readers of an earlier version did not.
        let is_unknown =
            |source: &Source| source.read_as.as_ref().is_some_and(|read_as| read_as.provenance.is_none());
        if model.fitted_on == FittedOn::Raw && study.data.sources.iter().any(is_unknown) {
            print_warning(
                "the study is of a version that did not record whether the log's values were corrected; the model is written as one of raw values\n\
                 help: fit the log again",
            );
        }
        match Refusal::of(model) {
            // Rust source includes a hub of sufficient size.
            Some(Refusal::TooLargeForC(_)) if self.image.is_none() => {}
            Some(refusal) => {
                print_warning(&refusal.to_string());
                if matches!(refusal, Refusal::Hub { .. }) {
                    return Ok(());
                }
            }
            None => {}
        }
        if !self.json {
            print_sensor(model);
        }
        Ok(())
    }
}

/// Prints the sensor settings that a hub needs for this model.
fn print_sensor(model: &UnitModel) {
    let values = match model.fitted_on {
        FittedOn::Raw => "raw values",
        FittedOn::FactoryCorrected => "factory-corrected values",
    };
    print_line!(
        "a hub accepts it for a sensor at {} samples per second, within {:.0} %, with {values}",
        three(1.0 / model.period_s),
        100.0 * PERIOD_TOLERANCE
    );
    let given = model.quantities.iter().filter(|logged| is_given(logged.quantity));
    let given: Vec<&str> = given.map(|logged| logged.column.as_str()).collect();
    if !given.is_empty() {
        print_line!("the application gives the hub, in this order: {}", given.join(", "));
    }
}
