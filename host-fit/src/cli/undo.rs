//! `undo`: removes the effect that was added last.

use std::path::PathBuf;

use clap::Args;

use super::output::{Failure, print_hint, print_json, print_line};
use super::refinement::{calibration_in_words, named, print_refinement};
use super::units::Printed;
use fos_diagnose::study::Study;

/// Remove the effect that was added last, or the calibration
#[derive(Debug, Args)]
#[command(after_help = "Example: fos undo unit.json")]
pub(super) struct Undo {
    /// The study
    study: PathBuf,
    /// The axis, if the study has several
    #[arg(long)]
    axis: Option<String>,
    /// Remove the calibration of the device instead
    #[arg(long, conflicts_with = "axis")]
    calibration: bool,
    #[command(flatten)]
    printed: Printed,
    /// Print the remaining steps as JSON
    #[arg(long)]
    json: bool,
}

impl Undo {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let (mut study, file) = Study::read_to_change(&self.study)?;
        if self.calibration {
            let Some(removed) = study.model.calibration.take() else {
                return Err(format!(
                    "{} has no calibration\nhelp: `fos calibrate-imu LOG --study STUDY` adds one",
                    self.study.display()
                )
                .into());
            };
            study.write(&file)?;
            if self.json {
                return print_json(&removed);
            }
            print_line!("removed: {}", calibration_in_words(&removed));
            return Ok(());
        }
        let column = named(study.column_to_undo(self.axis.as_deref()))?;
        let effect = study.undo(&column)?;
        study.write(&file)?;
        let refinement = study.refinement_of(&column);
        if self.json {
            return print_json(&refinement);
        }
        print_line!("removed: {effect}");
        refinement.iter().for_each(|refinement| print_refinement(refinement, self.printed));
        print_hint(self.printed);
        Ok(())
    }
}
