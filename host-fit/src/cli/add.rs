//! `add`: adds a missing effect to the model of a study.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFolder, Reading, library};
use super::diagnose::print_diagnosis;
use super::output::{Failure, print_hint, print_json, print_line, spinner};
use super::refinement::{LogArguments, column_of, print_refinement, read_logs};
use super::units::Printed;
use fos_diagnose::session::{Addition, add};
use fos_diagnose::study::Study;
use fos_figures::plots;

/// Add a missing effect to a model, and show by how much the error falls
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos add unit.json thermal_lag --from log.parquet --evaluate-on evaluation.parquet\nExample: fos add unit.json --best"
)]
pub(super) struct Add {
    /// The study
    study: PathBuf,
    /// The effect, by its identifier
    #[arg(required_unless_present = "best", conflicts_with = "best")]
    effect: Option<String>,
    /// Add the findings of the diagnosis, the most useful first, until nothing is worth adding
    #[arg(long)]
    best: bool,
    /// The axis, if the study has several
    #[arg(long)]
    axis: Option<String>,
    #[command(flatten)]
    logs: LogArguments,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE", id = "effect_files")]
    effects: Vec<PathBuf>,
    /// Folder for the figure of the error after each effect, SVG and PNG; created if missing
    #[arg(long, value_name = "FOLDER")]
    figures: Option<OutputFolder>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    printed: Printed,
    /// Print the steps as JSON
    #[arg(long)]
    json: bool,
}

impl Add {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let (mut study, file) = Study::read_to_change(&self.study)?;
        let column = column_of(&study, self.axis.as_deref())?;
        let logs = read_logs(&self.logs, &self.reading, &study, &self.study, &column)?;
        let bar = spinner("estimating and evaluating");
        let addition = self.effect.as_deref().map_or(Addition::Best, Addition::Effect);
        let refinement = add(&mut study, &column, &logs, &library, addition, &mut |diagnosis, step| {
            if !self.json {
                bar.suspend(|| match step {
                    None if self.printed.details => print_diagnosis(diagnosis, self.printed),
                    _ => print_line!("{}", diagnosis.sentence),
                });
            }
        })?;
        bar.finish_and_clear();
        if let Some(folder) = &self.figures {
            plots::check_staircase(folder, &column)?;
        }
        study.write(&file)?;
        if let Some(folder) = &self.figures {
            plots::write_staircase(folder, &refinement)?;
        }
        if self.json {
            return print_json(&refinement);
        }
        print_refinement(&refinement, self.printed);
        print_line!("\nstudy written to {}", self.study.display());
        if let Some(folder) = &self.figures {
            print_line!("figure written to {}", folder.display());
        }
        print_hint(self.printed);
        Ok(())
    }
}
