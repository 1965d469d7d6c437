//! Gravity is one true value in one pose only. Two rest poses in one fit gave a model that turned |a| = 9.8 m/s² into
//! 3, every sample of it marked valid: `fit` refuses them, and a model that was made of them all the same is flagged
//! wherever it runs.

use fos_data::column::AXES;
use fos_data::column::Column;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use fos_core::{Image, Validity};
use fos_data::pose::{columns_of, first_two};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_embedded::hub::{Hub, Motion, Output};
use fos_embedded::raw::{RawSample, Scales};
use fos_fit::fit::{AxisError, FitOptions, Train, fit_axis};
use fos_fit::model::UnitModel;
use fos_simulate::{CasePlan, Durations, Setup, Simulation, simulate, simulate_case, suite};
use host_fit::export;
use host_fit::replay::{Gravity, replay};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const GRAVITY: f64 = 9.81;
const RATE_HZ: usize = 100;
const HELD_S: usize = 30;

type Columns = Vec<(String, Vec<f64>)>;

/// Rests of 30 s, tilted about y by these angles in turn; a second of turning between.
fn log(tilts: &[f64]) -> Columns {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut columns: Columns =
        ["t_s"].iter().chain(&AXES).chain(&["still"]).map(|name| ((*name).to_owned(), Vec::new())).collect();
    let mut push = |tilt: f64, rate: f64, still: f64| {
        let truth = [GRAVITY * tilt.sin(), 0.0, GRAVITY * tilt.cos(), 0.003, rate, -0.002];
        let row = columns[0].1.len();
        columns[0].1.push(row as f64 / RATE_HZ as f64);
        for (axis, value) in truth.into_iter().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut random);
            columns[axis + 1].1.push(value + noise * if axis < 3 { 0.02 } else { 0.002 });
        }
        columns[7].1.push(still);
    };
    for (i, tilt) in tilts.iter().enumerate() {
        (0..HELD_S * RATE_HZ).for_each(|_| push(*tilt, 0.0, 1.0));
        if let Some(next) = tilts.get(i + 1) {
            let turned = |k: usize| (k as f64 + 0.5) / RATE_HZ as f64;
            (0..RATE_HZ).for_each(|k| push(tilt + turned(k) * (next - tilt), next - tilt, 0.0));
        }
    }
    columns
}

fn recording(columns: Columns) -> Recording {
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
}

fn options() -> FitOptions {
    FitOptions { max_lag: 3, degree: 1, memory_s: vec![], train: Train::Share(0.6), ..FitOptions::default() }
}

fn fitted(recording: &Recording, options: &FitOptions) -> UnitModel {
    let stillness = stillness::find(recording);
    let mut models =
        AXES.map(|axis| fit_axis(recording, &stillness, axis, options).unwrap().model).into_iter();
    let mut model = models.next().unwrap();
    models.for_each(|other| model.absorb(other));
    model
}

/// What comes of two poses without the guard: the mean of both as a reference, which is what a constant is.
fn of_two_poses(columns: &Columns) -> UnitModel {
    let mut with_mean = columns.clone();
    let mut means = [0.0; 3];
    for (axis, mean) in means.iter_mut().enumerate() {
        let (name, values) = &columns[axis + 1];
        let trained = &values[..values.len() / 2];
        *mean = trained.iter().sum::<f64>() / trained.len() as f64;
        with_mean.push((Column::named(name).reference(), vec![*mean; values.len()]));
    }
    let mut model = fitted(&recording(with_mean), &options());
    for (axis, mean) in model.axes.iter_mut().zip(means) {
        (axis.parameters.reference, axis.parameters.offset) = (mean + axis.parameters.offset, 0.0);
    }
    model
}

/// What a replay says of gravity, and the least share of valid rows of an accelerometer.
fn replayed(model: &UnitModel, recording: &Recording) -> (Gravity, f64) {
    let bytes = export::image(model, "test", "test").unwrap();
    let summary =
        replay(&Image::parse(&bytes).unwrap(), recording, &stillness::find(recording), &[]).unwrap().summary;
    let valid = summary.axes[..3].iter().map(|axis| axis.valid_share).fold(1.0, f64::min);
    (summary.gravity.unwrap(), valid)
}

/// The last output of a hub in each rest.
fn on_a_hub(model: &UnitModel, columns: &Columns) -> Vec<Output> {
    let scales = Scales {
        accel_mps2: 0.001,
        gyro_rads: 0.0003,
        temperature_k: 1.0,
        temperature_zero_c: 25.0,
        period_s: model.period_s,
        values: model.fitted_on,
    };
    let mut hub: Hub<4, 64, 64> = Hub::new(scales);
    hub.load(&export::image(model, "test", "test").unwrap()).unwrap();
    let still = &columns[7].1;
    let mut lasts = Vec::new();
    for row in 0..still.len() {
        let code = |axis: usize, scale: f64| (columns[axis + 1].1[row] / scale).round() as i16;
        let raw = RawSample {
            accel: [0, 1, 2].map(|axis| code(axis, 0.001)),
            gyro: [3, 4, 5].map(|axis| code(axis, 0.0003)),
            ..RawSample::default()
        };
        hub.set_motion(Some(if still[row] == 1.0 { Motion::Still } else { Motion::Moving }));
        let output = *hub.update(&raw);
        if still[row] == 1.0 && still.get(row + 1) != Some(&1.0) {
            lasts.push(output);
        }
    }
    lasts
}

fn norm(force: [f32; 3]) -> f32 {
    force.iter().map(|x| x * x).sum::<f32>().sqrt()
}

#[test]
fn two_poses_are_refused_and_what_was_made_of_them_is_flagged() {
    let mut refused = 0;
    for degrees in [8.0_f64, 15.0, 40.0, 90.0, 180.0] {
        let two = recording(log(&[0.0, degrees.to_radians(), 0.0, degrees.to_radians()]));
        let stillness = stillness::find(&two);
        for axis in &AXES[..3] {
            let error = fit_axis(&two, &stillness, axis, &options()).unwrap_err();
            let AxisError::TwoPoses { train_s, .. } = error else { panic!("{degrees}°, {axis}: {error}") };
            assert_eq!(train_s, HELD_S as u64, "{degrees}°, {axis}");
            assert!(error.to_string().contains("`train` 30s"), "{error}");
            // and that is a way out
            let first = FitOptions { train: Train::Seconds(train_s as f64), ..options() };
            fit_axis(&two, &stillness, axis, &first).unwrap();
            refused += 1;
        }
        fit_axis(&two, &stillness, "gx", &options()).unwrap();
    }

    let columns = log(&[0.0, FRAC_PI_2, 0.0, FRAC_PI_2]);
    let two = recording(columns.clone());
    let bad = of_two_poses(&columns);
    let (gravity, valid) = replayed(&bad, &two);
    assert_eq!((gravity.rests, gravity.rests_away), (4, 4), "{gravity:?}");
    assert!(valid == 0.0, "{valid}");
    let outputs = on_a_hub(&bad, &columns);
    let turned_into = outputs.iter().map(|output| norm(output.accel())).fold(f32::INFINITY, f32::min);
    for output in &outputs {
        for validity in &output.validity[..3] {
            // nothing else speaks against it
            assert_eq!(*validity, Validity::AWAY_FROM_GRAVITY);
        }
        assert!(output.validity[3..].iter().all(|validity| validity.is_valid()));
    }

    // a sound model: in the pose of its fit, and in the other
    let sound = fitted(&two, &FitOptions { train: Train::Seconds(20.0), ..options() });
    let (gravity, _) = replayed(&sound, &two);
    assert_eq!(gravity.rests_away, 0, "{gravity:?}");
    for output in on_a_hub(&sound, &columns) {
        assert!(!output.validity.iter().any(|validity| validity.contains(Validity::AWAY_FROM_GRAVITY)));
    }

    let Simulated { held, rigs, effects } = simulated_logs();
    println!(
        "attack: two poses | {refused} fits of accelerometers over two poses, 8° to 180° apart, refused by name with a way out that works; \
         {held} simulated logs in one pose, {effects} kinds of effects on their accelerometers among them, are not | negative control: the model that comes of two poses without \
         the guard turns |a| = 9.81 m/s² into {turned_into:.2} and all else calls it valid: {} of {} rests are flagged in the replay and by the hub; \
         {rigs} of {rigs} rigs that turn are told from one pose",
        outputs.len(),
        outputs.len(),
    );
}

/// Simulated logs that were looked at.
struct Simulated {
    /// In one pose.
    held: usize,
    /// Of rigs that turn.
    rigs: usize,
    /// Kinds of effects on the accelerometers of those in one pose.
    effects: usize,
}

/// Temperature, warm-up, steps, shaking and what else an effect does move no log in one pose into another.
fn simulated_logs() -> Simulated {
    let (mut held, mut rigs) = (0, 0);
    let mut look = |columns: Columns, turns: bool, what: &str| {
        let recording = recording(columns);
        let still = recording.still.clone().unwrap_or_else(|| vec![true; recording.n_rows()]);
        for axis in &AXES[..3] {
            let poses = first_two(&recording, &columns_of(&recording, axis), &still);
            assert_eq!(poses.len(), if turns { 2 } else { 1 }, "{what}, {axis}: {poses:?}");
            // the axis alone: what another shows does not tell
            let alone = first_two(&recording, &[axis], &still);
            assert!(turns || alone.len() == 1, "{what}, {axis} alone: {alone:?}");
        }
        if turns { rigs += 1 } else { held += 1 }
    };
    look(
        simulate(&Simulation { duration_s: 300.0, temperature: 5.0, ..Simulation::default() }).columns,
        false,
        "a hand",
    );
    let durations = Durations { baseline_s: 60.0, field_s: 600.0, eval_s: 60.0 };
    let mut effects = BTreeSet::new();
    let mut plans = suite(3, 60);
    plans.retain(|plan| !plan.target.is_gyro() || plan.setup == Setup::PoseRig);
    for (seed, setup) in (1..).zip(Setup::ALL) {
        plans.push(CasePlan::new(seed, "mpu6050", setup, fos_simulate::Axis::Ax));
    }
    for plan in plans {
        let what = format!("{plan:?}");
        let turns = plan.setup == Setup::PoseRig;
        // the table's log has a reference
        let skipped = plan.setup == Setup::RateTable;
        let planted: Vec<String> = plan.planted.iter().map(|plant| plant.effect.to_string()).collect();
        let Ok(case) = simulate_case(&CasePlan { durations, ..plan }) else { continue };
        look(case.baseline, false, &what);
        if !skipped {
            look(case.field, turns, &what);
            effects.extend(planted.into_iter().filter(|_| !turns));
        }
    }
    Simulated { held, rigs, effects: effects.len() }
}
