//! A log of a device with dwells of 2 s in 14 orientations, turned in between, as CSV in the log format.

use std::fmt::Write as _;

use nalgebra::{Rotation3, Vector3};

/// Bias, m/s², and sensitivity of the accelerometer, and of the gyro (rad/s).
pub(crate) const ACCELEROMETER: [(f64, f64); 3] = [(0.15, 1.012), (-0.22, 0.991), (0.08, 1.004)];
pub(crate) const GYRO: [(f64, f64); 3] = [(0.01, 1.013), (-0.006, 0.989), (0.003, 0.999)];

pub(crate) fn turned_log() -> String {
    log_of(14, 100)
}

/// The same device at rest for a minute.
pub(crate) fn resting_log() -> String {
    log_of(0, 3000)
}

/// A log of `turns`, each after a dwell of `rows`, or of one dwell.
fn log_of(turns: u32, rows: usize) -> String {
    let mut seed = 1_u64;
    let mut noise = move || {
        // sum of four uniform numbers of a linear congruential generator: a better generator is not needed
        (0..4)
            .map(|_| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 40) as f64 / f64::from(1 << 24) - 0.5
            })
            .sum::<f64>()
    };
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2,gx_rads,gy_rads,gz_rads\n".to_owned();
    let mut row = 0_u32;
    let mut push = |force: Vector3<f64>, rate: Vector3<f64>| {
        let _ = write!(text, "{:.2}", f64::from(row) * 0.02);
        for (axis, (bias, sensitivity)) in ACCELEROMETER.into_iter().enumerate() {
            let _ = write!(text, ",{:.5}", sensitivity * force[axis] + bias + 0.01 * noise());
        }
        for (axis, (bias, sensitivity)) in GYRO.into_iter().enumerate() {
            let _ = write!(text, ",{:.6}", sensitivity * rate[axis] + bias + 0.001 * noise());
        }
        text.push('\n');
        row += 1;
    };
    let mut attitude = Rotation3::identity();
    for n in 0..turns.max(1) {
        for _ in 0..rows {
            push(attitude * Vector3::z() * 9.80665, Vector3::zeros());
        }
        if turns == 0 {
            break;
        }
        // quarter turns reach the faces, thirds of a right angle the orientations between
        let axis = [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, 0.8)][n as usize % 3];
        let whole = axis * if n < 6 { std::f64::consts::FRAC_PI_2 } else { 1.1 };
        let from = attitude;
        for step in 0..75 {
            let phase = std::f64::consts::TAU * f64::from(step) / 75.0;
            attitude =
                Rotation3::new(whole * (f64::from(step) / 75.0 - phase.sin() / std::f64::consts::TAU)) * from;
            let shake = Vector3::new((9.0 * phase).sin(), (7.0 * phase).cos(), (11.0 * phase).sin());
            push(attitude * Vector3::z() * 9.80665 + shake, -whole * (1.0 - phase.cos()) / 1.5);
        }
        attitude = Rotation3::new(whole) * from;
    }
    text
}
