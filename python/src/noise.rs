//! White noise, bias instability and random walk of a log at rest.

use std::sync::Arc;

use fos_data::interrupt::in_parallel;
use fos_data::stillness;
use fos_figures::noise::allan_of_noise;
use fos_figures::units::{ShownUnit, Units};
use fos_fit::export::{self, NoiseModel, NoiseUnits};
use fos_fit::noise::{AxisNoise, AxisNoiseError, axis_noise};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::{py_error, raised};
use crate::recording::Recording;
use crate::work;

/// Noise of `axes`, or of all axes.
fn of(py: Python<'_>, log: &Recording, axes: Option<Vec<String>>) -> PyResult<Vec<AxisNoise>> {
    let log = Arc::clone(&log.log);
    work::run(py, || -> Result<Vec<AxisNoise>, AxisNoiseError> {
        let axes = match axes {
            Some(axes) => axes,
            None => log.axes()?,
        };
        let stillness = stillness::find(&log);
        in_parallel(&axes, |axis| axis_noise(&log, &stillness, axis)).into_iter().collect()
    })?
    .map_err(raised(py))
}

/// Noise of every axis, as JSON.
#[pyfunction]
pub(crate) fn noise(py: Python<'_>, log: &Recording, axes: Option<Vec<String>>) -> PyResult<String> {
    let name = fos_data::file::name_of(&log.log.paths());
    let entries = of(py, log, axes)?.into_iter().map(|axis| {
        let NoiseUnits { white, flicker, walk } = NoiseUnits::of(&axis.unit);
        let shown = |axis: &AxisNoise| ShownUnit::of_noise(&axis.column, Units::Si);
        let figure = allan_of_noise(&name, std::slice::from_ref(&axis), shown);
        json!({ "noise": axis, "units": [white, flicker, walk], "figure": figure })
    });
    Ok(json!(entries.collect::<Vec<_>>()).to_string())
}

/// Files with the noise of three accelerometers and three gyros, for Kalibr and OpenVINS, ORB-SLAM3, and VINS.
#[pyfunction]
pub(crate) fn imu_yaml(
    py: Python<'_>,
    log: &Recording,
    rostopic: &str,
) -> PyResult<(String, String, String)> {
    let found = of(py, log, None)?;
    let name = fos_data::file::name_of(&log.log.paths());
    let model = NoiseModel::of(&name, log.log.rate.true_hz, &found);
    let model = model.map_err(|error| py_error(py, "NoiseError", &error.to_string()))?;
    Ok((export::imu_yaml(&model, rostopic), export::orb_slam3(&model), export::vins(&model)))
}
