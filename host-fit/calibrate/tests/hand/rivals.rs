//! The same simulated logs by imu_tk's method and by ArduPilot's six-sample fit, both written here after their sources.

use std::fmt::Write as _;

use fos_calibrate::{Options, calibrate};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::device::{Device, G, Handling, orientations, rng};

/// Bias, sensitivity and cosines by a correction M(raw − b).
struct Estimate {
    bias: [f64; 3],
    sensitivity: [f64; 3],
    cosine: [f64; 3],
}

fn estimate(matrix: &Matrix3<f64>, bias: [f64; 3]) -> Estimate {
    let sensor = matrix.try_inverse().expect("regular");
    let row = |i: usize| sensor.row(i).transpose();
    let cosine = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| row(i).dot(&row(j)) / row(i).norm() / row(j).norm());
    Estimate { bias, sensitivity: [0, 1, 2].map(|i| row(i).norm()), cosine }
}

/// Gauss–Newton with a numerical Jacobian.
fn solve(start: &[f64], residuals: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut x = start.to_vec();
    for _ in 0..30 {
        let at = residuals(&x);
        let column = |index: usize| {
            let mut moved = x.clone();
            moved[index] += 1e-6;
            residuals(&moved).iter().zip(&at).map(|(b, a)| (b - a) / 1e-6).collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = (0..x.len()).map(column).collect();
        let jacobian = DMatrix::from_fn(at.len(), x.len(), |i, j| columns[j][i]);
        let step = jacobian.svd(true, true).solve(&DVector::from_vec(at), 1e-12).expect("solved");
        x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= step);
    }
    x
}

/// imu_tk: g² − |T·K·(x − b)|² over the means of the rests, all weights equal, T upper triangular
/// (src/calibration.cpp, `MultiPosAccResidual`).
fn imu_tk(means: &[[f64; 3]]) -> Estimate {
    let matrix = |p: &[f64]| {
        let t = Matrix3::new(1.0, -p[0], p[1], 0.0, 1.0, -p[2], 0.0, 0.0, 1.0);
        t * Matrix3::from_diagonal(&Vector3::new(p[3], p[4], p[5]))
    };
    let found = solve(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0], |p| {
        let corrected = |mean: &[f64; 3]| matrix(p) * (Vector3::from(*mean) - Vector3::new(p[6], p[7], p[8]));
        means.iter().map(|mean| G * G - corrected(mean).norm_squared()).collect()
    });
    estimate(&matrix(&found), [found[6], found[7], found[8]])
}

/// ArduPilot: g − |diag(k)·(x + o)| over six samples, one on each face (libraries/AP_AccelCal/AccelCalibrator.cpp,
/// `calc_residual`, axis-aligned ellipsoid); here iterated until it converges.
fn ardupilot(means: &[[f64; 3]]) -> Estimate {
    let found = solve(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0], |p| {
        let corrected = |mean: &[f64; 3]| {
            Vector3::new(p[0] * (mean[0] + p[3]), p[1] * (mean[1] + p[4]), p[2] * (mean[2] + p[5]))
        };
        means.iter().map(|mean| G - corrected(mean).norm()).collect()
    });
    estimate(
        &Matrix3::from_diagonal(&Vector3::new(found[0], found[1], found[2])),
        [-found[3], -found[4], -found[5]],
    )
}

/// Root mean square errors: bias in mg, sensitivity in %, angle in °; the worst 5 % of the biases.
#[derive(Default)]
struct Errors {
    squares: [f64; 3],
    count: f64,
    biases: Vec<f64>,
}

impl Errors {
    fn add(&mut self, device: &Device, estimate: &Estimate) {
        for axis in 0..3 {
            let bias = (estimate.bias[axis] - device.bias[axis]) / 9.806_65e-3;
            let sensitivity = 100.0 * (estimate.sensitivity[axis] / device.sensitivity[axis] - 1.0);
            let angle = (estimate.cosine[axis].acos() - device.cosine[axis].acos()).to_degrees();
            for (sum, error) in self.squares.iter_mut().zip([bias, sensitivity, angle]) {
                *sum += error * error;
            }
            self.biases.push(bias.abs());
        }
        self.count += 3.0;
    }

    fn row(mut self, name: &str, intervals: &str) -> (String, [f64; 3]) {
        let rms = self.squares.map(|sum| (sum / self.count).sqrt());
        self.biases.sort_by(f64::total_cmp);
        let worst = self.biases[self.biases.len() * 95 / 100];
        (
            format!(
                "| {name} | {:.2} | {worst:.2} | {:.3} | {:.3} | {intervals} |\n",
                rms[0], rms[1], rms[2]
            ),
            rms,
        )
    }
}

#[test]
fn table_beside_imu_tk_and_ardupilot() {
    let mut table = String::new();
    let mut all = Vec::new();
    for (title, rests, disturbed) in [
        ("12 rests of 3 s", 12, false),
        ("24 rests of 3 s", 24, false),
        ("24 rests, one of them disturbed by 30 mg", 24, true),
    ] {
        let [mut ours, mut tk, mut six] = [Errors::default(), Errors::default(), Errors::default()];
        let (mut held, mut count) = (0, 0);
        for seed in 0..80 {
            let mut rng = rng(20_000 + seed);
            let device = Device::random(&mut rng);
            let handling = Handling { noise: [0.02, 0.003], ..Handling::default() };
            let ups = orientations(rests, &mut rng);
            let mut log = device.log(&ups, &handling, &mut rng);
            // the rivals' gyro methods are not compared
            log.gyro = None;
            if disturbed {
                // Someone leans on the table during one rest.
                let rows = 250 * (seed as usize % rests)..250 * (seed as usize % rests) + 150;
                for axis in &mut log.accelerometer.as_mut().expect("there").values {
                    axis[rows.clone()].iter_mut().for_each(|value| *value += 0.3 / 3_f64.sqrt());
                }
            }
            let found = calibrate(&log, &Options::default()).expect("a calibration").accelerometer;
            let model = &found.model;
            ours.add(
                &device,
                &Estimate { bias: model.bias, sensitivity: model.sensitivity, cosine: model.cosine },
            );
            for (axis, one) in found.parameters.iter().take(3).enumerate() {
                held += usize::from(one.holds(device.bias[axis], 0.0));
                count += 1;
            }
            let means: Vec<[f64; 3]> = found.rests.iter().map(|one| one.rest.accelerometer).collect();
            assert_eq!(means.len(), rests, "{seed}");
            tk.add(&device, &imu_tk(&means));
            six.add(&device, &ardupilot(&means[..6]));
        }
        let share = format!("{:.0} %", 100.0 * held as f64 / count as f64);
        let _ = write!(
            table,
            "\n**{title}**\n\n| method | bias, mg RMS | 95 % below, mg | sensitivity, % RMS | angle, ° RMS | 95 % intervals that hold the bias |\n|---|---|---|---|---|---|\n"
        );
        for (errors, name, intervals) in [
            (ours, "fos", share.as_str()),
            (tk, "imu_tk's method", "none given"),
            (six, "ArduPilot's six samples", "none given"),
        ] {
            let (row, rms) = errors.row(name, intervals);
            table.push_str(&row);
            all.push(rms);
        }
    }
    println!("{table}");
    fos_testkit::page::holds(
        "hand-calibration.md",
        "<!-- begin rivals -->\n",
        "\n<!-- end rivals -->",
        &table,
    );
    // as good as imu_tk's where its assumptions hold, better where a rest is disturbed; far better than six samples
    assert!(all[0][0] < 1.05 * all[1][0] && all[3][0] < 1.05 * all[4][0] && all[6][0] < 0.7 * all[7][0]);
    assert!(all[0][0] < 0.9 * all[2][0]);
}
