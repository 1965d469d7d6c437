//! Results that do not depend on how axes are named or in which order rests are recorded.

use fos_calibrate::{Calibration, Imu, Options, calibrate};
use proptest::prelude::{ProptestConfig, any, proptest};

use crate::device::{Device, Handling, orientations, rng};

fn log(seed: u64) -> Imu {
    let mut rng = rng(seed);
    let handling = Handling { scatter: [0.002, 1e-4], ..Handling::default() };
    Device::random(&mut rng).log(&orientations(16, &mut rng), &handling, &mut rng)
}

fn found(imu: &Imu) -> Calibration {
    calibrate(imu, &Options::default()).expect("a calibration")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, failure_persistence: None, ..ProptestConfig::default() })]

    /// Renaming x, y, z to y, z, x renames the result.
    #[test]
    fn renamed_axes_rename_the_result(seed in 0_u64..1000) {
        let mut imu = log(seed);
        let before = found(&imu);
        for axes in [&mut imu.accelerometer, &mut imu.gyro] {
            axes.as_mut().expect("there").values.rotate_left(1);
        }
        let after = found(&imu);
        let (one, other) = (&before.accelerometer, &after.accelerometer);
        for axis in 0..3 {
            let from = (axis + 1) % 3;
            for kind in [0, 3] {
                let (one, other) = (&one.parameters[kind + from], &other.parameters[kind + axis]);
                assert!((one.value - other.value).abs() < 1e-3 * one.half_width, "{one:?} {other:?}");
                assert!((one.half_width / other.half_width - 1.0).abs() < 1e-3);
            }
        }
        // the angle xy was yz
        let (one, other) = (&one.parameters[8], &other.parameters[6]);
        assert!((one.value - other.value).abs() < 1e-3 * one.half_width, "{one:?} {other:?}");
        let matrix = |found: &Calibration| found.gyro.as_ref().and_then(|gyro| gyro.matrix).expect("a matrix");
        let (one, other) = (matrix(&before), matrix(&after));
        for i in 0..3 {
            for j in 0..3 {
                assert!((one[(i + 1) % 3][(j + 1) % 3] - other[i][j]).abs() < 1e-6);
            }
        }
    }

    /// Turning x and y around, as with the device upside down, changes the signs of their biases and of the angles with z only.
    #[test]
    fn rotated_sensor_gives_rotated_result(seed in 0_u64..1000, _x in any::<bool>()) {
        let mut imu = log(seed);
        let before = found(&imu);
        for axes in [&mut imu.accelerometer, &mut imu.gyro] {
            for axis in 0..2 {
                axes.as_mut().expect("there").values[axis].iter_mut().for_each(|value| *value = -*value);
            }
        }
        let after = found(&imu);
        for (index, sign) in [-1.0, -1.0, 1.0, 1.0, 1.0, 1.0].into_iter().enumerate() {
            let (one, other) = (&before.accelerometer.parameters[index], &after.accelerometer.parameters[index]);
            assert!((sign * one.value - other.value).abs() < 1e-3 * one.half_width, "{one:?} {other:?}");
        }
        for (index, sign) in [(6, 1.0), (7, -1.0), (8, -1.0)] {
            let (one, other) = (&before.accelerometer.parameters[index], &after.accelerometer.parameters[index]);
            assert!((90.0 + sign * (one.value - 90.0) - other.value).abs() < 1e-3 * one.half_width);
        }
    }
}

/// A gyro whose axes are named otherwise has the same cross-axis angles, under the other names.
#[test]
fn permuted_gyro_axes_keep_their_cross_axis_angles() {
    let imu = log(11);
    let angles = |imu: &Imu| {
        let gyro = found(imu).gyro.expect("a gyro");
        let of = |id: String| gyro.parameters.iter().chain(&gyro.derived).find(|one| one.id == id).cloned();
        let cross = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let id = format!("gyro.cross.{}{}", ["x", "y", "z"][i], ["x", "y", "z"][j]);
                of(id).map_or(0.0, |one| one.value)
            })
        });
        let to =
            ["x", "y", "z"].map(|axis| of(format!("gyro.to_accelerometer.{axis}")).expect("there").value);
        (cross, to)
    };
    let (cross, to) = angles(&imu);
    // from[i]: the axis that is logged as i now, and its sign: two three-cycles and a rotation by 90° about z
    for (from, sign) in [([1, 2, 0], [1.0; 3]), ([2, 0, 1], [1.0; 3]), ([1, 0, 2], [1.0, -1.0, 1.0])] {
        let mut other = imu.clone();
        let (before, after) = (imu.gyro.as_ref().expect("there"), other.gyro.as_mut().expect("there"));
        for i in 0..3 {
            after.values[i] = before.values[from[i]].iter().map(|value| sign[i] * value).collect();
        }
        let (permuted, to_permuted) = angles(&other);
        for i in 0..3 {
            assert!((to_permuted[i] - to[from[i]]).abs() < 1e-3, "{from:?} {to:?} {to_permuted:?}");
            for j in 0..3 {
                let expected = sign[i] * sign[j] * cross[from[i]][from[j]];
                assert!((permuted[i][j] - expected).abs() < 1e-3, "{from:?}: {cross:?} {permuted:?}");
            }
        }
    }
}

/// A dwell in the suggested orientation narrows the widest interval about as far as predicted.
#[test]
fn suggested_dwell_narrows_intervals_as_predicted() {
    let (mut ratios, mut shrinks) = (Vec::new(), 0);
    for seed in 0..24 {
        let mut generator = rng(seed);
        let handling = Handling { noise: [0.01, 0.003], ..Handling::default() };
        let device = Device::random(&mut generator);
        let mut ups = orientations(13, &mut generator);
        let log = |ups: &[[f64; 3]]| Imu { gyro: None, ..device.log(ups, &handling, &mut rng(seed + 100)) };
        let before = found(&log(&ups)).accelerometer;
        ups.push(before.next.orientation.up);
        let after = found(&log(&ups)).accelerometer;
        // the scatter is estimated again from few rests: compare in units of it
        let unit = |found: &fos_calibrate::Accelerometer| {
            (found.scatter_mps2.powi(2) + found.noise_mps2.powi(2)).sqrt()
        };
        let measured = after.worst_mps2 / unit(&after) / (before.worst_mps2 / unit(&before));
        let predicted = before.next.worst_mps2[1] / before.next.worst_mps2[0];
        assert!(predicted < 1.0, "{predicted}");
        shrinks += usize::from(measured < 1.0);
        ratios.push(measured / predicted);
    }
    ratios.sort_by(f64::total_cmp);
    assert!(shrinks >= 20 && (0.8..1.25).contains(&ratios[12]), "{shrinks} {ratios:?}");
}

/// The plan reaches the requested accuracy, or states that it cannot.
#[test]
fn plan_reaches_requested_accuracy() {
    let imu = Imu { gyro: None, ..log(4) };
    let with = |accuracy: f64| {
        let options = Options { accuracy_mps2: Some(accuracy), ..Options::default() };
        calibrate(&imu, &options).expect("a calibration").accelerometer
    };
    let worst = with(1.0).worst_mps2;
    assert_eq!(with(2.0 * worst).accuracy, Some((2.0 * worst, true)));
    let some = with(0.8 * worst);
    assert!(some.accuracy == Some((0.8 * worst, false)) && some.plan.is_some_and(|plan| !plan.is_empty()));
    assert_eq!(with(1e-3 * worst).plan, None);
}
