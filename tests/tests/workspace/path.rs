//! The whole path, from a recording to corrections, through public interfaces only.

use fos_core::{Image, u, y};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_device_io::hub_log::hub_log;
use fos_device_io::replay::replay;
use fos_diagnose::compare::study_of;
use fos_embedded::hub::Hub;
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord, PredictorDigest};
use fos_export::image;
use fos_fit::evaluate::MODEL;
use fos_fit::export::model_of;
use fos_fit::fit::{FitOptions, Stop, Train, fit_axis, training_rows};
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;
use fos_simulate::{Simulation, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const RATE_HZ: f64 = 200.0;

fn recording(columns: Vec<(String, Vec<f64>)>) -> Recording {
    let options = LoadOptions { rate_hz: Some(RATE_HZ), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("test"), columns, &options).expect("a sound recording")
}

/// r(n) = 1.2 r(n−1) − 0.5 r(n−2) + 0.015 r(n−1) r(n−2) + e(n), 60,000 samples, about 9.81 with 1e-3. It would diverge
/// from r = 20, ten standard deviations out.
fn quadratic_plant(seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut past = [0.0_f64; 2];
    (0..60_000)
        .map(|_| {
            let noise: f64 = StandardNormal.sample(&mut random);
            let now = 1.2 * past[0] - 0.5 * past[1] + 0.015 * past[0] * past[1] + noise;
            past = [now, past[0]];
            9.81 + 1e-3 * now
        })
        .collect()
}

#[test]
fn recovers_a_known_plant_for_any_offset_and_unit() {
    let recording = recording(vec![("az_mps2".into(), quadratic_plant(5))]);
    let stillness = stillness::find(&recording);
    // the plant's own units: offset and scale known, so that coefficients compare
    let options = FitOptions {
        offset: Some(9.81),
        scale: Some(1e-3),
        // all of it: r(n−2)² correlates with r(n−1) r(n−2) by 0.88, and half the rows sometimes give one for the other
        train: Train::Share(1.0),
        memory_s: vec![],
        max_lag: 5,
        ..FitOptions::default()
    };
    let fit = fit_axis(&recording, &stillness, "az", &options).expect("fits");
    let terms = &fit.model.axes[0].stochastic;
    let truth = [(vec![y(1)], 1.2), (vec![y(2)], -0.5), (vec![y(1), y(2)], 0.015)];
    assert_eq!(terms.len(), truth.len(), "{terms:?}");
    for (factors, coefficient) in truth {
        let found = terms
            .iter()
            .find(|term| term.factors == factors)
            .unwrap_or_else(|| panic!("{factors:?} is not among {terms:?}"));
        let error = found.standard_error.expect("estimated");
        // five standard errors: one in two million by chance
        assert!((found.coefficient - coefficient).abs() < 5.0 * error, "{factors:?}: {found:?}");
        assert!(error < 0.01, "{found:?}");
    }
}

/// r(n) = 0.5 r(n−1) + 0.4 u(n−2) − 0.3 r(n−1) u(n−1) + e(n), u a logged supply.
#[test]
fn lagged_inputs_and_their_products_with_the_output_are_found_and_run() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let supply: Vec<f64> = (0..40_000).map(|_| 3.3 + 0.1 * normal()).collect();
    let u_at = |n: usize| (supply[n] - 3.3) / 0.1;
    let mut r = vec![0.0; 2];
    for n in 2..supply.len() {
        r.push(0.5 * r[n - 1] + 0.4 * u_at(n - 2) - 0.3 * r[n - 1] * u_at(n - 1) + 0.5 * normal());
    }
    let recording = recording(vec![
        ("gx_rads".into(), r.iter().map(|r| 1e-3 * r).collect()),
        ("supply_v".into(), supply.clone()),
    ]);
    let stillness = stillness::find(&recording);
    let options = FitOptions {
        max_lag: 3,
        inputs: vec!["supply_v".parse().expect("an input")],
        input_lags: 3,
        memory_s: vec![],
        offset: Some(0.0),
        scale: Some(1e-3),
        ..FitOptions::default()
    };
    let fit = fit_axis(&recording, &stillness, "gx", &options).expect("fits");
    let mut found: Vec<_> = fit.model.axes[0].stochastic.iter().map(|term| term.factors.clone()).collect();
    found.sort();
    // u is centred on its mean, not on 3.3 V: the product contributes slightly to r(n−1), which is selected anyway
    assert_eq!(found, [vec![y(1)], vec![y(1), u(0, 1)], vec![u(0, 2)]]);
    let bytes = image(&fit.model, "simulated", "test").expect("exported");
    let replayed = replay(&Image::parse(&bytes).expect("its own image"), &recording, &stillness, &[]);
    let summary = replayed.expect("replayed").summary;
    assert!((summary.axes[0].innovation_rms_f64 / 0.5e-3 - 1.0).abs() < 0.02, "{summary:?}");
}

#[test]
fn beats_the_constant_mean_only_on_predictable_axes() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let white: Vec<f64> = (0..60_000).map(|_| StandardNormal.sample(&mut random)).collect();
    let recording = recording(vec![("gx_rads".into(), white), ("gy_rads".into(), quadratic_plant(6))]);
    let stillness = stillness::find(&recording);
    let options = FitOptions::default();
    let fits = ["gx", "gy"].map(|axis| fit_axis(&recording, &stillness, axis, &options).expect("fits"));
    assert!(
        fits[0].model.axes[0].stochastic.is_empty(),
        "white noise has no terms: {:?}",
        fits[0].report.steps
    );
    let study = study_of(&recording, &stillness, fits.to_vec(), options, LoadOptions::default(), &mut |_| {})
        .expect("evaluated");
    assert_eq!(study.steps.len(), 4);
    let mse = |axis: usize, model: &str| {
        let step = study.steps.iter().find(|step| step.name == model);
        step.expect("it was evaluated").errors[axis].one_step_mse
    };
    assert!((mse(0, MODEL) / mse(0, "constant mean") - 1.0).abs() < 0.01);
    // innovation variance 1 of a process of variance 1/((1−φ₂²)…): four times less
    assert!(mse(1, MODEL) < 0.35 * mse(1, "constant mean"));
    assert!(mse(1, MODEL) < 0.8 * mse(1, "Gauss-Markov"));
    assert!((mse(1, MODEL) / 1e-6 - 1.0).abs() < 0.05, "the innovation variance is 1e-6: {}", mse(1, MODEL));
    assert!(!study.steps.iter().any(|step| step.errors[1].below_noise_floor));
}

/// A short log of a simulated device, and the image of a model of all its axes.
fn simulated_unit() -> (Recording, Vec<u8>) {
    let log = simulate(&Simulation { duration_s: 300.0, seed: 3, ..Simulation::default() });
    let recording = recording(log.columns);
    let stillness = stillness::find(&recording);
    let options = FitOptions {
        train: Train::Seconds(60.0),
        physical: vec!["temp_c".parse().expect("an input")],
        stop: Stop::Korenberg,
        max_terms: 6,
        ..FitOptions::default()
    };
    let fits = ["ax", "ay", "az", "gx", "gy", "gz"]
        .map(|axis| fit_axis(&recording, &stillness, axis, &options).expect("fits").model.into());
    let model = UnitModel::joined(fits).expect("six");
    let bytes = image(&model, "simulated", "test").expect("exported");
    (recording, bytes)
}

#[test]
fn small_predictor_gives_the_digests_of_the_replay() {
    let (recording, bytes) = simulated_unit();
    let stillness = stillness::find(&recording);
    let stored = Image::parse(&bytes).expect("its own image");
    let host = replay(&stored, &recording, &stillness, &[]).expect("replayed");
    assert_eq!(host.summary.rows, recording.n_rows());
    assert!(host.summary.tracked > 0 && host.summary.tracked < recording.n_rows());

    let mut predictor = stored.predictor::<f32, 6, 32, 64, 256>().expect("it has the room");
    let model = model_of(&stored, &[]).expect("named");
    let playback = Playback::new(&recording, &model, &stillness.still).expect("its columns");
    let (mut feed, mut digest) = (playback.feed(), PredictorDigest::default());
    (0..recording.n_rows()).for_each(|row| digest.update(feed.step(&mut predictor, row)));
    assert_eq!(digest.innovations(), host.summary.innovations_digest);
    assert_eq!(digest.corrections(), host.summary.corrections_digest);
}

#[test]
fn hub_log_gives_the_digest_that_it_states() {
    let (recording, bytes) = simulated_unit();
    let stillness = stillness::find(&recording);
    let log = hub_log(&bytes, &[], &recording, &stillness).expect("a log");
    let header = HubLogHeader::decode(&log.bytes).expect("a header");
    let (mut given, length) = (vec![0.0; header.n_given.into()], header.record_length());
    let mut through = |log: &[u8]| {
        let mut hub: Hub<16, 128, 256> = Hub::new(header.scales);
        hub.load(&bytes).expect("its own image");
        let (mut digest, mut outputs) = (HubDigest::default(), Vec::new());
        for record in log[HubLogHeader::LENGTH..].chunks_exact(length) {
            let output = HubLogRecord::decode(record, &mut given).expect("a record").step(&mut hub);
            digest.update(output);
            outputs.push((output.still, output.corrected()));
        }
        (digest.outputs(), outputs)
    };
    let (digest, outputs) = through(&log.bytes);
    assert_eq!(digest, log.outputs);

    // the codes are the sensor's own: where the hub's detector agrees with the known rest, the corrections are those of
    // the replay, in all but the rows whose history has others
    let stored = Image::parse(&bytes).expect("its own image");
    let host = replay(&stored, &recording, &stillness, &[]).expect("replayed");
    assert_eq!(outputs.len(), recording.n_rows());
    let agree: Vec<usize> =
        (0..outputs.len()).filter(|row| outputs[*row].0 == stillness.still[*row]).collect();
    assert!(10 * agree.len() > 9 * outputs.len(), "{} of {}", agree.len(), outputs.len());
    for (axis, summary) in host.summary.axes.iter().enumerate() {
        let is_same = |row: &&usize| {
            let difference = f64::from(outputs[**row].1[axis]) - host.corrected[axis][**row];
            difference.abs() < 1e-3 * summary.innovation_rms_f64
        };
        let same = agree.iter().filter(is_same).count();
        assert!(4 * same > 3 * agree.len(), "{}: {same} of {}", summary.column, agree.len());
    }
    // and the digest detects a change of one bit
    let mut changed = log.bytes.clone();
    changed[HubLogHeader::LENGTH + 16] ^= 1;
    assert_ne!(through(&changed).0, digest);
}

#[test]
fn rounding_to_f32_is_negligible() {
    let (recording, bytes) = simulated_unit();
    let stillness = stillness::find(&recording);
    let host =
        replay(&Image::parse(&bytes).expect("its own image"), &recording, &stillness, &[]).expect("replayed");
    for axis in &host.summary.axes {
        // 24 bits of a measured value of up to 9.8 m/s² are 1e-6: 5e-5 of a noise of 0.02 m/s²
        assert!(axis.largest_difference < 2e-4 * axis.innovation_rms_f64, "{axis:?}");
    }
}

#[test]
fn training_counts_time_of_the_log() {
    let (recording, _) = simulated_unit();
    let end = |train| training_rows(&recording, train).end;
    let is_still = stillness::find(&recording).still;
    let moves = is_still.iter().position(|still| !still).expect("it is moved");
    let seconds = recording.time_s[moves] - recording.time_s[0] + 10.0;
    let rows = end(Train::Seconds(seconds));
    assert!((recording.time_s[rows] - recording.time_s[0] - seconds).abs() < 0.01, "at rest or not");
    assert_eq!(
        (end(Train::Share(0.25)), end(Train::Seconds(1e9))),
        ((0.25 * recording.n_rows() as f64).round() as usize, recording.n_rows())
    );
}
