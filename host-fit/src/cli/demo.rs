//! `demo`: the whole path on a log that the program simulates itself.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use fos_core::Image;

use super::output::{Failure, number, progress, table};
use crate::compare::{Comparison, MODEL, study_of};
use crate::evaluate::ModelErrors;
use crate::export::{image, rust_source};
use crate::file::write_atomically;
use crate::fit::{FitOptions, InputSpec, fit_axis, training_rows};
use crate::model::unit_of;
use crate::plots;
use crate::recording::{LoadOptions, Recording, load, write_columns};
use crate::replay::{Replay, replay};
use crate::rest;
use crate::signal;
use crate::simulate::{SimulatedLog, Simulation, simulate};

/// Simulate a log, fit six axes, compare, export, replay on fos-core, and tell the story in numbers
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit demo --folder fos-demo")]
pub(super) struct Demo {
    /// Folder for everything that is written; made if it is not there
    #[arg(long, default_value = "fos-demo")]
    folder: PathBuf,
    /// Seed of the simulated unit
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Demo {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let began = Instant::now();
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| format!("{}: cannot make the folder: {error}", self.folder.display()))?;
        let path = |name: &str| self.folder.join(name);

        let simulated = simulate(&Simulation { seed: self.seed, ..Simulation::default() });
        let columns: Vec<(&str, &[f64])> =
            simulated.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        write_columns(path("log.parquet"), &columns)?;
        let recording = load(path("log.parquet"), &LoadOptions::default())?;
        let rest = rest::find(&recording);
        println!(
            "1. A log: {} rows of six axes and temperature at {:.2} Hz, a simulated phone-class unit.",
            recording.n_rows(),
            recording.rate.true_hz
        );
        println!("   It lies still for two thirds, then a hand turns it for 30 s out of every 90 s.");

        let physical: InputSpec = "temp_c".parse()?;
        let options = FitOptions { physical: vec![physical], ..FitOptions::default() };
        let axes = ["ax", "ay", "az", "gx", "gy", "gz"];
        let bar = progress(axes.len() as u64 + 4, "fitting");
        let mut fits = Vec::new();
        for axis in axes {
            fits.push(fit_axis(&recording, &rest, axis, &options)?);
            bar.inc(1);
        }
        let trained = training_rows(&recording, &rest, options.train).end;
        let (study, comparison, trace) =
            study_of(&recording, &rest, fits, options, Vec::new(), |_| bar.inc(1))?;
        bar.finish_and_clear();
        study.write(&path("study.json"))?;
        println!(
            "2. Fast Orthogonal Search over {} candidates an axis chose {} terms for six axes from the first {:.0} s.",
            study.axes[0].candidates,
            study.model.n_terms(),
            recording.time_s[trained - 1]
        );

        plots::write_all(&path("figures"), &comparison, &trace, &recording)?;
        println!(
            "3. On the rest, which was not fitted. Root mean square of what is left, coasting on its own history:"
        );
        print_coasts(&comparison);

        let bytes = image(&study.model, "simulated phone-class unit", &study.provenance())?;
        write_atomically(&path("unit.fosm"), &bytes)?;
        write_atomically(&path("model.rs"), rust_source(&study.model, &study.provenance()).as_bytes())?;
        let stored = Image::parse(&bytes)?;
        let replayed = replay(&stored, &recording, &rest, &[])?;
        write_columns(path("corrected.parquet"), &replayed.columns(&recording))?;
        println!(
            "4. The model is an image of {} bytes. fos-core ran it over the log in f32, as on the device; f32 changes no\n   \
             innovation by more than {:.1e} of their rms. Digest of all of them: {:016x}.",
            bytes.len(),
            replayed
                .summary
                .axes
                .iter()
                .map(|axis| axis.largest_difference / axis.innovation_rms_f64)
                .fold(0.0, f64::max),
            replayed.summary.innovations_digest
        );
        println!(
            "5. In motion, against the simulated truth: rms of the 1-s means of the error, bias at rest taken off:"
        );
        print_motion(&recording, &simulated, &rest.still, trained, &replayed);
        println!(
            "Written to {}: log.parquet, study.json, figures, unit.fosm, model.rs, corrected.parquet ({:.1} s).",
            self.folder.display(),
            began.elapsed().as_secs_f64()
        );
        Ok(())
    }
}

fn print_coasts(comparison: &Comparison) {
    let mut rows = table(&["   axis", "", "one-step", "10 s", "mean", "held", "60 s", "mean", "held"]);
    for axis in &comparison.axes {
        let named = |name: &str| axis.errors.iter().find(|errors| errors.model == name);
        let coast = |name: &str, horizon_s: f64| {
            let found = named(name)?.coast.iter().find(|coast| coast.horizon_s == horizon_s)?;
            Some(found.mse.sqrt())
        };
        let cell = |name: &str, horizon_s: f64| coast(name, horizon_s).map_or("–".into(), number);
        let one_step = named(MODEL).map_or(f64::NAN, |errors: &ModelErrors| errors.one_step_mse.sqrt());
        rows.add_row(vec![
            format!("   {}", axis.column),
            axis.unit.clone(),
            number(one_step),
            cell(MODEL, 10.0),
            cell("constant mean", 10.0),
            cell("last value held", 10.0),
            cell(MODEL, 60.0),
            cell("constant mean", 60.0),
            cell("last value held", 60.0),
        ]);
    }
    println!("{rows}");
}

fn print_motion(
    recording: &Recording,
    simulated: &SimulatedLog,
    still: &[bool],
    trained: usize,
    replayed: &Replay,
) {
    let mut rows = table(&["   axis", "", "before", "after", "left"]);
    for (axis, (name, truth)) in replayed.summary.axes.iter().zip(&simulated.truth) {
        debug_assert!(name.ends_with(&axis.column));
        let Ok(channel) = recording.channel(&axis.column) else { continue };
        let index = replayed.summary.axes.iter().position(|other| other.column == axis.column).unwrap_or(0);
        let before = moving_rms(&channel.values, truth, still, trained, recording.rate.true_hz);
        let after = moving_rms(&replayed.corrected[index], truth, still, trained, recording.rate.true_hz);
        rows.add_row(vec![
            format!("   {}", axis.column),
            unit_of(&axis.column).to_owned(),
            number(before),
            number(after),
            format!("{:.0} %", 100.0 * after / before),
        ]);
    }
    println!("{rows}");
}

/// Root mean square of the 1-s means of `values` − `truth` in motion, its mean over the training part taken off: that
/// much anyone can do by averaging at rest.
fn moving_rms(values: &[f64], truth: &[f64], still: &[bool], trained: usize, rate_hz: f64) -> f64 {
    let errors: Vec<f64> = values.iter().zip(truth).map(|(value, truth)| value - truth).collect();
    let at_rest: Vec<f64> =
        errors[..trained].iter().zip(still).filter(|(_, still)| **still).map(|(e, _)| *e).collect();
    let bias = signal::mean(&[&at_rest]);
    let block = rate_hz as usize;
    let moving = (trained..errors.len()).step_by(block).filter(|start| {
        still.get(*start..*start + block).is_some_and(|stretch| stretch.iter().all(|still| !still))
    });
    let means: Vec<f64> = moving.map(|start| signal::mean(&[&errors[start..start + block]]) - bias).collect();
    (means.iter().map(|mean| mean * mean).sum::<f64>() / means.len().max(1) as f64).sqrt()
}
