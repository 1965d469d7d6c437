//! Monitors the fit of the model, one axis at a time.

use fos_core::{AxisParameters, Correction, Drift, InnovationStatistics, Monitor, Scalar};
use heapless::Vec;

use super::axes::AXES;

/// Samples of one axis before the next has its turn: one second at 200 Hz. Monitoring an axis costs as much as two terms
/// per sample; in turn, six axes cost as much as one. An alarm comes five seconds later for every turn that the test takes.
const TURN: u8 = 200;

/// The monitors of the axes of a model.
#[derive(Debug, Clone)]
pub(super) struct Watch<R: Scalar> {
    monitors: Vec<Monitor<R>, AXES>,
    watched: u8,
    left: u8,
    /// Bit i is set if the model of axis i no longer fits.
    drifted: u8,
}

impl<R: Scalar<Stored = f32>> Watch<R> {
    pub(super) const NOTHING: Self = Self { monitors: Vec::new(), watched: 0, left: TURN, drifted: 0 };

    pub(super) fn clear(&mut self) {
        self.monitors.clear();
        (self.watched, self.left, self.drifted) = (0, TURN, 0);
    }

    // a separate function, so that its stack frame and that of the decoding do not add up
    #[inline(never)]
    pub(super) fn add(&mut self, parameters: &AxisParameters<f32>, period_s: f64) {
        // never full: at most six axes
        let _ = self.monitors.push(Monitor::new(parameters, period_s));
    }

    /// Processes the corrections of a sample. Returns the index in the model of an axis whose drift was just detected.
    #[inline]
    pub(super) fn update(&mut self, axes: &[u8], corrections: &[Correction<R>; AXES]) -> Option<usize> {
        let mut stopped = None;
        let index = usize::from(self.watched);
        let correction = axes.get(index).and_then(|channel| corrections.get(usize::from(*channel)));
        if let (Some(monitor), Some(correction)) = (self.monitors.get_mut(index), correction) {
            let drift = monitor.update(correction);
            if drift.mean || drift.variance {
                let bit = 1_u8.checked_shl(u32::from(self.watched)).unwrap_or(0);
                if self.drifted & bit == 0 {
                    stopped = Some(index);
                }
                self.drifted |= bit;
            }
        }
        self.left -= 1;
        if self.left == 0 {
            self.left = TURN;
            self.watched = if index + 1 < self.monitors.len() { self.watched + 1 } else { 0 };
        }
        stopped
    }

    #[inline]
    pub(super) fn any(&self) -> bool {
        self.drifted != 0
    }

    pub(super) fn drift(&self, index: usize) -> Option<Drift> {
        self.monitors.get(index).map(Monitor::drift)
    }

    pub(super) fn statistics(&self, index: usize) -> Option<InnovationStatistics<f32>> {
        self.monitors.get(index).map(Monitor::statistics)
    }

    pub(super) fn deviation_ratio(&self, index: usize) -> Option<f32> {
        self.monitors.get(index).map(Monitor::deviation_ratio)
    }

    pub(super) fn restart(&mut self) {
        self.monitors.iter_mut().for_each(Monitor::restart);
        self.drifted = 0;
    }
}
