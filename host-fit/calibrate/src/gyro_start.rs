//! First guess of the gyro's matrix: its scale, where it is in counts, and the correspondence of its axes.

use nalgebra::Matrix3;

use fos_data::statistics::median_of;

use crate::imu::Scale;
use crate::parameter::AXES;
use crate::turn::{Prepared, angles};

/// A guess whose turns end this far off, rad, in the median, explains them: 15°.
const GOOD: f64 = 0.26;

/// Turns that are tried; more do not change the median.
const MOST_TRIED: usize = 24;

/// A hand turns a device by these angles from rest to rest, rad, in the median.
const ANGLES: [f64; 2] = [0.2, 15.0];

/// Ratio of a tried scale to the one before it: the fit converges from a scale within 5 %.
const STEP: f64 = 1.05;

/// A scale and a correspondence of axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) matrix: Matrix3<f64>,
}

impl Start {
    /// The correspondence in words; `None` if x is x, y is y, z is z.
    pub(crate) fn axis_order(&self) -> Option<String> {
        let largest = self.matrix.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        let pairs: Vec<String> = (0..3)
            .map(|gyro| {
                let axis =
                    (0..3).find(|axis| self.matrix[(*axis, gyro)].abs() > 0.5 * largest).unwrap_or(gyro);
                let sign = if self.matrix[(axis, gyro)] < 0.0 { "−" } else { "" };
                format!("{} is {sign}{}", AXES[gyro], AXES[axis])
            })
            .collect();
        (pairs != ["x is x", "y is y", "z is z"]).then(|| pairs.join(", "))
    }
}

/// The best of the tried guesses; `None` if none explains the turns.
pub(crate) fn start(prepared: &[Prepared], scale: Scale) -> Option<Start> {
    let step = prepared.len().div_ceil(MOST_TRIED).max(1);
    let off = |matrix: &Matrix3<f64>| {
        let some = prepared.iter().step_by(step);
        median_of(some.flat_map(|turn| angles(std::slice::from_ref(turn), matrix))).unwrap_or(f64::INFINITY)
    };
    let scales: Vec<f64> = match scale {
        Scale::Si => vec![1.0],
        Scale::Counts => {
            let turned =
                median_of(prepared.iter().map(|turn| turn.rates.angle())).filter(|angle| *angle > 0.0)?;
            let count = (ANGLES[1] / ANGLES[0]).ln() / STEP.ln();
            (0..=count as i32).map(|n| ANGLES[0] / turned * STEP.powi(n)).collect()
        }
    };
    let best_of = |orders: &[Matrix3<f64>]| {
        let tried = orders.iter().flat_map(|order| scales.iter().map(move |scale| order * *scale));
        tried.map(|matrix| (off(&matrix), matrix)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (same, matrix) = best_of(&[Matrix3::identity()])?;
    if same < GOOD {
        return Some(Start { matrix });
    }
    let (other, reordered) = best_of(&orders())?;
    // another order of the axes must explain the turns, and far better
    match other < GOOD && other < 0.5 * same {
        true => Some(Start { matrix: reordered }),
        false if same < 4.0 * GOOD => Some(Start { matrix }),
        false => None,
    }
}

/// The 48 matrices that exchange axes and their signs.
fn orders() -> Vec<Matrix3<f64>> {
    let mut all = Vec::new();
    for [x, y, z] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8 {
            let sign = |bit: i32| if signs & bit == 0 { 1.0 } else { -1.0 };
            let mut order = Matrix3::zeros();
            order[(x, 0)] = sign(1);
            order[(y, 1)] = sign(2);
            order[(z, 2)] = sign(4);
            all.push(order);
        }
    }
    all
}
