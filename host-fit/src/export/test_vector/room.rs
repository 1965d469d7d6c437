//! The capacities that a model asks of a hub, for the check in its C header and the types of its Rust source.

use fos_fit::model::UnitModel;

/// What a hub must have room for: inputs and as many quantities, terms, values of history (a power of two).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// As many for inputs as for logged quantities.
    pub inputs: usize,
    /// Of all axes together.
    pub terms: usize,
    /// (longest lag) × (inputs + axes) + inputs, up to the next power of two.
    pub history: usize,
}

impl Room {
    /// What `model` needs.
    pub fn for_model(model: &UnitModel) -> Self {
        let (n_inputs, n_axes) = (model.inputs.len(), model.axes.len());
        let deepest = (longest_lag(model) * (n_inputs + n_axes) + n_inputs).max(n_inputs + n_axes);
        Self {
            inputs: n_inputs.max(model.quantities.len()),
            terms: model.n_terms(),
            history: deepest.next_power_of_two(),
        }
    }
}

/// Samples that a history must hold before every term means anything.
pub(super) fn longest_lag(model: &UnitModel) -> usize {
    let terms = model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
    let lags = terms.flat_map(|term| &term.factors).map(|factor| usize::from(factor.lag));
    lags.max().unwrap_or(0)
}
