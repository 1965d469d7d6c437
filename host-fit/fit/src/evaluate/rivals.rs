//! Plain rivals that every model is compared with. They run on fos-core like any model.

use fos_core::{Range, y};

use super::errors::ModelErrors;
use crate::model::{FittedTerm, UnitModel};

/// A plain way of predicting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rival {
    /// The constant mean of the training data.
    Mean,
    /// First-order Gauss-Markov: φ·y(n−1) with φ the lag-1 autocorrelation of the training data.
    GaussMarkov,
    /// The last value, held.
    LastValue,
}

/// Name of the model among its rivals.
pub const MODEL: &str = "model";

/// Returns the errors of the constant mean and of the model.
pub fn before_and_after<'e>(
    errors: impl IntoIterator<Item = &'e ModelErrors> + Clone,
) -> [Option<&'e ModelErrors>; 2] {
    [Rival::Mean.name(), MODEL].map(|name| errors.clone().into_iter().find(|errors| errors.model == name))
}

/// Coast limit of a rival, s: never reached, as its prediction is part of its definition.
const FOR_EVER_S: f64 = 1e9;

impl Rival {
    /// Constant mean, first-order Gauss-Markov, last value.
    pub const ALL: [Rival; 3] = [Rival::Mean, Rival::GaussMarkov, Rival::LastValue];

    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "constant mean",
            Self::GaussMarkov => "Gauss-Markov",
            Self::LastValue => "last value held",
        }
    }
}

/// Returns the rival of `model` on the same axes: it has the statistics of the rows that the model was fitted on, and
/// nothing of the model itself. `lag_1` is the lag-1 autocorrelation of each axis' training data, for models that do
/// not state it.
pub fn rival(model: &UnitModel, kind: Rival, lag_1: &[f64]) -> UnitModel {
    let mut plain = model.clone();
    plain.inputs.clear();
    plain.quantities.clear();
    for (axis, lag_1) in plain.axes.iter_mut().zip(lag_1) {
        axis.physical.clear();
        axis.parameters.physical_range = Range::new(0.0, 0.0);
        axis.parameters.constant = 0.0;
        axis.parameters.coast_limit_s = FOR_EVER_S;
        // the model's offset is that of the residual of its physical part, and so is its range
        let mut lag_1 = lag_1;
        if let Some(plain) = &axis.plain {
            let parameters = &mut axis.parameters;
            parameters.offset = plain.mean - parameters.reference;
            let scaled = |value: f64| (value - plain.mean) / parameters.scale;
            parameters.range = Range::new(scaled(plain.range.low), scaled(plain.range.high));
            lag_1 = &plain.lag_1;
        }
        let coefficient = match kind {
            Rival::Mean => None,
            Rival::GaussMarkov => Some(*lag_1),
            Rival::LastValue => Some(1.0),
        };
        axis.stochastic = coefficient
            .map(|coefficient| FittedTerm { coefficient, standard_error: None, factors: vec![y(1)] })
            .into_iter()
            .collect();
    }
    plain
}
