//! `inspect`: content of an image.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::Args;
use fos_core::Image;
use fos_core::image::VERSION;
use serde_json::{Value, json};

use super::arguments::is_study;
use super::output::{Failure, print_json, print_line, print_text};
use fos_data::file;
use fos_export::description;

/// Show what is in a model image
#[derive(Debug, Args)]
#[command(after_help = "Example: fos inspect unit.fosm")]
pub(super) struct Inspect {
    /// The image
    image: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let bytes = file::read(&self.image)?;
        let of_image = |error| not_an_image(&self.image, &error);
        let image = Image::parse(&bytes).map_err(of_image)?;
        if self.json {
            return print_json(&as_json(&image));
        }
        print_line!("{} bytes, format version {VERSION}, checksum right", bytes.len());
        print_text!("{}", description(&image));
        Ok(())
    }
}

/// Error for a file that is not an image; for a study with the command that makes one.
pub(super) fn not_an_image(path: &Path, error: &impl Display) -> String {
    let help = match is_study(path) {
        true => {
            format!("\nhelp: `fos export {} --image unit.fosm` makes an image of a study", path.display())
        }
        false => String::new(),
    };
    format!("{}: {error}{help}", path.display())
}

fn as_json(image: &Image<'_>) -> Value {
    let info = image.info();
    let terms = |terms: fos_core::image::Terms<'_>| -> Vec<Value> {
        terms.map(|term| json!({ "coefficient": term.coefficient, "factors": term.factors() })).collect()
    };
    let axes: Vec<Value> = image
        .axes()
        .map(|axis| {
            json!({
                "parameters": axis.parameters,
                "physical": terms(axis.physical),
                "stochastic": terms(axis.stochastic),
            })
        })
        .collect();
    json!({
        "format_version": VERSION,
        "sensor": info.sensor,
        "quantities": info.quantities.lines().collect::<Vec<_>>(),
        "effects": info.effects.lines().collect::<Vec<_>>(),
        "provenance": info.provenance,
        "period_s": image.period_s(),
        "fitted_on": image.fitted_on(),
        "stillness": image.stillness(),
        "inputs": image.inputs().collect::<Vec<_>>(),
        "axes": axes,
    })
}
