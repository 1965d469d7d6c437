//! Capacities that a hub needs for a model, for the check in its C header and the types of its Rust source.

use fos_fit::model::UnitModel;

/// Required capacities of a hub.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// Number of inputs; the hub has the same number of logged quantities.
    pub inputs: usize,
    /// Number of terms of all axes.
    pub terms: usize,
    /// Values of history: (longest lag) × (inputs + axes) + inputs, up to the next power of two.
    pub history: usize,
}

impl Room {
    /// Capacities required by `model`.
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

/// Samples in the history before every term has a value.
pub(super) fn longest_lag(model: &UnitModel) -> usize {
    let terms = model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
    let lags = terms.flat_map(|term| &term.factors).map(|factor| usize::from(factor.lag));
    lags.max().unwrap_or(0)
}
