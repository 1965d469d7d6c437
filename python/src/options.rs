//! Options of a fit, from Python.

use fos_core::FittedOn;
use fos_fit::fit::FitOptions;
use fos_fit::fit::{InputSpec, Train};
use pyo3::prelude::*;

use crate::error::py_error;

/// Keywords of a fit.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Given {
    method: String,
    denoise: Option<String>,
    search: String,
    max_lag: u16,
    degree: usize,
    memory_s: Vec<f64>,
    inputs: Vec<String>,
    input_lags: u16,
    physical: Vec<String>,
    max_terms: usize,
    stop: String,
    train: String,
    offset: Option<f64>,
    scale: Option<f64>,
    full_scale: f64,
    factory_corrected: bool,
}

impl Given {
    /// Options for the engine.
    ///
    /// # Errors
    ///
    /// A word is not among those of an option; the message lists them.
    pub(crate) fn options(&self, py: Python<'_>) -> PyResult<FitOptions> {
        self.parsed().map_err(|wrong| py_error(py, "FitError", &wrong))
    }

    fn parsed(&self) -> Result<FitOptions, String> {
        let named = |option: &'static str| move |wrong: String| format!("{option}: {wrong}");
        let specs = |texts: &[String]| -> Result<Vec<InputSpec>, String> {
            texts.iter().map(|text| text.parse()).collect()
        };
        if let Some(tau) = self.memory_s.iter().find(|tau| !(tau.is_finite() && **tau > 0.0)) {
            return Err(format!("memory_s: {tau} is not a positive time in seconds"));
        }
        if self.max_lag == 0 || !(1..=3).contains(&self.degree) {
            return Err("max_lag is 1 or more, degree is 1, 2 or 3".to_owned());
        }
        let denoising = self.denoise.as_deref().map(str::parse).transpose();
        Ok(FitOptions {
            method: self.method.parse().map_err(named("method"))?,
            denoising: denoising.map_err(|wrong| format!("denoise: {wrong}"))?,
            search: self.search.parse().map_err(named("search"))?,
            max_lag: self.max_lag,
            degree: self.degree,
            memory_s: self.memory_s.clone(),
            inputs: specs(&self.inputs).map_err(named("inputs"))?,
            input_lags: self.input_lags,
            physical: specs(&self.physical).map_err(named("physical"))?,
            max_terms: self.max_terms,
            stop: self.stop.parse().map_err(named("stop"))?,
            train: self.train.parse::<Train>().map_err(named("train"))?,
            offset: self.offset,
            scale: self.scale,
            full_scale: self.full_scale,
            fitted_on: if self.factory_corrected { FittedOn::FactoryCorrected } else { FittedOn::Raw },
        })
    }
}

/// Default options of a fit, as JSON.
#[pyfunction]
pub(crate) fn fit_defaults() -> String {
    serde_json::to_string(&FitOptions::default()).unwrap_or_default()
}
