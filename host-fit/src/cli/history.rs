//! `history`: the added effects of a study.

use std::path::PathBuf;

use clap::Args;

use super::arguments::OutputFolder;
use super::output::{Failure, print_hint, print_json, print_line};
use super::refinement::{calibration_in_words, print_refinement};
use super::units::Printed;
use fos_diagnose::study::Study;
use fos_figures::plots;

/// Show the added effects, and the error after each
#[derive(Debug, Args)]
#[command(after_help = "Example: fos history unit.json --figures figures")]
pub(super) struct History {
    /// The study
    study: PathBuf,
    /// Folder for the figures of the error after each effect, SVG and PNG; created if missing
    #[arg(long, value_name = "FOLDER")]
    figures: Option<OutputFolder>,
    #[command(flatten)]
    printed: Printed,
    /// Print the steps as JSON
    #[arg(long)]
    json: bool,
}

impl History {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let study = Study::read(&self.study)?;
        if let Some(folder) = &self.figures {
            for refinement in &study.refinements {
                plots::write_staircase(folder, refinement)?;
            }
        }
        if self.json {
            return print_json(&study.refinements);
        }
        if let Some(calibration) = &study.model.calibration {
            print_line!("{}", calibration_in_words(calibration));
        }
        if study.refinements.is_empty() {
            print_line!("nothing was added\nhelp: `fos add STUDY EFFECT --from LOG` adds an effect");
            return Ok(());
        }
        study.refinements.iter().for_each(|refinement| print_refinement(refinement, self.printed));
        print_hint(self.printed);
        Ok(())
    }
}
