//! Cost of an axis on the device.

use std::mem::size_of;

use fos_core::Predictor;
use serde::{Deserialize, Serialize};

use crate::model::UnitModel;

/// Instructions per sample on the emulated Cortex-M4F for a factor of a term and for an input, as counted by
/// `.ci/device cost` (README, "Cost").
const PER_FACTOR: f64 = 7.9;
const PER_INPUT: f64 = 81.0;

/// Cost of the terms and inputs of an axis; the axis itself and the part shared by all axes are not included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Cost {
    /// Number of terms, physical and stochastic.
    pub terms: usize,
    /// Number of factors in all terms.
    pub factors: usize,
    pub inputs: usize,
    /// RAM of terms and inputs, bytes.
    pub ram_bytes: usize,
    /// Approximate number of instructions per sample.
    pub instructions: u32,
}

impl Cost {
    pub fn of(model: &UnitModel) -> Self {
        let terms = || model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
        let factors = terms().map(|term| term.factors.len()).sum();
        let inputs = model.inputs.len();
        // the difference of one more of each, with everything else equal
        let base = size_of::<Predictor<f32, 1, 8, 16, 64>>();
        let input = size_of::<Predictor<f32, 1, 9, 16, 64>>() - base;
        let term = size_of::<Predictor<f32, 1, 8, 17, 64>>() - base;
        Self {
            terms: terms().count(),
            factors,
            inputs,
            ram_bytes: terms().count() * term + inputs * input,
            instructions: (PER_FACTOR * factors as f64 + PER_INPUT * inputs as f64).round() as u32,
        }
    }

    /// Returns the cost in excess of `base`.
    pub fn beyond(&self, base: &Self) -> Self {
        Self {
            terms: self.terms.saturating_sub(base.terms),
            factors: self.factors.saturating_sub(base.factors),
            inputs: self.inputs.saturating_sub(base.inputs),
            ram_bytes: self.ram_bytes.saturating_sub(base.ram_bytes),
            instructions: self.instructions.saturating_sub(base.instructions),
        }
    }
}
