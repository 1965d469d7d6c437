//! `calibrate`: how often the diagnosis is right, on simulated cases.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFile, library};
use super::numbers::count;
use super::output::{Failure, number, print_json, print_line, progress, table};
use crate::calibration::{Calibration, Goal, KeptOutcomes, Statistic, calibrate};
use fos_data::file::write_atomically;

/// Simulate cases with hidden effects, diagnose them, and print how often the diagnosis is right
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit calibrate --cases 450 --seed 1")]
pub(super) struct Calibrate {
    /// Cases: a third with nothing missing
    #[arg(long, default_value_t = 450, value_parser = count(0..=100_000))]
    cases: usize,
    /// Seed of all of them
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write what came out of every case to this file, JSON. Until all have, what came out is kept in FILE.partial: a
    /// calibration that was broken off goes on where it was
    #[arg(long, value_name = "FILE")]
    outcomes: Option<OutputFile>,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Fail if a figure is certainly not as it must be, its 95 % interval considered
    #[arg(long)]
    check: bool,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

impl Calibrate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let bar = progress(self.cases as u64, "diagnosing");
        let keep = |path: &OutputFile| KeptOutcomes::beside(path, self.seed, self.cases, &library);
        let kept = self.outcomes.as_ref().map(keep).transpose()?;
        let advance = |done| bar.set_position(done as u64);
        let calibration = calibrate(self.seed, self.cases, &library, kept.as_ref(), advance)?;
        bar.finish_and_clear();
        if let Some(path) = &self.outcomes {
            write_atomically(path, &serde_json::to_vec_pretty(&calibration.outcomes)?)?;
        }
        kept.into_iter().for_each(KeptOutcomes::remove);
        if self.json {
            print_json(&calibration.figures)?;
        } else {
            print(&calibration);
        }
        let missed: Vec<&str> = calibration
            .figures
            .iter()
            .filter(|figure| !figure.may_hold())
            .map(|figure| figure.name.trim())
            .collect();
        if self.check && !missed.is_empty() {
            return Err(format!("not as it must be: {}", missed.join("; ")).into());
        }
        Ok(())
    }
}

fn print(calibration: &Calibration) {
    print_line!("{} cases, seed {}\n", calibration.outcomes.len(), calibration.seed);
    let mut rows = table(&["figure", "value", "95 % interval", "cases", "must", "aim", ""]);
    for figure in &calibration.figures {
        let (must, aim) = match figure.goal {
            Goal::AtLeast(must, aim) => (format!("≥ {}", number(must)), format!("≥ {}", number(aim))),
            Goal::AtMost(must, aim) | Goal::Seconds(must, aim) => {
                (format!("≤ {}", number(must)), format!("≤ {}", number(aim)))
            }
            Goal::Within(must, aim) => (range(&must), range(&aim)),
        };
        rows.add_row(vec![
            figure.name.clone(),
            figure.value.map_or_else(|| "–".to_owned(), number),
            figure.interval.map_or_else(String::new, |interval| range(&interval)),
            figure.cases.to_string(),
            must,
            aim,
            judged(figure).to_owned(),
        ]);
    }
    print_line!("{rows}");
}

fn range([low, high]: &[f64; 2]) -> String {
    format!("{} … {}", number(*low), number(*high))
}

fn judged(figure: &Statistic) -> &'static str {
    if figure.holds() { "" } else { "missed" }
}
