//! `compare`: a study, measured against model.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{Reading, describe};
use super::error_table::error_table;
use super::output::{Failure, number, print_json, progress};
use crate::compare::{AxisComparison, Comparison, compare};
use crate::evaluate::ModelErrors;

use crate::plots;
use crate::recording::Source;
use crate::rest;
use crate::study::Study;

/// Compare the model of a study with measurements and with plain rivals, and show where it fails
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit compare unit.json field.parquet --figures figures")]
pub(super) struct Compare {
    /// The study
    study: PathBuf,
    /// The log; by default the study's own, judged on the rows that were not fitted
    log: Option<PathBuf>,
    /// Folder for the figures, SVG and PNG; made if it is not there
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

impl Compare {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let study = Study::read(&self.study)?;
        let mut reading = self.reading.clone();
        if reading.map.is_empty() && reading.map_file.is_none() {
            reading.map = study.data.columns.clone();
        }
        let logs: Vec<PathBuf> = match &self.log {
            Some(log) => vec![log.clone()],
            None => study.data.sources.iter().map(|source| PathBuf::from(&source.path)).collect(),
        };
        let recording = reading.read_all(&logs)?;
        let digests = |sources: &[Source]| -> Vec<String> {
            sources.iter().map(|source| source.sha256.clone()).collect()
        };
        let same = digests(&recording.sources) == digests(&study.data.sources);
        if self.log.is_none() && !same {
            return Err(format!(
                "{}: not the log that was fitted: its digest is {}, the study's is {}\nhelp: give the log to compare with as an argument",
                logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>().join(", "),
                digests(&recording.sources).join(", "),
                digests(&study.data.sources).join(", ")
            )
            .into());
        }
        let ratio = study.model.period_s / recording.rate.period_s;
        if (ratio - 1.0).abs() > 0.005 {
            eprintln!(
                "warning: the log runs at {:.3} Hz, the model was fitted at {:.3} Hz: its lags are {:.1} % off in time",
                recording.rate.true_hz,
                1.0 / study.model.period_s,
                100.0 * (ratio - 1.0)
            );
        }
        let rest = rest::find(&recording);
        let rows = if same { study.data.trained_rows..recording.n_rows() } else { 0..recording.n_rows() };
        let bar = progress(4, "judging");
        let (comparison, trace) = compare(&study.model, &study.lag_1(), &recording, &rest, rows, |model| {
            bar.set_message(format!("judging: {model}"));
            bar.inc(1);
        })?;
        bar.finish_and_clear();
        if let Some(folder) = &self.figures {
            plots::write_all(folder, &comparison, &trace, &recording)?;
        }
        if self.json {
            return print_json(&comparison);
        }
        println!("{}", describe(&recording));
        print_comparison(&comparison);
        if let Some(folder) = &self.figures {
            println!("\nfigures written to {}", folder.display());
        }
        Ok(())
    }
}

/// The errors and the worst stretches of every axis.
pub(super) fn print_comparison(comparison: &Comparison) {
    let (begin, end) = comparison.judged_s;
    println!("judged from {begin:.2} s to {end:.2} s, on rows at rest that were not fitted");
    for axis in &comparison.axes {
        print_axis(axis);
    }
}

fn print_axis(axis: &AxisComparison) {
    println!("\n{}: {} rows; squares in ({})²", axis.column, axis.rows, axis.unit);
    let errors: Vec<&ModelErrors> = axis.errors.iter().collect();
    println!("{}", error_table(&errors));
    match axis.noise_floor {
        Some((floor, (low, high))) => {
            println!("  noise floor {} (95 %: {} … {})", number(floor), number(low), number(high));
        }
        None => println!("  noise floor: not known, too little data"),
    }
    for caution in &axis.floor_cautions {
        println!("  caution: {caution}");
    }
    println!("  where it fails worst, coasting for at most 60 s:");
    for (index, stretch) in axis.worst.iter().enumerate() {
        println!(
            "  {}. {:.1} s – {:.1} s: rms {} {}, {:.1} times the usual, mean {}",
            index + 1,
            stretch.begin_s,
            stretch.end_s,
            number(stretch.rms),
            axis.unit,
            stretch.ratio,
            number(stretch.mean)
        );
        for special in &stretch.special {
            println!("     {special}");
        }
        if stretch.special.is_empty() {
            println!("     nothing logged is special there");
        }
    }
}
