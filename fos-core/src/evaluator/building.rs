//! Header of a model: the sizes announced before its inputs and axes.

/// Period and sizes of a model, known before its inputs and axes are added.
#[derive(Debug, Clone)]
pub(crate) struct ModelHeader {
    pub(crate) period_s: f64,
    pub(crate) n_quantities: usize,
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}
