//! Each export, read by the consumer's own formula, corrects as the calibration does.

use fos_calibrate::export::{ArduPilot, ImuTk, Kalibr, NotForAutopilot, Px4};
use fos_calibrate::{Calibration, Options, Scale, calibrate};
use nalgebra::{Matrix3, Vector3};

use crate::device::{Device, Handling, orientations, rng};

fn calibration() -> (Calibration, fos_calibrate::Imu) {
    let mut rng = rng(7);
    let mut device = Device::random(&mut rng);
    device.by_g = Matrix3::from_fn(|i, j| 2e-4 * ((2 * i + j) as f64 - 3.0));
    let log = device.log(&orientations(20, &mut rng), &Handling::default(), &mut rng);
    (calibrate(&log, &Options::default()).expect("a calibration"), log)
}

/// Numbers of a file after a name, as the consumer's parser finds them.
fn value(file: &str, name: &str) -> f64 {
    let line = file
        .lines()
        .filter(|line| !line.starts_with('#'))
        .find(|line| line.split(['\t', ' ']).any(|word| word == name))
        .expect(name);
    let mut words = line.split(['\t', ' ']).skip_while(|word| *word != name);
    words.nth(1).expect("a value").parse().expect("a number")
}

/// (raw − offset) ∘ scale, as PX4 and ArduPilot compute it, on the raw values of the sensor.
#[test]
fn autopilots_correct_but_for_the_cross_axis() {
    let (found, _) = calibration();
    let model = &found.accelerometer.model;
    let px4 = Px4::of(&found).expect("in range");
    let file = px4.file("log.csv", 1, [1_310_988, 2]);
    let ardupilot = ArduPilot::of(&found).expect("in range").file("log.csv", 1);
    assert_eq!(value(&file, "CAL_ACC1_ID"), 1_310_988.0);
    let raw = [1.0, -5.0, 8.0];
    let exact = model.corrected(raw, model.reference_c);
    for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
        let offset = value(&file, &format!("CAL_ACC1_{letter}OFF"));
        let scale = value(&file, &format!("CAL_ACC1_{letter}SCALE"));
        let corrected = (raw[axis] - offset) * scale;
        // what the file states as neglected, and rounding to single precision
        assert!((corrected - exact[axis]).abs() <= px4.0.neglected_mps2 + 1e-5, "{letter}");
        assert_eq!(offset, value(&ardupilot, &format!("INS_ACC2OFFS_{letter}")));
        assert_eq!(scale, value(&ardupilot, &format!("INS_ACC2SCAL_{letter}")));
        let bias = found.gyro.as_ref().expect("a gyro").bias[axis];
        assert!((value(&file, &format!("CAL_GYRO1_{letter}OFF")) - bias).abs() < 1e-9);
        assert!((value(&ardupilot, &format!("INS_GYR2OFFS_{letter}")) - bias).abs() < 1e-9);
    }
    assert!(file.contains("no cross-axis terms"), "{file}");
}

#[test]
fn autopilots_do_not_take_counts() {
    let (mut found, _) = calibration();
    found.accelerometer.scale = Scale::Counts;
    assert_eq!(Px4::of(&found), Err(NotForAutopilot::Counts));
    found.accelerometer.scale = Scale::Si;
    found.accelerometer.model.sensitivity[1] = 2.0;
    let error = ArduPilot::of(&found).expect_err("out of range").to_string();
    assert!(error.contains("scale of y") && error.contains("0.8 … 1.2"), "{error}");
}

/// The matrices of a YAML file, in their order.
fn matrices(file: &str) -> Vec<Matrix3<f64>> {
    let numbers = |line: &str| -> Vec<f64> {
        let inside = line.split(['[', ']']).nth(1).expect("brackets");
        inside.split(',').map(|number| number.trim().parse().expect("a number")).collect()
    };
    let rows: Vec<Vec<f64>> = file.lines().filter(|line| line.starts_with("  - [")).map(numbers).collect();
    rows.chunks(3).map(|rows| Matrix3::from_fn(|i, j| rows[i][j])).collect()
}

#[test]
fn kalibr_s_formula_gives_the_raw_values_back() {
    let (found, _) = calibration();
    let kalibr = Kalibr::of(&found);
    let file = kalibr.file("log.csv");
    let [m, gyro_m, a, c] = matrices(&file)[..] else { panic!("{file}") };
    let gyro = found.gyro.as_ref().expect("a gyro");
    let model = &found.accelerometer.model;
    for (force, rate) in [([1.0, -5.0, 8.0], [0.5, -1.0, 2.0]), ([9.8, 0.0, 0.1], [0.0, 3.0, -0.2])] {
        // the same motion in the frame of the certificate and in Kalibr's
        let (force, rate) = (Vector3::from(force), Vector3::from(rate));
        let (force_k, rate_k) = (kalibr.rotation * force, kalibr.rotation * rate);
        let raw = m * force_k + kalibr.accelerometer_bias;
        let expected = Vector3::from(model.measured(force.into(), model.reference_c));
        assert!((raw - expected).norm() < 1e-8, "{raw} {expected}");
        let raw = gyro_m * c * rate_k + a * c * force_k + Vector3::from(gyro.bias);
        let matrix = gyro.matrix.expect("a matrix");
        let by_g = Matrix3::from_fn(|i, j| gyro.g_sensitivity.expect("estimated")[i][j]);
        let corrected =
            Matrix3::from_fn(|i, j| matrix[i][j]) * (raw - Vector3::from(gyro.bias) - by_g * force);
        assert!(gyro.is_g_sensitive && (corrected - rate).norm() < 1e-8, "{corrected} {rate}");
    }
    assert!((c * c.transpose() - Matrix3::identity()).norm() < 1e-8, "C is a rotation");
    assert!(m[(0, 1)] == 0.0 && m[(0, 2)] == 0.0 && m[(1, 2)] == 0.0, "M is lower triangular");
}

#[test]
fn imu_tk_s_formula_corrects_as_the_calibration_does() {
    let (found, _) = calibration();
    let exported = ImuTk::of(&found);
    let model = &found.accelerometer.model;
    let raw = [1.0, -5.0, 8.0];
    let corrected = exported.rotation * Vector3::from(model.corrected(raw, model.reference_c));
    // as CalibratedTriad_::load reads it: nine numbers of T, nine of K, three of b
    let of_file = |text: String, raw: [f64; 3]| {
        let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        let t = Matrix3::from_row_slice(&numbers[..9]);
        let k = Matrix3::from_row_slice(&numbers[9..18]);
        assert!((0..3).all(|i| (t[(i, i)] - 1.0).abs() < 1e-12), "ones on the diagonal: {t}");
        t * k * (Vector3::from(raw) - Vector3::from_column_slice(&numbers[18..21]))
    };
    assert!((of_file(exported.accelerometer.file(), raw) - corrected).norm() < 1e-9);
    let gyro = found.gyro.as_ref().expect("a gyro");
    let rate = [0.3, -0.4, 1.2];
    let matrix = gyro.matrix.expect("a matrix");
    let direct = Matrix3::from_fn(|i, j| matrix[i][j]) * (Vector3::from(rate) - Vector3::from(gyro.bias));
    let file = exported.gyro.expect("a gyro").file();
    assert!((of_file(file, rate) - exported.rotation * direct).norm() < 1e-9);
}
