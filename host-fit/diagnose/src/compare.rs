//! Comparison of a model with the measurements and with simpler rivals.

use fos_data::column::{ACCELEROMETERS, Column, GYROS};
use std::borrow::Cow;
use std::ops::Range;

use serde::{Deserialize, Serialize, Serializer};

use crate::cautions::cautions;
use crate::dependence::{Dependence, Trained, dependence};
use crate::physical::{InFittedPose, PhysicalError, in_fitted_pose};
use crate::rms::{RmsTwins, WithRms};
use crate::study::{Data, SCHEMA, Study, StudyStep, Tool};
use fos_data::interrupt::in_parallel;
use fos_data::recording::{LoadOptions, Recording, RecordingError};
use fos_data::stillness::{self, Stillness};
use fos_fit::evaluate::{
    Coasted, MODEL, ModelErrors, Rival, Stretch, Trace, UnaidedError, before_and_after, rival,
    strapdown_errors, trace_of, worst_stretches,
};
use fos_fit::fit::{AxisFit, FitOptions};
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;
use fos_fit::signal::noise_floor::{NoiseFloor, noise_floor};

/// Error of a comparison.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error("the model cannot be run: {0}")]
    Model(#[from] fos_core::ModelError),
    #[error(transparent)]
    Physical(#[from] PhysicalError),
    #[error(
        "no row at rest remains for the evaluation: all {trained} were fitted\nhelp: use a smaller `train`, or a longer log"
    )]
    NothingLeft { trained: usize },
}

/// Comparison of a model with the measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Timestamps of the first and last evaluation row, s.
    pub evaluated_s: (f64, f64),
    /// The axes of the model.
    #[serde(serialize_with = "with_rms")]
    pub axes: Vec<AxisComparison>,
    /// Heading and position errors without aiding through a strapdown of the six axes, by length of the windows: with the
    /// constant bias learnt in training alone, and with the model. Empty unless the model has all six axes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strapdown: Vec<[UnaidedError; 2]>,
}

/// Comparison of one axis with the measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AxisComparison {
    /// Name in the log format, as `gx_rads`.
    pub column: String,
    /// Unit of the column; squared errors are in its square.
    pub unit: String,
    /// Number of evaluation rows at rest.
    pub rows: usize,
    /// Lowest mean square error of any causal predictor, in the square of the unit, with its 95 % interval.
    pub noise_floor: Option<(f64, (f64, f64))>,
    /// Reasons to distrust these numbers.
    pub cautions: Vec<String>,
    /// Errors of the rivals, then of the model.
    pub errors: Vec<ModelErrors>,
    /// Stretches with an outstanding slow error, worst first: at most five, possibly none.
    pub worst: Vec<Stretch>,
    /// Dependence of the residual on all logged columns; absent if there are too few data.
    pub dependence: Option<Dependence>,
}

/// Largest memory for two traces at a time, bytes; beyond, there is one.
const TWO_TRACES: usize = 400 << 20;

/// A model and its simpler rivals, evaluated on rows of a log.
struct Evaluated {
    /// Noise floor of each axis.
    floors: Vec<Option<NoiseFloor>>,
    /// Errors of each axis: of the rivals, then of the model.
    errors: Vec<Vec<ModelErrors>>,
    /// Errors of a strapdown: with the constant bias, and with the model.
    strapdown: Vec<[UnaidedError; 2]>,
    /// Trace of the model.
    trace: Trace,
}

/// Evaluates `model` and its rivals on `rows` of a log in which the orientation is known.
fn evaluate(
    model: &UnitModel,
    lag_1: &[f64],
    recording: &Recording,
    stillness: &Stillness,
    rows: Range<usize>,
    with_strapdown: bool,
    progress: &mut dyn FnMut(&str),
) -> Result<Evaluated, CompareError> {
    let playback = Playback::new(recording, model, &stillness.still)?;
    if !rows.clone().any(|row| playback.is_still(row)) {
        return Err(CompareError::NothingLeft { trained: rows.start });
    }
    let n_axes = model.axes.len();
    let floors: Vec<Option<NoiseFloor>> = in_parallel(0..n_axes, |axis| {
        let errors = playback.errors_at_rest(axis, rows.clone());
        noise_floor(&errors.iter().map(Vec::as_slice).collect::<Vec<_>>())
    });
    let traced = |(name, model): &(&str, Cow<'_, UnitModel>)| -> Result<_, CompareError> {
        let is_integrated = with_strapdown && [Rival::Mean.name(), MODEL].contains(name);
        let coasted = if is_integrated { Coasted::AllRowsAndStrapdown } else { Coasted::AllRows };
        let trace = trace_of(model, &playback, rows.clone(), coasted)?;
        let errors = in_parallel(0..n_axes, |axis| {
            ModelErrors::of(&trace, axis, name, &model.axes[axis].column, floors[axis].as_ref())
        });
        let strapdown = strapdown_errors(&trace);
        Ok((errors, strapdown, (*name == MODEL).then_some(trace)))
    };
    let rivals = Rival::ALL.map(|kind| (kind.name(), Cow::Owned(rival(model, kind, lag_1))));
    let models: Vec<_> = rivals.into_iter().chain([(MODEL, Cow::Borrowed(model))]).collect();
    // not on all cores: the memory would depend on their number
    let at_once = if 2 * Trace::bytes(rows.len(), n_axes) <= TWO_TRACES { 2 } else { 1 };
    let mut errors: Vec<Vec<ModelErrors>> = vec![Vec::new(); n_axes];
    let (mut ends_of_mean, mut own) = (Vec::new(), None);
    for models in models.chunks(at_once) {
        models.iter().for_each(|(name, _)| progress(name));
        for ((name, _), evaluated) in models.iter().zip(in_parallel(models, traced)) {
            let (of_axes, ends, trace) = evaluated?;
            errors.iter_mut().zip(of_axes).for_each(|(errors, of_axis)| errors.push(of_axis));
            match trace {
                Some(trace) => own = Some((trace, ends)),
                None if *name == Rival::Mean.name() => ends_of_mean = ends,
                None => {}
            }
        }
    }
    let (trace, ends) = own.expect("the model is one of them");
    let strapdown = ends_of_mean.into_iter().zip(ends).map(|(before, after)| [before, after]).collect();
    Ok(Evaluated { floors, errors, strapdown, trace })
}

/// Evaluates `model` and its rivals on `rows`; also returns the trace of the model, for the figures. `lag_1` is the
/// lag-1 autocorrelation of each axis' training data. The noise is estimated from `trained`, the data that the model
/// was fitted to, if they are available.
pub fn compare(
    model: &UnitModel,
    lag_1: &[f64],
    recording: &Recording,
    stillness: &Stillness,
    rows: Range<usize>,
    trained: Option<&Trained<'_>>,
    progress: &mut dyn FnMut(&str),
) -> Result<(Comparison, Trace), CompareError> {
    let is_same = trained.is_some_and(|trained| std::ptr::eq(trained.recording, recording));
    let InFittedPose { log: recording, turned } = in_fitted_pose(model, recording, stillness)?;
    let other = trained.filter(|_| !is_same);
    let other =
        other.map(|trained| in_fitted_pose(model, trained.recording, trained.stillness)).transpose()?;
    let trained = trained.map(|trained| Trained {
        recording: other.as_ref().map_or(&*recording, |other| &*other.log),
        ..trained.clone()
    });
    let Evaluated { floors, errors, strapdown, mut trace } =
        evaluate(model, lag_1, &recording, stillness, rows.clone(), true, progress)?;
    for axis in &mut trace.axes {
        // in the comparison already; no figure needs them
        axis.horizons = Default::default();
    }
    let dependences = dependence(model, &recording, stillness, rows.clone(), trained.as_ref())?;
    let worst = in_parallel(0..model.axes.len(), |axis| {
        worst_stretches(&trace, axis, &model.axes[axis].column, &recording)
    });
    let axes = model
        .axes
        .iter()
        .zip(&trace.axes)
        .zip(floors)
        .zip(errors)
        .zip(dependences.into_iter().zip(worst))
        .map(|((((fitted, left), floor), errors), (dependence, worst))| AxisComparison {
            column: fitted.column.clone(),
            unit: Column::named(&fitted.column).unit().label().to_owned(),
            rows: left.measured.iter().filter(|value| value.is_finite()).count(),
            noise_floor: floor.as_ref().map(|floor| (floor.variance, floor.interval)),
            cautions: cautions(floor.as_ref(), turned.contains(&fitted.column), dependence.as_ref(), &errors),
            errors,
            worst,
            dependence,
        })
        .collect();
    let evaluated_s = (recording.time_s[rows.start], recording.time_s[rows.end - 1]);
    Ok((Comparison { evaluated_s, axes, strapdown }, trace))
}

/// Evaluation of a study on a log, with the data behind it.
#[derive(Debug)]
pub struct Evaluation {
    /// Errors of the model and its rivals, worst stretches, dependences.
    pub comparison: Comparison,
    /// Trace of the model, for the figures.
    pub trace: Trace,
    /// Rows at rest.
    pub stillness: Stillness,
}

/// Evaluates these axes of the model of a study on `log`; see [`compare_on`].
pub fn compare_study(
    study: &Study,
    columns: &[String],
    log: &Recording,
    own: Option<&Recording>,
    progress: &mut dyn FnMut(&str),
) -> Result<Evaluation, CompareError> {
    let axes = &study.model.axes;
    let mut indices: Vec<usize> =
        (0..axes.len()).filter(|index| columns.contains(&axes[*index].column)).collect();
    // an axis without a value in this log must not prevent the evaluation of the others
    let is_measured = |index: &usize| !log.quality.empty_axes.contains(&axes[*index].column);
    if indices.iter().any(is_measured) {
        indices.retain(is_measured);
    }
    let all_lag_1 = study.lag_1();
    let lag_1: Vec<f64> = indices.iter().map(|index| all_lag_1[*index]).collect();
    let model = study.model.of_axes(indices).unwrap_or_else(|| study.model.clone());
    compare_on(&study.data, &model, &lag_1, log, own, progress)
}

/// Evaluates `model`, fitted to `data`, on `log`: on the rows that were not fitted if it is the log of `data`, else on
/// all rows. If the log that was fitted is another one and available as `own`, the noise is estimated from it, and a
/// `log` that continues it starts with its lags and hysteresis.
pub fn compare_on(
    data: &Data,
    model: &UnitModel,
    lag_1: &[f64],
    log: &Recording,
    own: Option<&Recording>,
    progress: &mut dyn FnMut(&str),
) -> Result<Evaluation, CompareError> {
    let OnLog { log: evaluated, own, has_fitted_rows, stillness, rows, lead_in } = OnLog::of(data, log, own);
    let trained_rows = 0..data.trained_rows;
    let other = own.map(|own| (stillness::find_apart(own, data.trained_rows), own));
    let trained = match &other {
        Some((stillness, recording)) => Some(Trained { recording, stillness, rows: trained_rows }),
        None => has_fitted_rows.then_some(Trained {
            recording: &evaluated,
            stillness: &stillness,
            rows: trained_rows,
        }),
    };
    let (comparison, trace) =
        compare(model, lag_1, &evaluated, &stillness, rows, trained.as_ref(), progress)?;
    let stillness = if lead_in > 0 { stillness::find(log) } else { stillness };
    Ok(Evaluation { comparison, trace: trace.without_lead_in(lead_in), stillness })
}

/// Returns [`Comparison::strapdown`] of [`compare_study`], without the comparison of the axes one by one; empty unless the
/// study and the log have all six axes.
pub fn strapdown(
    study: &Study,
    log: &Recording,
    own: Option<&Recording>,
) -> Result<Vec<[UnaidedError; 2]>, CompareError> {
    let columns = study.columns();
    let is_measured = |axis: &&str| {
        let is = |column: &String| column == axis;
        columns.iter().any(is) && log.axis(axis).is_ok() && !log.quality.empty_axes.iter().any(is)
    };
    if !ACCELEROMETERS.iter().chain(&GYROS).all(is_measured) {
        return Ok(Vec::new());
    }
    let model = &study.model;
    let OnLog { log, stillness, rows, .. } = OnLog::of(&study.data, log, own);
    let posed = in_fitted_pose(model, &log, &stillness)?.log;
    let playback = Playback::new(&posed, model, &stillness.still)?;
    let errors = |model: &UnitModel| {
        trace_of(model, &playback, rows.clone(), Coasted::Strapdown).map(|trace| strapdown_errors(&trace))
    };
    let mean = rival(model, Rival::Mean, &study.lag_1());
    let (before, after) = (errors(&mean)?, errors(model)?);
    Ok(before.into_iter().zip(after).map(|(before, after)| [before, after]).collect())
}

/// A log with the rows that a model is evaluated on.
struct OnLog<'l> {
    /// The log, after the log of the fit if it continues that.
    log: Cow<'l, Recording>,
    /// Log of the fit, if it is another one.
    own: Option<&'l Recording>,
    /// True if `log` begins with the rows that were fitted.
    has_fitted_rows: bool,
    stillness: Stillness,
    rows: Range<usize>,
    /// Number of rows before those of the log itself.
    lead_in: usize,
}

impl<'l> OnLog<'l> {
    /// See [`compare_on`].
    fn of(data: &Data, log: &'l Recording, own: Option<&'l Recording>) -> Self {
        let is_own = data.is(log);
        let own = own.filter(|own| !is_own && data.is(own));
        let (evaluated, lead_in) = own.map_or((Cow::Borrowed(log), 0), |own| log.led_in_by(own));
        let has_fitted_rows = is_own || lead_in > 0;
        let stillness =
            stillness::find_apart(&evaluated, if has_fitted_rows { data.trained_rows } else { 0 });
        let rows = if is_own { data.trained_rows } else { lead_in }..evaluated.n_rows();
        Self {
            log: evaluated,
            own: own.filter(|_| !has_fitted_rows),
            has_fitted_rows,
            stillness,
            rows,
            lead_in,
        }
    }
}

/// Relative time error of a model's lags on a log with another sampling rate; `None` up to 0.5 %.
pub fn lags_off(model: &UnitModel, log: &Recording) -> Option<f64> {
    let off = model.period_s / log.rate.period_s - 1.0;
    (off.abs() > 0.005).then_some(off)
}

/// Combines fitted axes into a study, evaluated on the rows after the training part.
pub fn study_of(
    recording: &Recording,
    stillness: &Stillness,
    fits: Vec<AxisFit>,
    settings: FitOptions,
    read: LoadOptions,
    progress: &mut dyn FnMut(&str),
) -> Result<Study, CompareError> {
    let trained_rows = fos_fit::fit::training_rows(recording, settings.train).end;
    let (mut models, reports): (Vec<UnitModel>, Vec<_>) =
        fits.into_iter().map(|fit| (fit.model.into(), fit.report)).unzip();
    let mut model = models.remove(0);
    models.into_iter().for_each(|other| model.absorb(other));
    let lag_1: Vec<f64> = reports.iter().map(|report| report.lag_1).collect();
    let rows = trained_rows..recording.n_rows();
    let posed = in_fitted_pose(&model, recording, stillness)?.log;
    let evaluation = evaluate(&model, &lag_1, &posed, stillness, rows, false, progress)?;
    let still = stillness.still.iter().filter(|still| **still).count();
    Ok(Study {
        schema: SCHEMA.to_owned(),
        tool: Tool::this(),
        data: Data {
            sources: recording.sources.clone(),
            read: read.clone(),
            rows: recording.n_rows(),
            trained_rows,
            true_rate_hz: recording.rate.true_hz,
            segments: recording.segments.len(),
            still_known_by: stillness.known_by,
            still_share: still as f64 / recording.n_rows() as f64,
        },
        settings,
        model,
        axes: reports,
        steps: steps_of(&evaluation.errors),
        refinements: Vec::new(),
    })
}

/// Converts the errors of the rivals and the model into the steps of a study.
fn steps_of(errors: &[Vec<ModelErrors>]) -> Vec<StudyStep> {
    let n_models = errors.first().map_or(0, Vec::len);
    (0..n_models)
        .map(|step| StudyStep {
            name: errors[0][step].model.clone(),
            errors: errors.iter().map(|of_axis| of_axis[step].clone()).collect(),
        })
        .collect()
}

impl Study {
    /// Returns the lag-1 autocorrelation of each axis' training data, the parameter of the Gauss-Markov rival.
    pub fn lag_1(&self) -> Vec<f64> {
        self.axes.iter().map(|report| report.lag_1).collect()
    }
}

/// Serialises axes with the RMS of the slow error in a free run, of the constant mean and of the model.
fn with_rms<S: Serializer>(axes: &[AxisComparison], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(axes.iter().map(|axis| {
        let [before, after] = axis.slow_errors();
        let twins = RmsTwins {
            rms_before: before,
            rms_after: after,
            rms_reduction: before
                .zip(after)
                .filter(|(before, _)| *before > 0.0)
                .map(|(before, after)| 1.0 - after / before),
            ..RmsTwins::default()
        };
        WithRms { of: axis, twins }
    }))
}

impl AxisComparison {
    /// Returns the RMS of the slow error in a free run, in the unit of the axis: of the constant mean, and of the
    /// model.
    pub fn slow_errors(&self) -> [Option<f64>; 2] {
        before_and_after(&self.errors)
            .map(|errors| errors.and_then(|errors| errors.slow_error_coast).map(f64::sqrt))
    }

    /// Heading or position errors without aiding, by length of the windows: with the constant bias learnt in training
    /// alone, and with the model.
    pub fn unaided(&self) -> Vec<[UnaidedError; 2]> {
        let [Some(before), Some(after)] = before_and_after(&self.errors) else { return Vec::new() };
        before.unaided.iter().zip(&after.unaided).map(|(before, after)| [*before, *after]).collect()
    }
}
