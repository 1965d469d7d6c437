//! Residual of each rest, with the range in which 95 % are expected, as points of a small figure.

use fos_calibrate::{MG_MPS2, RestResidual};
use serde::Serialize;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 180.0;
const LEFT: f64 = 56.0;

/// One rest in the picture; lengths in pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// From the left.
    pub x: f64,
    /// From the top.
    pub y: f64,
    /// Upper and lower end of the expected range.
    pub range: [f64; 2],
    /// Not part of the estimate.
    pub excluded: bool,
}

/// The picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// Width of the picture.
    pub width: f64,
    /// Height of the picture.
    pub height: f64,
    /// Left end of the axis.
    pub left: f64,
    /// Height of a residual of 0, from the top.
    pub zero: f64,
    /// A point for each rest, in the order of the log.
    pub points: Vec<Point>,
    /// Text of the largest residual on the axis, mg.
    pub top_mg: String,
}

impl Picture {
    /// `None` without rests.
    pub fn of(rests: &[RestResidual]) -> Option<Self> {
        let used = || rests.iter().filter(|one| one.rest.excluded.is_none());
        let size = |one: &RestResidual| one.residual_mps2.abs().max(2.0 * one.deviation_mps2);
        let top = used().map(size).filter(|size| size.is_finite()).fold(0.0, f64::max);
        if top <= 0.0 {
            return None;
        }
        let zero = HEIGHT / 2.0;
        // Excluded rests may lie far outside and are drawn at the edge.
        let y = |mps2: f64| zero - (mps2 / top).clamp(-1.05, 1.05) * (zero - 12.0);
        let step = (WIDTH - LEFT - 16.0) / rests.len() as f64;
        let points = rests.iter().enumerate().map(|(index, one)| Point {
            x: LEFT + 8.0 + (index as f64 + 0.5) * step,
            y: y(one.residual_mps2),
            range: [1.96, -1.96].map(|times| y(times * one.deviation_mps2)),
            excluded: one.rest.excluded.is_some(),
        });
        let top_mg = format!("{:.2}", top / MG_MPS2);
        Some(Self { width: WIDTH, height: HEIGHT, left: LEFT, zero, points: points.collect(), top_mg })
    }
}
