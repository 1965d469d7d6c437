//! Header of a model: the sizes announced before its inputs and axes.

use crate::Model;

/// Period and sizes of a model, known before its inputs and axes are added.
#[derive(Debug, Clone)]
pub(crate) struct ModelHeader {
    pub(crate) period_s: f64,
    pub(crate) n_quantities: usize,
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}

impl ModelHeader {
    pub(crate) fn of<R>(model: &Model<'_, R>) -> Self {
        Self {
            period_s: model.period_s,
            n_quantities: model.quantities.len(),
            n_inputs: model.inputs.len(),
            n_axes: model.axes.len(),
        }
    }
}
