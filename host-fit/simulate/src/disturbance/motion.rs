//! Motion added to a log, and its stretches.

use serde::Serialize;

use crate::random::{Random, between};
use crate::world::World;

/// Log length to which the stated number of a disturbance refers, s; shorter logs get fewer.
const USUAL_S: f64 = 1500.0;

/// Number of occurrences, at least one.
pub(super) fn times(world: &World, [fewest, most]: [f64; 2], random: &mut Random) -> usize {
    (between(random, fewest, most) * (world.duration_s() / USUAL_S).min(1.0)).max(1.0) as usize
}

/// A disturbed stretch of a log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Disturbed {
    /// Start, s after the first sample.
    pub from_s: f64,
    pub to_s: f64,
}

/// Motion added to the six axes of a log, in their units, and its stretches.
#[derive(Debug, Clone, Default)]
pub(crate) struct Motion {
    /// One series for each axis; empty if nothing moves.
    pub(crate) axes: [Vec<f64>; 6],
    /// Disturbed stretches, in order.
    pub(crate) when: Vec<Disturbed>,
}

impl Motion {
    pub(super) fn none(n: usize) -> Self {
        Self { axes: std::array::from_fn(|_| vec![0.0; n]), when: Vec::new() }
    }

    pub(super) fn is_over(&mut self, from_s: f64, to_s: f64) {
        self.when.push(Disturbed { from_s, to_s });
    }

    /// Motion of an axis at a row, m/s² or rad/s.
    pub(crate) fn at(&self, axis: usize, row: usize) -> f64 {
        self.axes[axis].get(row).copied().unwrap_or(0.0)
    }
}
