//! A gyro on a turntable: simulated, and the real one of a record player.

use fos_calibrate::{Axes, CalibrateError, Imu, Scale, calibrate_on_turntable};
use fos_data::recording::{ColumnMap, LoadOptions, Recording, load};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution as _, StandardNormal, UnitSphere};

use crate::device::{Device, rng};

/// Rests and plateaus at these rates about random axes, 3 s each, with 1 s of handling in between.
fn log(device: &Device, rates: &[f64], plateaus: usize, seed: u64) -> Imu {
    let mut rng = rng(seed);
    let mut values = [Vec::new(), Vec::new(), Vec::new()];
    let mut push = |rate: Vector3<f64>, shake: f64, rows: usize, rng: &mut rand_chacha::ChaCha8Rng| {
        for n in 0..rows {
            let hand = Vector3::new((n as f64 * 0.7).sin(), (n as f64 * 0.5).cos(), (n as f64 * 0.9).sin());
            let shown = device.gyro * (rate + hand * shake);
            for axis in 0..3 {
                let noise: f64 = StandardNormal.sample(rng);
                values[axis].push(shown[axis] + device.gyro_bias[axis] + 0.003 * noise);
            }
        }
    };
    push(Vector3::zeros(), 0.0, 500, &mut rng);
    for n in 0..plateaus {
        let axis: [f64; 3] = UnitSphere.sample(&mut rng);
        let speed = rates[n % rates.len()] * (1.0 + 1e-3 * ((n * n) as f64).sin());
        push(Vector3::zeros(), 1.5, 100, &mut rng);
        push(Vector3::from(axis) * speed, 0.0, 300, &mut rng);
    }
    push(Vector3::zeros(), 1.5, 100, &mut rng);
    push(Vector3::zeros(), 0.0, 300, &mut rng);
    let rows = values[0].len();
    Imu {
        period_s: 0.01,
        time_s: (0..rows).map(|row| row as f64 * 0.01).collect(),
        segments: std::iter::once(0..rows).collect(),
        accelerometer: None,
        gyro: Some(Axes { values, columns: ["gx", "gy", "gz"].map(str::to_owned), scale: Scale::Si }),
        temperature_c: None,
    }
}

#[test]
fn intervals_hold_the_sensitivities() {
    let (mut held, mut count) = (0, 0);
    for seed in 0..60 {
        let device = Device::random(&mut rng(seed));
        let found = calibrate_on_turntable(&log(&device, &[3.49066, 4.71239], 24, seed), &[3.49066, 4.71239])
            .expect("calibrated");
        assert_eq!(found.plateaus.len(), 24);
        for axis in 0..3 {
            let truth = device.gyro.row(axis).norm();
            held += usize::from(found.parameters[3 + axis].holds(truth, 0.0));
            count += 1;
        }
        assert!(found.rms[0] < found.rms[1]);
    }
    let share = held as f64 / count as f64;
    assert!((0.90..=0.99).contains(&share), "{share}");
}

#[test]
fn plateaus_without_redundancy_are_refused() {
    let device = Device::random(&mut rng(2));
    for plateaus in [4, 5] {
        let error = calibrate_on_turntable(&log(&device, &[3.49066], plateaus, 2), &[3.49066]);
        let error = error.expect_err("refused");
        assert!(matches!(error, CalibrateError::FewPlateaus { .. }), "{error}");
    }
    // noise limits the intervals even where the residuals are small
    let found = calibrate_on_turntable(&log(&device, &[3.49066], 12, 2), &[3.49066]).expect("calibrated");
    assert!(found.parameters.iter().all(|one| one.half_width > 1e-5), "{:?}", found.parameters);
}

/// A bias of a third of the rate: rests are not recognised by their size.
#[test]
fn estimates_large_bias_at_slow_rate() {
    let rate = 5_f64.to_radians();
    let bias = [0.0181, -0.0181, 0.0181];
    let device = Device { gyro_bias: bias, ..Device::random(&mut rng(3)) };
    let found = calibrate_on_turntable(&log(&device, &[rate], 24, 3), &[rate]).expect("calibrated");
    assert!(found.rests > 0 && found.plateaus.len() == 24, "{} {}", found.rests, found.plateaus.len());
    for (axis, bias) in bias.into_iter().enumerate() {
        assert!((found.model.bias[axis] - bias).abs() < 1e-3, "{:?}", found.model.bias);
        assert!(found.parameters[3 + axis].holds(device.gyro.row(axis).norm(), 1e-3));
    }
}

#[test]
fn rejects_unstated_rate() {
    let device = Device { gyro: Matrix3::identity(), ..Device::random(&mut rng(1)) };
    let log = log(&device, &[3.0], 12, 1);
    let error = calibrate_on_turntable(&log, &[6.0]).expect_err("refused");
    assert!(matches!(&error, CalibrateError::NoPlateau { found, .. } if !found.is_empty()), "{error}");
    assert!(
        calibrate_on_turntable(&log, &[f64::NAN]).is_err() && calibrate_on_turntable(&log, &[0.0]).is_err()
    );
}

/// The record player of data/rate_table. Its published corrections are x +1.36 ± 0.08, y −1.13 ± 0.07, z −0.12 ± 0.07 %.
#[test]
fn real_record_player_gives_published_corrections() {
    let Some(folder) = fos_testkit::outside::path("data/rate_table") else { return };
    let specs = ["gx_rads=column_1:rad/s", "gy_rads=column_2:rad/s", "gz_rads=column_3:rad/s"];
    let columns = ColumnMap::from_specs(specs).expect("a map");
    let options = LoadOptions { rate_hz: Some(100.0), columns, ..LoadOptions::default() };
    let logs = ["0RPMgyr.txt", "33RPMgyr.txt", "45RPMgyr.txt"]
        .map(|name| load(folder.join(name), &options).expect("a log"));
    let log = Recording::join(logs.into()).expect("one rate");
    let found =
        calibrate_on_turntable(&Imu::of(&log).expect("a gyro"), &[3.490_66, 4.712_39]).expect("calibrated");
    for (axis, correction, interval) in [(0, 1.36, 0.08), (1, -1.13, 0.07), (2, -0.12, 0.07)] {
        let one = &found.parameters[3 + axis];
        let ours = 100.0 * (1.0 / one.value - 1.0);
        println!(
            "{}: correction {ours:+.3} ± {:.3} %, published {correction} ± {interval} %",
            one.label,
            100.0 * one.half_width
        );
        assert!((ours - correction).abs() <= interval + 100.0 * one.half_width, "{axis}: {ours}");
    }
    let [after, before] = found.rms.map(|rms| 100.0 * rms.expect("in rad/s"));
    println!("RMS {before:.2} → {after:.2} % over {} plateaus, {} rests", found.plateaus.len(), found.rests);
    assert!(found.plateaus.len() >= 50 && before < 0.8 && after < 0.21);
}
