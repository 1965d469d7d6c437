//! What a model announces.

/// What is known of a model before its inputs and axes are added.
#[derive(Debug, Clone)]
pub(crate) struct Building {
    pub(crate) period_s: f64,
    pub(crate) n_quantities: usize,
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}
