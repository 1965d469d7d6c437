//! `demo`: all steps on simulated logs: a hidden effect is found, added and exported.

use std::time::Instant;

use clap::Args;
use fos_core::Image;
use serde_json::json;

use super::arguments::OutputFolder;
use super::output::{Failure, print_json, progress, say};
use super::refinement::print_refinement;
use super::units::{Printed, Units, three};
use fos_data::file::compare_and_swap::FileVersion;
use fos_data::file::{make_folder, write_atomically};
use fos_data::recording::{LoadOptions, Recording, write_columns};
use fos_data::stillness;
use fos_device_io::replay::replay;
use fos_diagnose::compare::{compare, study_of};
use fos_diagnose::dependence::Trained;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::Logs;
use fos_export::{image, rust_source};
use fos_figures::curves::curves;
use fos_figures::moved;
use fos_figures::plots;
use fos_fit::fit::{FitOptions, fit_axes, rest};
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;
use fos_report::unaided::UnaidedRow;
use fos_simulate::{HIDDEN_IN as AXIS, hidden_effects};

/// See all steps on simulated data: fit, diagnose, add, export
#[derive(Debug, Args)]
#[command(after_help = "Example: fos demo --folder fos-demo")]
pub(super) struct Demo {
    /// Folder for all files; created if missing
    #[arg(long, default_value = "fos-demo")]
    folder: OutputFolder,
    /// Seed of the simulated device
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

impl Demo {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let began = Instant::now();
        make_folder(&self.folder)?;
        let path = |name: &str| self.folder.join(name);
        let file = FileVersion::now(&path("study.json"))?;

        let [reference, field, later] = hidden_effects(&self.folder, self.seed)?;
        say!(
            self,
            "1. Three logs of a simulated phone on a desk: a reference log of {:.0} min, a log of {:.0} min in which the processor works\n   \
             and the phone warms up, and a later evaluation log of {:.0} min. Two effects are hidden in gyro x.",
            minutes(&reference),
            minutes(&field),
            minutes(&later)
        );

        let options = FitOptions::default();
        let reference_stillness = rest(&reference, options.train);
        let axes = ["ax", "ay", "az", "gx", "gy", "gz"];
        let bar = progress(axes.len() as u64 + 4, "fitting");
        let fits = fit_axes(&reference, &reference_stillness, &axes, &options, &|| bar.inc(1));
        let fits = fits.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut study =
            study_of(&reference, &reference_stillness, fits, options, LoadOptions::default(), &mut |_| {
                bar.inc(1)
            })?;
        bar.finish_and_clear();
        say!(
            self,
            "2. On the reference log Fast Orthogonal Search over {} candidates an axis chose {} terms for six axes.",
            study.axes[0].candidates,
            study.model.n_terms()
        );

        let alone = study.axis_alone(AXIS)?;
        let field_stillness = stillness::find(&field);
        let lag_1 = study.axes.iter().find(|report| report.column == AXIS).map_or(0.0, |report| report.lag_1);
        let trained = Trained {
            recording: &reference,
            stillness: &reference_stillness,
            rows: 0..study.data.trained_rows,
        };
        let (comparison, trace) = compare(
            &alone,
            &[lag_1],
            &field,
            &field_stillness,
            0..field.n_rows(),
            Some(&trained),
            &mut |_| {},
        )?;
        let drawn = curves(&comparison, &trace, &field);
        plots::write_all(&path("figures"), &comparison, &drawn, &moved(&field, &field_stillness))?;
        let failing = &comparison.axes[0];
        let (before, reference_error) = (failing.errors.last(), study.steps.last());
        let slow = |errors: Option<&fos_fit::evaluate::ModelErrors>| {
            errors.and_then(|errors| errors.slow_error_coast).map_or(f64::NAN, f64::sqrt)
        };
        let in_reference = reference_error
            .and_then(|step| step.errors.iter().zip(&study.axes).find(|(_, r)| r.column == AXIS));
        say!(
            self,
            "3. On the log to explain the model fails: in a free run its slow error is {} °/s RMS; on the reference log it is {} °/s.",
            three(slow(before).to_degrees()),
            three(slow(in_reference.map(|(errors, _)| errors)).to_degrees())
        );
        if let Some(worst) = failing.worst.first() {
            say!(
                self,
                "   Worst from {:.0} s to {:.0} s, {:.1} times the median stretch.{}",
                worst.begin_s,
                worst.end_s,
                worst.ratio,
                match failing.dependence.as_ref().and_then(|dependence| dependence.channels.first()) {
                    Some(channel) => format!(
                        " The residual depends most on {} (p {:.0e}).",
                        channel.channel, channel.p_of_all
                    ),
                    None => String::new(),
                }
            );
        }

        let library = Library::built_in();
        let logs = Logs {
            log: field,
            reference: Some(reference),
            evaluation: Some(later),
            read: LoadOptions::default(),
        };
        let refiner = logs.refiner(&library);
        let mut refinement = refiner.begin(&study, AXIS, logs.named(refiner.fitted_rows()))?;
        say!(self, "4. Diagnose, add the effect found, and repeat until nothing is missing:");
        let mut found = Vec::new();
        let steps = refiner.add_best(&refinement, &mut |diagnosis, _| {
            say!(self, "   - {}", diagnosis.sentence);
            found.extend(diagnosis.findings.first().cloned());
        })?;
        refinement.steps.extend(steps);
        study.keep(refinement.clone());
        study.write(&file)?;
        plots::write_staircase(&path("figures"), &refinement)?;
        say!(self, "5. The error after every step, on the evaluation log, which nothing was fitted to:\n");
        if !self.json {
            print_refinement(&refinement, Printed::default());
        }

        let later = logs.evaluation.as_ref().unwrap_or(&logs.log);
        let refined = refinement.last().map_or(&alone, |last| &last.model);
        let later_rest = stillness::find(later);
        let (on_later, _) =
            compare(refined, &[lag_1], later, &later_rest, 0..later.n_rows(), None, &mut |_| {})?;
        say!(self, "");
        for row in UnaidedRow::all(&on_later.axes[0], Units::default()) {
            say!(self, "   {}", row.sentence());
        }

        let bytes = image(&study.model, "simulated phone-class unit", &study.provenance())?;
        write_atomically(&path("unit.fosm"), &bytes)?;
        write_atomically(&path("model.rs"), rust_source(&study.model, &study.provenance()).as_bytes())?;
        let replayed = replay(&Image::parse(&bytes)?, later, &later_rest, &[])?;
        write_columns(path("corrected.parquet"), &replayed.columns(later))?;
        let place = replayed.summary.axes.iter().position(|axis| axis.column == AXIS);
        let off = place.map_or(f64::NAN, |place| {
            largest_difference(&study.model, later, &later_rest.still, place, &replayed.corrected[place])
                .unwrap_or(f64::NAN)
        });
        say!(
            self,
            "\n6. The refined model is an image of {} bytes. fos-core ran it over the evaluation log in f32, as on the device: no corrected\n   \
             value of gyro x differs by more than {} °/h from what the host computes in f64. Digest of all corrections: {:016x}.",
            bytes.len(),
            three(3600.0 * off.to_degrees()),
            replayed.summary.corrections_digest
        );
        say!(
            self,
            "Written to {}: reference.parquet, log.parquet, evaluation.parquet, study.json, figures, unit.fosm, model.rs, corrected.parquet\n({:.1} s). \
             Next: docs/finding-a-missing-effect.md does the same step by step.",
            self.folder.display(),
            began.elapsed().as_secs_f64()
        );
        if self.json {
            return print_json(&json!({
                "folder": self.folder.display().to_string(),
                "comparison": comparison,
                "evaluation": on_later,
                "findings": found,
                "refinement": refinement,
                "replay": replayed.summary,
                "largest_difference_f32": off,
            }));
        }
        Ok(())
    }
}

fn minutes(log: &Recording) -> f64 {
    (log.time_s[log.n_rows() - 1] - log.time_s[0]) / 60.0
}

/// Largest difference between `corrected` and the model in f64, in the axis' unit.
fn largest_difference(
    model: &UnitModel,
    log: &Recording,
    still: &[bool],
    axis: usize,
    corrected: &[f64],
) -> Result<f64, Failure> {
    let playback = Playback::new(log, model, still)?;
    let mut predictor = model.predictor::<f64>()?;
    let mut feed = playback.feed();
    let differences = (0..log.n_rows()).map(|row| {
        let own = feed.step(&mut predictor, row)[axis].corrected;
        (own - corrected[row]).abs()
    });
    Ok(differences.fold(0.0, f64::max))
}
