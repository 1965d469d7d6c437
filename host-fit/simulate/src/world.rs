//! True quantities during a log: time, temperature, supply, load, magnetic field, specific force, rate.

use std::ops::Range;

use super::axis::Axis;

/// True covariates of one log, sample by sample.
#[derive(Debug, Clone, Default)]
pub(super) struct World {
    /// Sampling period, s.
    pub(super) period_s: f64,
    /// Die temperature, °C.
    pub(super) temp_c: Vec<f64>,
    /// Supply voltage, V.
    pub(super) supply_v: Vec<f64>,
    /// Load of the processor, %.
    pub(super) load_pct: Vec<f64>,
    /// Magnetic field in the axes of the device, µT.
    pub(super) field_ut: [Vec<f64>; 3],
    /// Specific force in the axes of the device, m/s².
    pub(super) force_mps2: [Vec<f64>; 3],
    /// Angular rate in the axes of the device, rad/s.
    pub(super) rate_rads: [Vec<f64>; 3],
    /// Mean square of the vibration, summed over all axes, (m/s²)².
    pub(super) vibration: Vec<f64>,
    /// Rows without rotation; `None` if the device never rotates, or may rotate at any time.
    pub(super) still: Option<Vec<bool>>,
    /// True if the true specific force is logged.
    pub(super) force_is_logged: bool,
    /// True if the true rate is logged.
    pub(super) rate_is_logged: bool,
}

impl World {
    pub(super) fn len(&self) -> usize {
        self.temp_c.len()
    }

    /// Duration, s.
    pub(super) fn duration_s(&self) -> f64 {
        self.len() as f64 * self.period_s
    }

    /// True value of an axis, in its unit.
    pub(super) fn truth(&self, axis: Axis) -> &[f64] {
        let vector = if axis.is_gyro() { &self.rate_rads } else { &self.force_mps2 };
        &vector[axis.direction()]
    }

    /// Returns true if the true value of this axis is logged.
    pub(super) fn has_reference(&self, axis: Axis) -> bool {
        if axis.is_gyro() { self.rate_is_logged } else { self.force_is_logged }
    }

    /// Stretches in which the error of `axis` is observable: all, or those at rest if a rig rotates without a reference.
    pub(super) fn usable(&self, axis: Axis) -> Vec<Range<usize>> {
        match &self.still {
            Some(still) if !self.has_reference(axis) => {
                fos_data::recording::runs(0..self.len(), |n| still[n])
            }
            _ => std::iter::once(0..self.len()).collect(),
        }
    }

    /// Decimated copy with the mean of every `by` samples; a cell is still if all its samples are.
    pub(super) fn decimated(&self, by: usize) -> Self {
        let mean = |values: &Vec<f64>| -> Vec<f64> {
            values.chunks_exact(by).map(|cell| cell.iter().sum::<f64>() / by as f64).collect()
        };
        Self {
            period_s: self.period_s * by as f64,
            temp_c: mean(&self.temp_c),
            supply_v: mean(&self.supply_v),
            load_pct: mean(&self.load_pct),
            field_ut: self.field_ut.each_ref().map(mean),
            force_mps2: self.force_mps2.each_ref().map(mean),
            rate_rads: self.rate_rads.each_ref().map(mean),
            vibration: mean(&self.vibration),
            still: self.still.as_ref().map(|s| s.chunks_exact(by).map(|c| c.iter().all(|x| *x)).collect()),
            ..*self
        }
    }
}
