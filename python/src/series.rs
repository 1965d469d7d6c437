//! Model of an output as a polynomial of its own past and of any inputs, for the regressor. Searched by `fos_fit::fit`,
//! run by fos-core.

use std::ops::Range;

use fos_core::{
    Axis, AxisParameters, Channel, Correction, FittedOn, InnovationStatistics, Input, Quantity,
    Range as Limits, Sample, Source, Transform, Validity,
};
use fos_fit::candidates::{Candidates, monomial_text_named};
use fos_fit::fit::{Search, Stop, StopRule, Stopped, fit};
use fos_fit::model::{FittedAxis, FittedTerm, HostPredictor, LoggedQuantity, NamedInput, UnitModel};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::py_error;
use crate::work;

/// Name of the output.
const OUTPUT: &str = "y";

/// Sample period: samples are counted, not timed.
const PERIOD_S: f64 = 1.0;

/// Limit of a coast, s: none. The limit protects the history of sensors and has no purpose here.
const FOR_EVER_S: f64 = 1e9;

/// Number of skipped ticks that clears any history.
const FAR: u32 = u32::MAX;

/// Limits wider than any scaled value.
const ANY: Limits<f64> = Limits { low: -1e12, high: 1e12 };

/// Fewest rows per candidate: with fewer, a coefficient is mostly noise.
const ROWS_PER_CANDIDATE: usize = 5;

/// Maximum number of inputs of a predictor of the host.
const MOST_INPUTS: usize = 32;

/// A model of one output.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct SeriesModel {
    model: UnitModel,
    report: String,
    /// Mean of the fitted output.
    mean: f64,
    /// Column of the inputs for each quantity of the model.
    places: Vec<usize>,
    /// Length of the history, samples.
    depth: usize,
}

/// Settings of the search.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SeriesOptions {
    max_lag: u16,
    input_lags: u16,
    degree: usize,
    max_terms: usize,
    search: String,
    stop: String,
    centre: bool,
}

impl SeriesOptions {
    /// Candidates for this number of inputs: products of lagged outputs and inputs up to the degree.
    fn pool(&self, n_inputs: usize) -> Result<Candidates, String> {
        if !(1..=3).contains(&self.degree) {
            return Err(format!("degree is 1, 2 or 3, not {}", self.degree));
        }
        if n_inputs > MOST_INPUTS {
            return Err(format!(
                "{n_inputs} inputs that change; at most {MOST_INPUTS} can be run\nhelp: fewer inputs"
            ));
        }
        let mut pool = Candidates::builder().cross_products(self.degree);
        if self.max_lag > 0 {
            pool = pool.output(1..=self.max_lag, self.degree);
        }
        for index in 0..n_inputs {
            pool = pool.input(index as u8, 0..=self.input_lags, self.degree);
        }
        pool.build().map_err(|error| {
            format!("{error}\nhelp: a smaller `max_lag`, `input_lags` or `degree`, or fewer inputs")
        })
    }

    fn rule(&self) -> Result<StopRule, String> {
        let stop = self.stop.parse::<Stop>().map_err(|wrong| format!("stop: {wrong}"))?;
        Ok(StopRule { max_terms: self.max_terms, stop })
    }
}

/// A column minus its centre, divided by its scale.
struct Scaled {
    values: Vec<f64>,
    centre: f64,
    scale: f64,
}

impl Scaled {
    /// Scales by the standard deviation, about the mean or about zero.
    fn of(values: Vec<f64>, about_mean: bool) -> Self {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let scale = (squares / values.len() as f64).sqrt();
        let centre = if about_mean { mean } else { 0.0 };
        let values = values.into_iter().map(|value| (value - centre) / scale).collect();
        Self { values, centre, scale }
    }

    fn range(&self) -> Limits<f64> {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        Limits { low, high: self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max) }
    }
}

/// Ranges of rows with the same label.
fn stretches(labels: Option<&[f64]>, n_rows: usize) -> Vec<Range<usize>> {
    let Some(labels) = labels else { return std::iter::once(0..n_rows).collect() };
    let mut begin = 0;
    let parts = labels.chunk_by(|a, b| a == b).map(|part| {
        begin += part.len();
        begin - part.len()..begin
    });
    parts.collect()
}

/// Fits an output. `labels`: samples with different labels are never combined.
#[pyfunction]
pub(crate) fn fit_series(
    py: Python<'_>,
    output: PyReadonlyArray1<'_, f64>,
    inputs: PyReadonlyArray2<'_, f64>,
    labels: Option<PyReadonlyArray1<'_, f64>>,
    names: Vec<String>,
    options: SeriesOptions,
) -> PyResult<SeriesModel> {
    let (output, inputs) = (output.as_array().to_vec(), inputs.as_array());
    let labels = labels.map(|labels| labels.as_array().to_vec());
    let inputs: Vec<Vec<f64>> = inputs.columns().into_iter().map(|column| column.to_vec()).collect();
    let found = work::run(py, || search(output, inputs, labels.as_deref(), &names, &options))?;
    let (model, mean, report) = found.map_err(|wrong| py_error(py, "FitError", &wrong))?;
    SeriesModel::of(py, model, mean, report)
}

/// Returns the model, the mean of its output, and a report.
fn search(
    output: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    labels: Option<&[f64]>,
    names: &[String],
    options: &SeriesOptions,
) -> Result<(UnitModel, f64, String), String> {
    let (pool, rule) = (options.pool(inputs.len())?, options.rule()?);
    let (n_rows, needed) = (output.len(), (pool.len() + 1) * ROWS_PER_CANDIDATE);
    if n_rows < needed {
        return Err(format!(
            "{n_rows} samples; {needed} are needed for {} candidates\nhelp: more samples, a smaller `max_lag`, `input_lags` or `degree`, or fewer inputs",
            pool.len()
        ));
    }
    let mean = output.iter().sum::<f64>() / n_rows as f64;
    let output = Scaled::of(output, options.centre);
    let inputs: Vec<Scaled> = inputs.into_iter().map(|values| Scaled::of(values, options.centre)).collect();
    let mut signals = vec![output.values.as_slice()];
    signals.extend(inputs.iter().map(|input| input.values.as_slice()));
    let how: Search = options.search.parse().map_err(|wrong| format!("search: {wrong}"))?;
    let found =
        fit(&signals, &stretches(labels, n_rows), &pool, &rule, how).map_err(|error| error.to_string())?;
    let terms = found.refit.terms(&found.terms);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    // Converted back to the units of output and inputs.
    let report = terms.iter().map(|term| {
        let per = |factor: &fos_core::Factor| match factor.channel {
            Channel::Output => output.scale,
            Channel::Input(index) => inputs[usize::from(index)].scale,
        };
        let unit = output.scale / term.factors.iter().map(per).product::<f64>();
        json!({
            "monomial": monomial_text_named(&term.factors, OUTPUT, &names),
            "coefficient": term.coefficient * unit,
            "standard_error": term.standard_error.map(|error| error * unit),
        })
    });
    let text = |index: usize| monomial_text_named(&pool.monomials()[index], OUTPUT, &names);
    let stopped = match found.selection.stopped {
        Stopped::Noise { candidate, mse_reduction, needed } => format!(
            "the best candidate left, {}, reduces the MSE by {mse_reduction:.2e}; noise alone does so up to {needed:.2e}",
            text(candidate)
        ),
        Stopped::MaxTerms => "at the most terms allowed".to_owned(),
        Stopped::Rounding => "other terms reduce the MSE by less than its rounding error".to_owned(),
        Stopped::MostMoves => "after as many exchanges as are allowed".to_owned(),
        Stopped::Exact => "nothing is left".to_owned(),
        Stopped::NothingLeft => "every candidate is in".to_owned(),
    };
    let means = names.iter().copied().zip(&inputs).map(|(name, input)| (name, input.centre));
    let centres: Vec<(&str, f64)> = match options.centre {
        true => std::iter::once((OUTPUT, output.centre)).chain(means).collect(),
        false => Vec::new(),
    };
    let report = json!({
        "constant": found.refit.constant * output.scale + output.centre,
        "terms": report.collect::<Vec<_>>(),
        "centres": centres,
        "candidates": pool.len(),
        "rows": found.refit.rows,
        "stopped": stopped,
        "condition_number": found.refit.condition,
        "mse": found.refit.mse * output.scale * output.scale,
    });
    Ok((model_of(&output, &inputs, found.refit.constant, terms), mean, report.to_string()))
}

/// Converts the result into a model of fos-core.
fn model_of(output: &Scaled, inputs: &[Scaled], constant: f64, terms: Vec<FittedTerm>) -> UnitModel {
    let named = inputs.iter().enumerate().map(|(index, input)| NamedInput {
        name: index.to_string(),
        input: Input {
            source: Source::Quantity(index as u8),
            transform: Transform::Identity,
            centre: input.centre,
            scale: input.scale,
            source_range: ANY,
            range: ANY,
        },
    });
    let quantities = (0..inputs.len())
        .map(|index| LoggedQuantity { column: index.to_string(), quantity: Quantity::Other });
    let parameters = AxisParameters {
        axis: Axis::Other,
        reference: 0.0,
        offset: output.centre,
        scale: output.scale,
        constant,
        range: output.range(),
        physical_range: Limits::unlimited(),
        full_scale: 0.0,
        // A series may stand still.
        stuck_after_repeats: 0,
        gap_limit_samples: 1,
        coast_limit_s: FOR_EVER_S,
        innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
    };
    let mut model = UnitModel {
        period_s: PERIOD_S,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: quantities.collect(),
        inputs: named.collect(),
        axes: vec![FittedAxis {
            column: OUTPUT.to_owned(),
            parameters,
            physical: Vec::new(),
            stochastic: terms,
            plain: None,
        }],
    };
    model.drop_unused();
    model
}

impl SeriesModel {
    fn of(py: Python<'_>, model: UnitModel, mean: f64, report: String) -> PyResult<Self> {
        let places: Option<Vec<usize>> =
            model.quantities.iter().map(|logged| logged.column.parse().ok()).collect();
        let (Some(places), [axis]) = (places, &model.axes[..]) else {
            return Err(py_error(py, "RegressorError", "not the model of a regressor"));
        };
        let factors = axis.stochastic.iter().flat_map(|term| &term.factors);
        let depth = factors.map(|factor| usize::from(factor.lag)).max().unwrap_or(0);
        Ok(Self { depth, places, mean, report, model })
    }

    fn predictor(&self, py: Python<'_>) -> PyResult<HostPredictor<f64>> {
        let predictor = self.model.predictor();
        predictor.map_err(|error| {
            py_error(
                py,
                "FitError",
                &format!("the model cannot be run: {error}\nhelp: a smaller `max_lag` or `max_terms`"),
            )
        })
    }

    /// Quantities of every row.
    fn quantities(&self, py: Python<'_>, inputs: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
        let inputs = inputs.as_array();
        if self.places.iter().any(|place| *place >= inputs.ncols()) {
            return Err(py_error(py, "RegressorError", "an input that the model needs is missing"));
        }
        let row = |row| self.places.iter().map(|place| inputs[[row, *place]]).collect();
        Ok((0..inputs.nrows()).map(row).collect())
    }

    /// Prediction; the mean until the history is full.
    fn predicted(&self, correction: &Correction<f64>) -> f64 {
        match correction.validity.intersects(Validity::WARMING_UP) {
            true => self.mean,
            false => correction.predicted,
        }
    }
}

#[pymethods]
impl SeriesModel {
    /// Restores a saved model: model, mean of its output, report.
    #[staticmethod]
    fn from_json(py: Python<'_>, model: &str, mean: f64, report: String) -> PyResult<Self> {
        let model: UnitModel = serde_json::from_str(model)
            .map_err(|error| py_error(py, "RegressorError", &format!("not a model: {error}")))?;
        Self::of(py, model, mean, report)
    }

    /// Returns the model, the mean of its output, and a report.
    fn to_json(&self) -> (String, f64, &str) {
        (json!(self.model).to_string(), self.mean, &self.report)
    }

    /// Number of samples before predictions differ from the mean.
    #[getter]
    fn depth(&self) -> usize {
        self.depth
    }

    /// Prediction one step ahead in every row, from the measured rows before it; the history is cleared at
    /// `starts`.
    fn one_step<'py>(
        &self,
        py: Python<'py>,
        output: PyReadonlyArray1<'py, f64>,
        inputs: PyReadonlyArray2<'py, f64>,
        starts: Vec<bool>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut predictor = self.predictor(py)?;
        let quantities = self.quantities(py, &inputs)?;
        let output: Vec<f64> = output.as_array().to_vec();
        let predicted = work::run(py, || {
            let rows = output.iter().zip(&quantities).zip(starts);
            let step = |((output, quantities), starts): ((&f64, &Vec<f64>), bool)| {
                if starts {
                    let _ = predictor.skip(FAR);
                }
                self.predicted(&predictor.track(&Sample { measured: &[*output], quantities })[0])
            };
            rows.map(step).collect::<Vec<f64>>()
        })?;
        Ok(PyArray1::from_vec(py, predicted))
    }

    /// Free run for the rows of `inputs` after those of `history`, which are measured. Without a history it begins
    /// at rest: the output at its mean, the inputs as in the first row.
    fn free_run<'py>(
        &self,
        py: Python<'py>,
        history: PyReadonlyArray1<'py, f64>,
        inputs: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut predictor = self.predictor(py)?;
        let quantities = self.quantities(py, &inputs)?;
        let history: Vec<f64> = history.as_array().to_vec();
        let predicted = work::run(py, || {
            if let (true, Some(first)) = (history.is_empty(), quantities.first()) {
                for _ in 0..self.depth {
                    let _ = predictor.track(&Sample { measured: &[self.mean], quantities: first });
                }
            }
            for (output, quantities) in history.iter().zip(&quantities) {
                let _ = predictor.track(&Sample { measured: &[*output], quantities });
            }
            let after = quantities.get(history.len()..).unwrap_or_default();
            let ahead = after.iter().map(|quantities| self.predicted(&predictor.forecast(quantities)[0]));
            ahead.collect::<Vec<f64>>()
        })?;
        Ok(PyArray1::from_vec(py, predicted))
    }
}
