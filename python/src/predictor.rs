//! Runs an image over arrays on fos-core in f32, with the results of a device.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use fos_core::image::VERSION;
use fos_core::{Correction, Image, Sample, Validity};
use fos_data::stillness;
use fos_diagnose::compare::lags_off;
use fos_fit::calibration::{Calibrated, hub_columns};
use fos_fit::export::{NoColumn, description, model_of};
use fos_fit::model::{HostPredictor, UnitModel};
use fos_fit::playback::Playback;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::{py_error, raised};
use crate::recording::Recording;
use crate::work;

/// Maximum number of steps of one forecast, as in `predictor.py`.
const MOST_STEPS: usize = 10_000_000;

/// A predictor, and the calibration of its corrected values.
#[derive(Clone)]
struct Device {
    predictor: HostPredictor<f32>,
    calibrated: Option<Calibrated>,
}

/// The model of an image and its state.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Predictor {
    fresh: Device,
    state: Mutex<Device>,
    model: UnitModel,
    about: String,
}

/// Corrections of rows, each axis by axis.
#[derive(Default)]
struct Rows {
    predicted: Vec<f32>,
    innovation: Vec<f32>,
    corrected: Vec<f32>,
    validity: Vec<u16>,
}

/// Predictions, innovations, corrected values, validities; each rows × axes.
type Arrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u16>>,
);

impl Rows {
    /// Adds the corrections of a row. `others` returns the measured value of an axis without a model, if it is known.
    fn push(
        &mut self,
        corrections: &[Correction<f32>],
        calibrated: &mut Option<Calibrated>,
        others: impl Fn(usize) -> Option<f32>,
    ) {
        let begin = self.corrected.len();
        for correction in corrections {
            self.predicted.push(correction.predicted);
            self.innovation.push(correction.innovation.unwrap_or(f32::NAN));
            self.corrected.push(correction.corrected);
            self.validity.push(correction.validity.bits());
        }
        if let Some(calibrated) = calibrated {
            calibrated.apply(&mut self.corrected[begin..], others);
        }
    }

    fn arrays(self, py: Python<'_>, n_axes: usize) -> PyResult<Arrays<'_>> {
        let n_rows = self.predicted.len() / n_axes.max(1);
        let shaped = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([n_rows, n_axes]);
        Ok((
            shaped(self.predicted)?,
            shaped(self.innovation)?,
            shaped(self.corrected)?,
            PyArray1::from_vec(py, self.validity).reshape([n_rows, n_axes])?,
        ))
    }
}

/// Names of the validity flags, in the order of the bits.
#[pyfunction]
pub(crate) fn validity_names() -> Vec<&'static str> {
    Validity::all().names().collect()
}

impl Predictor {
    fn lock(&self) -> MutexGuard<'_, Device> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Rows of a two-dimensional array of any memory order.
fn rows(py: Python<'_>, what: &str, array: &PyReadonlyArray2<'_, f32>, columns: usize) -> PyResult<Vec<f32>> {
    let view = array.as_array();
    if view.ncols() != columns {
        let found = view.ncols();
        let help = "the order is that of `axes` and `quantities`";
        let text = format!("{what} has {found} columns where the model has {columns}\nhelp: {help}");
        return Err(py_error(py, "PredictorError", &text));
    }
    Ok(view.iter().copied().collect())
}

#[pymethods]
impl Predictor {
    #[new]
    fn new(py: Python<'_>, image: &[u8], axes: Vec<String>) -> PyResult<Self> {
        let refused = |text: String| py_error(py, "ImageError", &format!("the image cannot be run: {text}"));
        let parsed = Image::parse(image).map_err(|error| refused(error.to_string()))?;
        let predictor: HostPredictor<f32> = parsed.predictor().map_err(|error| refused(error.to_string()))?;
        let fresh = Device { predictor, calibrated: Calibrated::of(&parsed) };
        let model = model_of(&parsed, &axes)
            .map_err(|error: NoColumn| py_error(py, "ImageError", &error.to_string()))?;
        let info = parsed.info();
        let lines = |text: &str| -> Vec<String> { text.lines().map(str::to_owned).collect() };
        let about = json!({
            "axes": model.axes.iter().map(|axis| &axis.column).collect::<Vec<_>>(),
            "quantities": model.quantities.iter().map(|logged| &logged.column).collect::<Vec<_>>(),
            "period_s": model.period_s,
            "sensor": info.sensor,
            "effects": lines(info.effects),
            "provenance": lines(info.provenance),
            "terms": model.n_terms(),
            "bytes": image.len(),
            "version": VERSION,
            "description": description(&parsed),
        });
        Ok(Self { state: Mutex::new(fresh.clone()), fresh, model, about: about.to_string() })
    }

    /// Description of the image, as JSON.
    fn about(&self) -> &str {
        &self.about
    }

    /// Runs over a log from power-on, tracking at rest and coasting in motion, as a device does. Returns the
    /// corrections, the detected rest, and the relative error of the lags in time. The state of the predictor is
    /// not changed.
    fn run<'py>(
        &self,
        py: Python<'py>,
        log: &Recording,
    ) -> PyResult<(Arrays<'py>, Bound<'py, PyArray1<bool>>, Option<f64>)> {
        let log = Arc::clone(&log.log);
        let off = lags_off(&self.model, &log);
        let (found, still) = work::run(py, || {
            let stillness = stillness::find(&log);
            let playback = Playback::new(&log, &self.model, &stillness.still)?;
            let Device { mut predictor, mut calibrated } = self.fresh.clone();
            let (mut feed, columns) = (playback.feed(), hub_columns(&log));
            let mut found = Rows::default();
            for row in 0..log.n_rows() {
                if row.is_multiple_of(1024) {
                    fos_data::interrupt::check();
                }
                let others = |axis: usize| columns[axis].map(|column| column[row] as f32);
                found.push(feed.step(&mut predictor, row), &mut calibrated, others);
            }
            Ok((found, stillness.still))
        })?
        .map_err(raised::<fos_data::recording::RecordingError>(py))?;
        Ok((found.arrays(py, self.model.axes.len())?, PyArray1::from_vec(py, still), off))
    }

    /// Processes samples: rows × axes measured, rows × quantities, and the rows at rest.
    fn step<'py>(
        &self,
        py: Python<'py>,
        measured: PyReadonlyArray2<'py, f32>,
        quantities: PyReadonlyArray2<'py, f32>,
        still: Vec<bool>,
    ) -> PyResult<Arrays<'py>> {
        let (n_axes, n_quantities) = (self.model.axes.len(), self.model.quantities.len());
        let n_rows = still.len();
        let (measured, quantities) =
            (rows(py, "measured", &measured, n_axes)?, rows(py, "quantities", &quantities, n_quantities)?);
        if measured.len() != n_rows * n_axes || quantities.len() != n_rows * n_quantities {
            return Err(py_error(
                py,
                "PredictorError",
                "measured, quantities and still differ in their rows",
            ));
        }
        let found = work::run(py, || {
            let Device { predictor, calibrated } = &mut *self.lock();
            let mut found = Rows::default();
            for (row, still) in still.into_iter().enumerate() {
                let sample = Sample {
                    measured: &measured[row * n_axes..(row + 1) * n_axes],
                    quantities: &quantities[row * n_quantities..(row + 1) * n_quantities],
                };
                let corrections = if still { predictor.track(&sample) } else { predictor.coast(&sample) };
                found.push(corrections, calibrated, |_| None);
            }
            found
        })?;
        found.arrays(py, n_axes)
    }

    /// Predicts the following rows without samples, one for each row of `quantities`.
    fn forecast<'py>(
        &self,
        py: Python<'py>,
        quantities: PyReadonlyArray2<'py, f32>,
        steps: usize,
    ) -> PyResult<Arrays<'py>> {
        let n_quantities = self.model.quantities.len();
        let quantities = rows(py, "quantities", &quantities, n_quantities)?;
        if steps > MOST_STEPS {
            let text =
                format!("{steps} steps: a forecast has at most {MOST_STEPS}\nhelp: forecast in pieces");
            return Err(py_error(py, "PredictorError", &text));
        }
        if quantities.len() != steps * n_quantities {
            return Err(py_error(py, "PredictorError", "quantities has another number of rows than steps"));
        }
        let found = work::run(py, || {
            let Device { predictor, calibrated } = &mut *self.lock();
            let mut found = Rows::default();
            for row in 0..steps {
                if row.is_multiple_of(1024) {
                    fos_data::interrupt::check();
                }
                let quantities = &quantities[row * n_quantities..(row + 1) * n_quantities];
                found.push(predictor.forecast(quantities), calibrated, |_| None);
            }
            found
        })?;
        found.arrays(py, self.model.axes.len())
    }

    /// Skips missing samples.
    fn skip(&self, ticks: u32) {
        let _ = self.lock().predictor.skip(ticks);
    }

    /// Resets to the state at power-on.
    fn reset(&self) {
        *self.lock() = self.fresh.clone();
    }
}
