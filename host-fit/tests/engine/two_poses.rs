//! Gravity has one true value per orientation. Two orientations at rest in one fit used to give a model that turned
//! |a| = 9.8 m/s² into 3, with every sample valid. Now each orientation has its own constant in a fit, ambiguous logs are
//! rejected, and a model made of two orientations as one is flagged wherever it runs.

use fos_data::column::AXES;
use fos_data::column::Column;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use fos_core::{Image, Validity};
use fos_data::pose::{columns_of, first_two};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness::{self, Stillness};
use fos_device_io::replay::{Gravity, replay};
use fos_embedded::hub::{Hub, Motion, Output};
use fos_embedded::raw::{RawSample, Scales};
use fos_fit::fit::{AxisError, AxisFit, FitOptions, Train, fit_axis, rest as rest_in};
use fos_fit::model::UnitModel;
use fos_simulate::{CasePlan, Durations, Setup, Simulation, simulate, simulate_case, suite};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const GRAVITY: f64 = 9.81;
const RATE_HZ: usize = 100;
const HELD_S: usize = 30;

type Columns = Vec<(String, Vec<f64>)>;

/// Rests of 30 s, tilted about y by these angles in turn, with a second of rotation between them.
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

fn rest_of(recording: &Recording, options: &FitOptions) -> Stillness {
    rest_in(recording, options.train)
}

/// A log, and its rows at rest for a fit.
fn of_poses(columns: Columns) -> (Recording, Stillness) {
    let recording = recording(columns);
    let rest = rest_of(&recording, &options());
    (recording, rest)
}

fn fitted(recording: &Recording, options: &FitOptions) -> UnitModel {
    let stillness = rest_of(recording, options);
    let fitted = |axis| fit_axis(recording, &stillness, axis, options).unwrap().model.into();
    UnitModel::joined(AXES.map(fitted)).unwrap()
}

/// Model of two orientations without the guard: the mean of both as a reference, which is the effect of a constant.
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

/// Gravity check of a replay, and the smallest share of valid rows of an accelerometer.
fn replayed(model: &UnitModel, recording: &Recording) -> (Gravity, f64) {
    let bytes = fos_export::image(model, "test", "test").unwrap();
    let summary =
        replay(&Image::parse(&bytes).unwrap(), recording, &stillness::find(recording), &[]).unwrap().summary;
    let valid = summary.axes[..3].iter().map(|axis| axis.valid_share).fold(1.0, f64::min);
    (summary.gravity.unwrap(), valid)
}

/// Last output of a hub in each rest.
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
    hub.load(&fos_export::image(model, "test", "test").unwrap()).unwrap();
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
fn each_orientation_has_a_constant_and_mixed_models_are_flagged() {
    let (mut refused, mut fits) = (0, 0);
    for degrees in [8.0_f64, 15.0, 40.0, 90.0, 180.0] {
        let tilts = [0.0, degrees.to_radians(), 0.0, degrees.to_radians()];
        let (two, rest) = of_poses(log(&tilts));
        for (place, axis) in AXES[..3].iter().enumerate() {
            let AxisFit { model, report } = fit_axis(&two, &rest, axis, &options()).unwrap();
            let turned: Vec<f64> = report.poses.iter().map(|pose| pose.force[0] / GRAVITY).collect();
            let off = turned.iter().zip(&tilts).map(|(turned, tilt)| (turned - tilt.sin()).abs());
            assert!(turned.len() == 3 && off.fold(0.0, f64::max) < 0.01, "{degrees}°, {axis}: {turned:?}");
            let upright = [0.0, 0.0, GRAVITY][place];
            assert!((model.axes[0].parameters.reference - upright).abs() < 0.01, "{degrees}°, {axis}");
            // as if it had not been turned: only the noise remains to be explained
            assert!((model.axes[0].parameters.scale / 0.02 - 1.0).abs() < 0.05, "{degrees}°, {axis}");
            fits += 1;
        }
        let (gravity, _) = replayed(&fitted(&two, &options()), &two);
        assert_eq!((gravity.rests, gravity.rests_away), (4, 0), "{degrees}°: {gravity:?}");
        if degrees == 180.0 {
            continue; // x alone does not show it
        }
        // the axis alone, without any evidence of motion
        let alone = recording(
            log(&tilts).into_iter().filter(|(name, _)| name == "t_s" || name == "ax_mps2").collect(),
        );
        let error = fit_axis(&alone, &rest_of(&alone, &options()), "ax", &options()).unwrap_err();
        let AxisError::TwoPoses { train_s, .. } = error else { panic!("{degrees}°: {error}") };
        assert!((HELD_S as u64 - 1..=HELD_S as u64).contains(&train_s), "{degrees}°: {train_s}");
        assert!(error.to_string().contains(&format!("`train` {train_s}s")), "{error}");
        // a shorter training range is the remedy
        let first = FitOptions { train: Train::Seconds(train_s as f64), ..options() };
        fit_axis(&alone, &rest_of(&alone, &first), "ax", &first).unwrap();
        refused += 1;
    }

    let columns = log(&[0.0, FRAC_PI_2, 0.0, FRAC_PI_2]);
    let (two, _) = of_poses(columns.clone());
    let bad = of_two_poses(&columns);
    let (gravity, valid) = replayed(&bad, &two);
    assert_eq!((gravity.rests, gravity.rests_away), (4, 4), "{gravity:?}");
    assert!(valid == 0.0, "{valid}");
    let outputs = on_a_hub(&bad, &columns);
    let turned_into = outputs.iter().map(|output| norm(output.accel())).fold(f32::INFINITY, f32::min);
    for output in &outputs {
        for validity in &output.validity()[..3] {
            // no other flag is set
            assert_eq!(*validity, Validity::AWAY_FROM_GRAVITY);
        }
        assert!(output.validity()[3..].iter().all(|validity| validity.is_valid()));
    }

    // a correct model: in the orientation of its fit, and in the other
    let sound = fitted(&two, &FitOptions { train: Train::Seconds(20.0), ..options() });
    let (gravity, _) = replayed(&sound, &two);
    assert_eq!(gravity.rests_away, 0, "{gravity:?}");
    for output in on_a_hub(&sound, &columns) {
        assert!(!output.validity().iter().any(|validity| validity.contains(Validity::AWAY_FROM_GRAVITY)));
    }

    let Simulated { held, rigs, effects } = simulated_logs();
    println!(
        "attack: two orientations | {fits} fits of accelerometers in two orientations, 8° to 180° apart, are in the frame of the first, and no rest deviates from gravity; {refused} fits of one axis alone, which cannot separate orientation from bias, are refused with a remedy; {held} simulated logs in one orientation, with {effects} kinds of accelerometer effects, are accepted | negative control: a model fitted to two orientations without this check turns |a| = 9.81 m/s² into {turned_into:.2}, which every other check accepts: {} of {} rests are flagged in the replay and by the hub; {rigs} of {rigs} turning rigs are detected",
        outputs.len(),
        outputs.len(),
    );
}

/// Numbers of the simulated logs examined.
struct Simulated {
    /// Logs in one orientation.
    held: usize,
    /// Logs of rigs that turn.
    rigs: usize,
    /// Kinds of effects on the accelerometers of the logs in one orientation.
    effects: usize,
}

/// Checks that no effect (temperature, warm-up, steps, shaking) changes the orientation of a log in one orientation.
fn simulated_logs() -> Simulated {
    let (mut held, mut rigs) = (0, 0);
    let mut look = |columns: Columns, turns: bool, what: &str| {
        let recording = recording(columns);
        let still = recording.still.clone().unwrap_or_else(|| vec![true; recording.n_rows()]);
        for axis in &AXES[..3] {
            let poses = first_two(&recording, &columns_of(&recording, axis), &still);
            assert_eq!(poses.len(), if turns { 2 } else { 1 }, "{what}, {axis}: {poses:?}");
            // the axis alone: the others give no evidence
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
    let durations = Durations { reference_s: 60.0, log_s: 300.0, evaluation_s: 60.0 };
    let mut effects = BTreeSet::new();
    let mut plans = suite(3, 30);
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
        look(case.reference, false, &what);
        if !skipped {
            look(case.log, turns, &what);
            effects.extend(planted.into_iter().filter(|_| !turns));
        }
    }
    Simulated { held, rigs, effects: effects.len() }
}

/// A bias that warms up while the device is turned repeatedly: the temperature coefficient is fitted within the
/// orientations.
#[test]
fn fits_temperature_within_orientations() {
    const PER_KELVIN: f64 = 0.02;
    let mut columns = log(&[0.0, 0.5, 0.0, 1.2, 0.7, 0.0]);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let n = columns[0].1.len();
    let temp_c: Vec<f64> = (0..n)
        .map(|row| {
            let noise: f64 = StandardNormal.sample(&mut random);
            25.0 + 10.0 * (1.0 - (-3.0 * row as f64 / n as f64).exp()) + 0.02 * noise
        })
        .collect();
    columns[1].1.iter_mut().zip(&temp_c).for_each(|(ax, temp_c)| *ax += PER_KELVIN * (temp_c - 25.0));
    columns.push(("temp_c".to_owned(), temp_c));
    let options =
        FitOptions { physical: vec!["temp_c".parse().unwrap()], train: Train::Share(1.0), ..options() };
    let recording = recording(columns);
    let model = fit_axis(&recording, &rest_of(&recording, &options), "ax", &options).unwrap().model;
    let (axis, input) = (&model.axes[0], &model.inputs[0].input);
    let per_kelvin = axis.physical[0].coefficient * axis.parameters.scale / input.scale;
    assert!((per_kelvin / PER_KELVIN - 1.0).abs() < 0.1, "{per_kelvin}");
}
