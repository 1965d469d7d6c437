//! Effects that a log does not determine are rejected, for any error.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{RefineError, Refiner};
use crate::detect::{Question, Verdict, estimate};
use crate::effects::{Detector, Effect, Library};
use crate::study::{LogSources, Refinement, RefinementStep};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_fit::fit::{FitOptions, fit_axis, rest};

const RATE_HZ: f64 = 10.0;

/// Standard deviation of the mean of the gyro over a log, rad/s.
const MEAN_DEVIATION: f64 = 2e-5;

/// Inputs of a log: column, constant, and standard deviation of the sensor's noise.
const INPUTS: [(&str, f64, f64); 8] = [
    ("ax_mps2", 0.1, 0.012),
    ("ay_mps2", 0.2, 0.012),
    ("az_mps2", 9.79, 0.012),
    ("temp_c", 27.0, 0.02),
    ("supply_v", 3.3, 1e-4),
    ("load_pct", 20.0, 0.1),
    ("mag_x_ut", 20.0, 0.3),
    ("mag_z_ut", -40.0, 0.3),
];

/// Ten minutes in which every input is constant except for sensor noise; the temperature rises by `slope` in K/s, and
/// the gyro follows it by `per_kelvin` in rad/s/K.
fn log(name: &str, seed: u64, slope: f64, per_kelvin: f64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise =
        |deviation: f64| -> f64 { deviation * Distribution::<f64>::sample(&StandardNormal, &mut random) };
    let rows = (600.0 * RATE_HZ) as usize;
    let time: Vec<f64> = (0..rows).map(|row| row as f64 / RATE_HZ).collect();
    let mut columns = vec![("t_s".to_owned(), time.clone())];
    let rise = |time_s: f64| slope * time_s;
    for (column, constant, deviation) in INPUTS {
        let is_warm = f64::from(u8::from(column == "temp_c"));
        let values =
            time.iter().map(|time_s| constant + is_warm * rise(*time_s) + noise(deviation)).collect();
        columns.push((column.to_owned(), values));
    }
    let gyro = time.iter().map(|time_s| 2e-4 + per_kelvin * rise(*time_s) + noise(1.5e-3)).collect();
    columns.push(("gx_rads".to_owned(), gyro));
    Recording::from_columns(Source::made_by(name), columns, &LoadOptions::default()).expect("a recording")
}

/// Axis before any effect is added.
fn begin(refiner: &Refiner<'_>, reference: &Recording) -> Refinement {
    let options = FitOptions { max_lag: 2, ..FitOptions::default() };
    let fit = fit_axis(reference, &rest(reference, options.train), "gx", &options).expect("a fit");
    let logs = LogSources {
        log: Source::made_by("log"),
        reference: Some(Source::made_by("reference")),
        evaluation: Some(Source::made_by("later")),
        fitted_rows: refiner.fitted_rows(),
        read: LoadOptions::default(),
    };
    let steps = vec![refiner.first_step(&fit.model).expect("a state")];
    Refinement { column: "gx_rads".to_owned(), logs, steps }
}

/// Slow effects of the library that follow a logged column, for a log without a reference.
fn input_effects(library: &Library) -> Vec<&Effect> {
    let effects = library.effects().iter().filter(|effect| effect.search == Detector::Terms);
    effects.filter(|effect| effect.strikes("gx_rads") && !effect.follows_clock_alone()).collect()
}

/// Number of effects that the earlier rule would add: all that can be estimated.
fn can_be_estimated(field: &Recording, library: &Library) -> usize {
    let question = Question::new(field, "gx", library);
    let estimated = |effect: &&Effect| estimate(&question, std::slice::from_ref(&effect.id)).is_ok();
    input_effects(library).into_iter().filter(estimated).count()
}

/// g-sensitivity was estimated from one orientation, and the bias of the gyro grew thirteenfold.
#[test]
fn constant_inputs_are_rejected_or_leave_bias_unchanged() {
    let (reference, field, later) =
        (log("reference", 1, 0.0, 0.0), log("field", 2, 0.0, 0.0), log("later", 3, 0.0, 0.0));
    let library = Library::built_in();
    let refiner = Refiner::new(&field, Some(&reference), Some(&later), &library);
    let refinement = begin(&refiner, &reference);
    let before = refinement.clone();
    let bias = |step: &RefinementStep| {
        let parameters = &step.model.axes[0].parameters;
        parameters.reference + parameters.offset
    };
    let mut refused = 0;
    for effect in input_effects(&library) {
        match refiner.add(&refinement, effect) {
            // an effect that is determined to be zero is harmless
            Ok(step) => {
                let moved = (bias(&step) - bias(&refinement.steps[0])).abs();
                assert!(moved < 5.0 * MEAN_DEVIATION, "{}: the bias moved by {moved} rad/s", effect.id);
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("\nhelp: ") || text.contains("has no"), "{}: {text}", effect.id);
                refused += 1;
            }
        }
    }
    assert!(refused >= 8, "{refused}");
    assert_eq!(refinement, before);
    // negative control: the possibility of an estimate alone rejects nothing
    let estimated = can_be_estimated(&field, &library);
    assert!(estimated >= 5, "the table would pass whatever is added");
    println!(
        "attack: undetermined effects | {} effects on a log whose inputs are constant: {refused} are refused with instructions for a recording, the others leave bias and study unchanged | negative control: an earlier rule, which adds whatever can be estimated, would add {estimated}",
        input_effects(&library).len(),
    );
}

#[test]
fn adds_determined_effect_and_reduces_error() {
    let coefficient = 2e-4;
    let logs = [(4, 0.0), (5, 0.02), (6, -0.015)];
    let [reference, field, later] =
        logs.map(|(seed, slope)| log(&format!("log {seed}"), seed, slope, coefficient));
    let library = Library::built_in();
    let refiner = Refiner::new(&field, Some(&reference), Some(&later), &library);
    let mut refinement = begin(&refiner, &reference);
    let step = refiner.add(&refinement, library.get("temp_linear").expect("known")).expect("added");
    let found = step.added.as_ref().expect("added").finding.correction[0].coefficient;
    assert!((found / coefficient - 1.0).abs() < 0.05, "{found}");
    refinement.steps.push(step);
    assert!(refinement.steps[1].left.slow < 0.5 * refinement.steps[0].left.slow);
}

/// The effect is absent from the evaluation log, so it would increase the error there.
#[test]
fn rejects_effect_that_increases_evaluation_error() {
    let (reference, field, later) =
        (log("reference", 7, 0.0, 0.0), log("field", 8, 0.02, 2e-4), log("later", 9, 0.04, 0.0));
    let library = Library::built_in();
    let refiner = Refiner::new(&field, Some(&reference), Some(&later), &library);
    let refused = refiner.add(&begin(&refiner, &reference), library.get("temp_linear").expect("known"));
    assert!(matches!(refused, Err(RefineError::MakesWorse { .. })), "{refused:?}");
}

/// A study of an earlier version may contain an effect that its log did not determine.
#[test]
fn undetermined_effect_prevents_all_clear() {
    let (reference, field) = (log("reference", 10, 0.0, 0.0), log("field", 11, 0.0, 0.0));
    let library = Library::built_in();
    let refiner = Refiner::new(&field, Some(&reference), Some(&field), &library);
    let mut refinement = begin(&refiner, &reference);
    assert_eq!(refiner.diagnose(&refinement).expect("a diagnosis").verdict, Verdict::NothingMissing);
    let question = Question::new(&field, "gx", &library);
    let finding = estimate(&question, &["g_sensitivity".to_owned()]).expect("estimated").remove(0);
    let effect = library.get("g_sensitivity").expect("known").clone();
    let mut step = refinement.steps[0].clone();
    step.added = Some(crate::study::Added { effect, finding, measured_reduction: 0.0 });
    refinement.steps.push(step);
    let answer = refiner.diagnose(&refinement).expect("a diagnosis");
    assert_eq!(answer.verdict, Verdict::NotEnoughData, "{}", answer.sentence);
}
