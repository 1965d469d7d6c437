//! A model of any output by its own past and any inputs: what the regressor is made of.

use fos_core::{Channel, Sample, Source, Transform};
use fos_data::recording::LoadOptions;
use fos_fit::candidates::monomial_text_named;
use fos_fit::fit::{AxisFit, FitOptions, InputSpec, Train, fit_axis, rest};
use fos_fit::model::{FittedTerm, HostPredictor, UnitModel};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::{raised, said};
use crate::options::Given;
use crate::recording::of_columns;
use crate::work;

/// What the column of the output is called.
const OUTPUT: &str = "y";

/// A coast that never ends: that an own history is trusted no longer than it was validated for is for sensors.
const FOR_EVER_S: f64 = 1e9;

/// Ticks that no history survives.
const FAR: u32 = u32::MAX;

/// A model of one output.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct SeriesModel {
    model: UnitModel,
    report: String,
    /// Which column of the inputs each quantity of the model is.
    places: Vec<usize>,
    /// Samples that a history needs.
    depth: usize,
}

fn input_name(index: usize) -> String {
    format!("x{index}")
}

/// Fits an output. `labels`: samples of different labels are never used together.
#[pyfunction]
pub(crate) fn fit_series(
    py: Python<'_>,
    output: PyReadonlyArray1<'_, f64>,
    inputs: PyReadonlyArray2<'_, f64>,
    labels: Option<PyReadonlyArray1<'_, f64>>,
    names: Vec<String>,
    options: Given,
    rate_hz: f64,
) -> PyResult<SeriesModel> {
    let inputs = inputs.as_array();
    let used: Vec<usize> = (0..inputs.ncols()).collect();
    let specs = used
        .iter()
        .map(|index| InputSpec { column: Some(input_name(*index)), transform: Transform::Identity });
    let options = FitOptions { inputs: specs.collect(), train: Train::Share(1.0), ..options.options(py)? };
    let output = output.as_array();
    let n_rows = output.len();
    let mut columns = vec![
        (OUTPUT.to_owned(), output.to_vec()),
        // all of it is to be learnt from
        ("still".to_owned(), vec![1.0; n_rows]),
    ];
    columns.extend(used.iter().map(|index| (input_name(*index), inputs.column(*index).to_vec())));
    columns.extend(labels.map(|labels| ("segment".to_owned(), labels.as_array().to_vec())));
    let read = LoadOptions { rate_hz: Some(rate_hz), keep_moved: true, ..LoadOptions::default() };
    let log = of_columns("a series", columns, &read).map_err(raised(py))?;
    let fit = work::run(py, || fit_axis(&log, &rest(&log, options.train), OUTPUT, &options))?;
    let AxisFit { mut model, report } = fit.map_err(raised(py))?;
    let parameters = &mut model.axes[0].parameters;
    parameters.coast_limit_s = FOR_EVER_S;
    // a series may well stand still
    parameters.stuck_after_repeats = 0;
    let text = |term: &FittedTerm| {
        let inputs: Vec<&str> = model.inputs.iter().map(|named| said_name(&named.name, &names)).collect();
        json!({
            "monomial": monomial_text_named(&term.factors, OUTPUT, &inputs),
            "coefficient": term.coefficient,
            "standard_error": term.standard_error,
        })
    };
    let axis = &model.axes[0];
    let inputs: Vec<_> = model
        .inputs
        .iter()
        .map(|named| json!([said_name(&named.name, &names), named.input.centre, named.input.scale]))
        .collect();
    let report = json!({
        "offset": axis.parameters.offset + axis.parameters.reference,
        "scale": axis.parameters.scale,
        "constant": axis.parameters.constant,
        "terms": axis.stochastic.iter().map(text).collect::<Vec<_>>(),
        "inputs": inputs,
        "candidates": report.candidates,
        "rows": report.rows,
        "left_out": report.spikes,
        "stopped": report.stopped,
        "condition_number": report.condition_number,
        "mse": report.mse,
    });
    SeriesModel::of(py, model, report.to_string())
}

/// `x3` as its user calls it, other names as they are.
fn said_name<'a>(name: &'a str, names: &'a [String]) -> &'a str {
    let index = name.strip_prefix('x').and_then(|index| index.parse::<usize>().ok());
    index.and_then(|index| names.get(index)).map_or(name, String::as_str)
}

impl SeriesModel {
    fn of(py: Python<'_>, model: UnitModel, report: String) -> PyResult<Self> {
        let places = model.quantities.iter().map(|logged| logged.column.strip_prefix('x')?.parse().ok());
        let places: Option<Vec<usize>> = places.collect();
        let wrong = || said(py, "RegressorError", "not the model of a regressor");
        let (Some(places), [axis]) = (places, &model.axes[..]) else { return Err(wrong()) };
        let factors = axis.stochastic.iter().flat_map(|term| &term.factors);
        let is_memory = |input: u8| {
            let input = model.inputs.get(usize::from(input));
            input.is_some_and(|named| matches!(named.input.source, Source::Remainder(_)))
        };
        // what remembers the output needs one sample of it
        let depth = factors.map(|factor| match factor.channel {
            Channel::Output => usize::from(factor.lag),
            Channel::Input(input) => usize::from(factor.lag) + usize::from(is_memory(input)),
        });
        Ok(Self { depth: depth.max().unwrap_or(0), places, report, model })
    }

    fn predictor(&self, py: Python<'_>) -> PyResult<HostPredictor<f64>> {
        let predictor = self.model.predictor();
        predictor.map_err(|error| said(py, "RegressorError", &format!("the model cannot be run: {error}")))
    }

    /// The quantities of every row.
    fn quantities(&self, py: Python<'_>, inputs: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
        let inputs = inputs.as_array();
        if self.places.iter().any(|place| *place >= inputs.ncols()) {
            return Err(said(py, "RegressorError", "an input that the model needs is missing"));
        }
        let row = |row| self.places.iter().map(|place| inputs[[row, *place]]).collect();
        Ok((0..inputs.nrows()).map(row).collect())
    }
}

#[pymethods]
impl SeriesModel {
    /// A model that was kept, and what was said of it.
    #[staticmethod]
    fn from_json(py: Python<'_>, model: &str, report: String) -> PyResult<Self> {
        let model: UnitModel = serde_json::from_str(model)
            .map_err(|error| said(py, "RegressorError", &format!("not a model: {error}")))?;
        Self::of(py, model, report)
    }

    /// The model, and what there is to say of it.
    fn to_json(&self) -> (String, &str) {
        (json!(self.model).to_string(), &self.report)
    }

    /// Samples that a history needs before the model says more than its mean.
    #[getter]
    fn depth(&self) -> usize {
        self.depth
    }

    /// One step ahead in every row, from the measured rows before it; the history begins anew where a label changes.
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
                predictor.track(&Sample { measured: &[*output], quantities })[0].predicted
            };
            rows.map(step).collect::<Vec<f64>>()
        })?;
        Ok(PyArray1::from_vec(py, predicted))
    }

    /// From its own history: the rows of `inputs` behind those of `history`, which are measured. With no history it
    /// begins at rest: the output at its mean, the inputs as they are in the first row.
    fn free_run<'py>(
        &self,
        py: Python<'py>,
        history: PyReadonlyArray1<'py, f64>,
        inputs: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut predictor = self.predictor(py)?;
        let quantities = self.quantities(py, &inputs)?;
        let history: Vec<f64> = history.as_array().to_vec();
        let mean = self.model.axes[0].parameters.offset + self.model.axes[0].parameters.reference;
        let predicted = work::run(py, || {
            if let (true, Some(first)) = (history.is_empty(), quantities.first()) {
                for _ in 0..self.depth {
                    let _ = predictor.track(&Sample { measured: &[mean], quantities: first });
                }
            }
            for (output, quantities) in history.iter().zip(&quantities) {
                let _ = predictor.track(&Sample { measured: &[*output], quantities });
            }
            let after = quantities.get(history.len()..).unwrap_or_default();
            after.iter().map(|quantities| predictor.forecast(quantities)[0].predicted).collect::<Vec<f64>>()
        })?;
        Ok(PyArray1::from_vec(py, predicted))
    }
}
