//! What an axis costs on the device.

use std::mem::size_of;

use fos_core::Predictor;
use serde::{Deserialize, Serialize};

use crate::model::UnitModel;

/// Instructions a sample on the emulated Cortex-M4F for a factor of a term and for an input, as `.ci/device cost`
/// counts them (README, "Cost").
const PER_FACTOR: f64 = 7.9;
const PER_INPUT: f64 = 81.0;

/// What the terms and inputs of an axis cost; the axis itself and what all axes share come on top.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Cost {
    /// Physical and stochastic together.
    pub terms: usize,
    /// Factors of all terms.
    pub factors: usize,
    pub inputs: usize,
    /// RAM of terms and inputs, bytes.
    pub ram_bytes: usize,
    /// Instructions a sample, about.
    pub instructions: u32,
}

impl Cost {
    pub fn of(model: &UnitModel) -> Self {
        let terms = || model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
        let factors = terms().map(|term| term.factors.len()).sum();
        let inputs = model.inputs.len();
        // one more of each, everything else equal
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

    /// What this costs more than `base`.
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
