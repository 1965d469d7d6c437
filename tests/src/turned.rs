//! Log of a device that a hand lays down in one orientation after the other, as CSV of the log format, 50 rows per second.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;

use crate::noise::Noise;

/// Bias, m/s², and sensitivity of the accelerometer.
pub const ACCELEROMETER: [(f64, f64); 3] = [(0.15, 1.012), (-0.22, 0.991), (0.08, 1.004)];
/// Bias, rad/s, and sensitivity of the gyro.
pub const GYRO: [(f64, f64); 3] = [(0.01, 1.013), (-0.006, 0.989), (0.003, 0.999)];

/// Dwells of 2 s in 14 orientations, turned in between.
pub fn turned_log() -> String {
    log_of(14, 100)
}

/// The same device at rest for a minute.
pub fn resting_log() -> String {
    log_of(0, 3000)
}

/// Turns `v` about a unit vector (Rodrigues).
fn turned([x, y, z]: [f64; 3], [a, b, c]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let along = (1.0 - cos) * (a * x + b * y + c * z);
    let across = [b * z - c * y, c * x - a * z, a * y - b * x];
    [
        x * cos + across[0] * sin + a * along,
        y * cos + across[1] * sin + b * along,
        z * cos + across[2] * sin + c * along,
    ]
}

/// A log of `turns`, each after a dwell of `rows`, or of one dwell.
fn log_of(turns: usize, rows: usize) -> String {
    let mut noise = Noise::new(1);
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2,gx_rads,gy_rads,gz_rads\n".to_owned();
    let mut row = 0_u32;
    let mut push = |force: [f64; 3], rate: [f64; 3]| {
        let _ = write!(text, "{:.2}", f64::from(row) * 0.02);
        for (force, (bias, sensitivity)) in force.into_iter().zip(ACCELEROMETER) {
            let _ = write!(text, ",{:.5}", sensitivity * force + bias + 0.006 * noise.normal());
        }
        for (rate, (bias, sensitivity)) in rate.into_iter().zip(GYRO) {
            let _ = write!(text, ",{:.6}", sensitivity * rate + bias + 0.0006 * noise.normal());
        }
        text.push('\n');
        row += 1;
    };
    // specific force in the frame of the device
    let mut up = [0.0, 0.0, 9.80665];
    for n in 0..turns.max(1) {
        (0..rows).for_each(|_| push(up, [0.0; 3]));
        if turns == 0 {
            break;
        }
        // quarter turns reach the faces, thirds of a right angle the orientations between
        let axis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]][n % 3];
        let whole = if n < 6 { FRAC_PI_2 } else { 1.1 };
        for step in 0..75 {
            // a raised cosine: from rest to rest
            let phase = TAU * f64::from(step) / 75.0;
            let angle = whole * (phase - phase.sin()) / TAU;
            let [x, y, z] = turned(up, axis, angle);
            let force = [x + (9.0 * phase).sin(), y + (7.0 * phase).cos(), z + (11.0 * phase).sin()];
            push(force, axis.map(|part| -part * whole * (1.0 - phase.cos()) / 1.5));
        }
        up = turned(up, axis, whole);
    }
    text
}
