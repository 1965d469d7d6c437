//! Figures, drawn as in reports.

use fos_figures::{Figure, svg};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// SVG document of a figure that a result has as JSON.
#[pyfunction]
pub(crate) fn draw(figure: &str) -> PyResult<String> {
    let figure: Figure =
        serde_json::from_str(figure).map_err(|error| PyValueError::new_err(error.to_string()))?;
    svg(&figure).map_err(|error| PyValueError::new_err(error.to_string()))
}
