//! Fits one axis: offset and scale, the physical part, then the stochastic part by Fast Orthogonal Search.

use fos_data::column::Column;
use std::borrow::Cow;
use std::ops::Range;

use fos_core::{
    Axis, AxisParameters, FittedOn, InnovationStatistics, Input, ModelError, Range as Fitted, Source,
    Transform,
};

use super::axis_error::AxisError;
use super::axis_report::{AxisReport, LeftOut};
use super::options::{FitOptions, InputSpec, Train};
use super::physical;
use super::physical_range::{Part, physical_range};
use super::poses::Poses;
use super::regressors::Regressors;
use super::stochastic;
use crate::evaluate::{self, Coasted, Trace};
use crate::model::{FittedAxis, LoggedQuantity, NamedInput, Plain, UnitModel};
use crate::playback::Playback;
use crate::signal::{self, autocorrelation::autocorrelation};
use crate::single_axis::SingleAxisModel;
use fos_data::interrupt::in_parallel;
use fos_data::recording::{ErrorSeries, Recording, RecordingError, Reference};
use fos_data::stillness::{self, Stillness};

/// Wide enough for any scaled value until the ranges are known.
const ANY: Fitted<f64> = Fitted { low: -1e12, high: 1e12 };

/// Distance from the mean, in standard deviations, at which logged quantities are clamped before the transform.
const SOURCE_LIMIT: f64 = 100.0;

/// Longest coast over missing samples, s; after it the lags carry little information.
const GAP_LIMIT_S: f64 = 0.1;

/// Multiple of the longest repetition of a value in the fitted rows from which on the sensor counts as stuck.
const STUCK_RATIO: usize = 4;
const STUCK_AT_LEAST: usize = 20;

/// Widths of the error's range in the fitted rows by which a prediction for these rows may leave it, the same as the
/// evaluator's margin for inputs.
const LARGEST_EXCURSION: f64 = 1.0;

/// Validated coast if not even the shortest horizon is better than the mean, s.
const SHORTEST_COAST_S: f64 = 1.0;

/// A fitted axis: a model of that axis alone, and the report of the fit.
#[derive(Debug, Clone)]
pub struct AxisFit {
    pub model: SingleAxisModel,
    pub report: AxisReport,
}

/// Returns the first rows of the recording, by share or by time, at rest or not.
pub fn training_rows(recording: &Recording, train: Train) -> Range<usize> {
    let end = match train {
        Train::Share(share) => (share * recording.n_rows() as f64).round() as usize,
        Train::Seconds(seconds) => {
            let ticks = (seconds / recording.rate.period_s).round() as u64;
            let rows = recording.segments.iter().map(|segment| {
                let left = ticks.saturating_sub(segment.tick);
                segment.rows.len().min(usize::try_from(left).unwrap_or(usize::MAX))
            });
            rows.sum()
        }
    };
    0..end.min(recording.n_rows())
}

/// Returns the rows at rest of a log for fitting; in the training part they are detected from that part alone.
pub fn rest(recording: &Recording, train: Train) -> Stillness {
    stillness::find_apart(recording, training_rows(recording, train).end)
}

/// Fits `axis` (`gx`, or a column) of `recording`; `stillness` is [`rest`] or further information about the log.
pub fn fit_axis(
    recording: &Recording,
    stillness: &Stillness,
    axis: &str,
    options: &FitOptions,
) -> Result<AxisFit, AxisError> {
    let column = recording.axis(axis)?.name.clone();
    let model_error = |source| AxisError::Model { column: column.clone(), source };
    let training = training_rows(recording, options.train);
    stillness.check_rest(recording, &training)?;
    let fitted: Vec<bool> =
        stillness.still.iter().enumerate().map(|(row, still)| *still && training.contains(&row)).collect();
    if let Some((value, _)) = recording.stuck_axis(&column, &fitted) {
        return Err(AxisError::Constant { column, value });
    }
    let (cleaned, spikes) = recording.without_outliers(&column, training.clone(), &stillness.still);
    let poses = Poses::of(&cleaned, stillness, &column, &training)?;
    // until the physical part is known, an orientation counts as one level
    let levelled = poses.in_first(&cleaned, &vec![0.0; cleaned.n_rows()]);
    let mut recording = levelled.map_or(cleaned, Cow::Owned);
    let ErrorSeries { values, reference, .. } = recording.error_series(&column)?;
    let known: Vec<f64> = training
        .clone()
        .filter(|row| stillness.still[*row])
        .map(|row| values[row])
        .filter(|value| value.is_finite())
        .collect();
    drop(values);
    if known.len() < 2 {
        return Err(AxisError::TooShort {
            column,
            rows: known.len(),
            needed: 2,
            candidates: 0,
            fits: String::new(),
        });
    }
    let mut model = start(&recording, stillness, (&column, &reference), &training, &known, options)?;
    let regressors_of = |model: &SingleAxisModel, recording: &Recording| -> Result<Regressors, AxisError> {
        let playback = Playback::new(recording, model, &stillness.still)?;
        Regressors::of(model, &playback, training.end).map_err(model_error)
    };
    let mut regressors = regressors_of(&model, &recording)?;
    model.axis_mut().plain = Some(Plain::of(&known, &regressors.known_remainder()));
    drop(known);
    let mut left_out = Vec::new();
    if !options.physical.is_empty() {
        left_out =
            fit_physical(&mut model, options.physical.len(), &regressors, &poses.columns(&recording)?)?;
        regressors = regressors_of(&model, &recording)?;
        let explained = explained(&model, &recording, &regressors)?;
        if let Some(levelled) = poses.in_first(&recording, &explained) {
            recording = Cow::Owned(levelled);
            regressors = regressors_of(&model, &recording)?;
        }
        if options.offset.is_none() {
            subtract_mean(&mut model.axis_mut().parameters, &mut regressors, &reference);
        }
    }
    let part = stochastic::fit(&model, &regressors, options)?;
    model.axis_mut().parameters.constant = part.constant;
    model.axis_mut().stochastic = part.terms;
    let report = AxisReport {
        reference_column: match reference {
            Reference::Constant => None,
            Reference::Channel(name) => Some(name),
        },
        left_out,
        spikes,
        poses: poses.fitted(),
        ..part.report
    };
    set_ranges(&mut model, &regressors);
    model.drop_unused();
    // every axis may be here at the same time, and a trace is as large
    drop(regressors);
    let playback = Playback::new(&recording, &model, &stillness.still)?;
    let trace = set_statistics(&mut model, &playback, training).map_err(model_error)?;
    refuse_divergent(&column, &trace)?;
    Ok(AxisFit { model, report })
}

/// Fits several axes of a recording in parallel; `done` is called after each.
pub fn fit_axes(
    recording: &Recording,
    stillness: &Stillness,
    axes: &[impl AsRef<str> + Sync],
    options: &FitOptions,
    done: &(dyn Fn() + Sync),
) -> Vec<Result<AxisFit, AxisError>> {
    in_parallel(axes, |axis| {
        let fit = fit_axis(recording, stillness, axis.as_ref(), options);
        done();
        fit
    })
}

/// Returns the model before anything is fitted: offset, scale, inputs.
fn start(
    recording: &Recording,
    stillness: &Stillness,
    (column, reference): (&str, &Reference),
    training: &Range<usize>,
    known: &[f64],
    options: &FitOptions,
) -> Result<SingleAxisModel, AxisError> {
    let mean = signal::mean(&[known]);
    let deviation = signal::variance(&[known]).sqrt();
    if deviation == 0.0 {
        return Err(AxisError::Constant { column: column.to_owned(), value: known[0] });
    }
    let axis = Column::named(column).axis();
    let is_accelerometer = matches!(axis, Axis::Ax | Axis::Ay | Axis::Az);
    // at rest an accelerometer shows gravity: without further knowledge the constant is the true value
    let (reference_value, offset) = match (reference, options.offset) {
        (_, Some(offset)) => (0.0, offset),
        (Reference::Constant, None) if is_accelerometer => (mean, 0.0),
        _ => (0.0, mean),
    };
    let parameters = AxisParameters {
        axis,
        reference: reference_value,
        offset,
        scale: options.scale.unwrap_or(deviation),
        constant: 0.0,
        range: ANY,
        physical_range: Fitted::unlimited(),
        full_scale: options.full_scale,
        stuck_after_repeats: stuck_after(recording, column, training),
        gap_limit_samples: (GAP_LIMIT_S / recording.rate.period_s).round().clamp(1.0, 255.0) as u8,
        coast_limit_s: SHORTEST_COAST_S,
        innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
    };
    let mut model = UnitModel {
        period_s: recording.rate.period_s,
        fitted_on: fitted_on(recording, column, options.fitted_on),
        stillness: stillness.limits.and_then(|_| stillness::limits(recording, training)),
        calibration: None,
        quantities: Vec::new(),
        inputs: Vec::new(),
        axes: vec![FittedAxis {
            column: column.to_owned(),
            parameters,
            physical: vec![],
            stochastic: vec![],
            plain: None,
        }],
    };
    for spec in options.physical.iter().chain(&options.inputs) {
        let input = logged_input(&mut model, recording, stillness, training, spec)?;
        model.inputs.push(input);
    }
    let shortest_s = 2.0 * recording.rate.period_s;
    let longest_s = known.len() as f64 * recording.rate.period_s / 5.0;
    for &tau_s in options.memory_s.iter().filter(|tau_s| (shortest_s..=longest_s).contains(*tau_s)) {
        model.inputs.push(NamedInput {
            name: format!("r:lowpass({tau_s})"),
            input: Input {
                source: Source::Remainder(0),
                transform: Transform::LowPass { tau_s },
                centre: 0.0,
                scale: 1.0,
                source_range: ANY,
                range: ANY,
            },
        });
    }
    Ok(SingleAxisModel::of(model))
}

fn logged_input(
    model: &mut UnitModel,
    recording: &Recording,
    stillness: &Stillness,
    training: &Range<usize>,
    spec: &InputSpec,
) -> Result<NamedInput, AxisError> {
    let (source, centre, scale) = match &spec.column {
        None => (Source::Clock, 0.0, 1.0),
        Some(column) => {
            let channel = recording.channel(column)?;
            // centred on the fitted rows: with another centre an uncertain coefficient would add a constant that
            // consists of its error only
            let held = recording.held(channel);
            let rows = training.clone().filter(|row| stillness.still[*row] && held[*row].is_finite());
            let finite: Vec<f64> = rows.map(|row| held[row]).collect();
            let deviation = signal::variance(&[&finite]).sqrt();
            let Some(first) = finite.first() else {
                return Err(AxisError::NotKnown { column: column.clone() });
            };
            if deviation == 0.0 {
                return Err(AxisError::Steady { column: column.clone(), value: *first });
            }
            let quantity = LoggedQuantity {
                column: channel.name.clone(),
                quantity: Column::named(&channel.name).quantity(),
            };
            let index = model.quantities.iter().position(|other| *other == quantity).unwrap_or_else(|| {
                model.quantities.push(quantity);
                model.quantities.len() - 1
            });
            // |x| needs its true zero
            let centred = spec.transform != Transform::Absolute;
            let centre = if centred { signal::mean(&[&finite]) } else { 0.0 };
            (Source::Quantity(index as u8), centre, deviation)
        }
    };
    let input = Input { source, transform: spec.transform, centre, scale, source_range: ANY, range: ANY };
    Ok(NamedInput { name: spec.to_string(), input })
}

/// Fits the physical part, the first `n_inputs` inputs beside a constant for each orientation but the first; returns those
/// that were excluded.
fn fit_physical(
    model: &mut SingleAxisModel,
    n_inputs: usize,
    regressors: &Regressors,
    levels: &[Vec<f64>],
) -> Result<Vec<LeftOut>, AxisError> {
    let column = model.axis().column.clone();
    let most = physical::most_levels(regressors);
    if levels.len() > most {
        return Err(AxisError::TooManyPoses { column, poses: levels.len() + 1, most: most + 1 });
    }
    let inputs = (0..n_inputs as u8).collect();
    let (terms, left_out) = physical::fit(model, regressors, inputs, levels)
        .map_err(|source| AxisError::Search { column, source })?;
    model.axis_mut().physical = terms;
    Ok(left_out)
}

/// Returns the part of the error that the physical part explains, one value per row; NaN after the training part.
fn explained(
    model: &SingleAxisModel,
    recording: &Recording,
    regressors: &Regressors,
) -> Result<Vec<f64>, RecordingError> {
    let axis = model.axis();
    let scale = axis.parameters.scale;
    let left = regressors.remainder.iter().map(|left| scale * left).chain(std::iter::repeat(f64::NAN));
    let series = recording.error_series(&axis.column)?;
    Ok(series.values.iter().zip(left).map(|(error, left)| error - left).collect())
}

/// Moves the mean of the physical part's residual into the offset, so that the remainder has mean 0, to which a coast
/// returns.
fn subtract_mean(parameters: &mut AxisParameters<f64>, regressors: &mut Regressors, reference: &Reference) {
    let mean = signal::mean(&regressors.known_remainder());
    regressors.remainder.iter_mut().for_each(|value| *value -= mean);
    let is_accelerometer = matches!(parameters.axis, Axis::Ax | Axis::Ay | Axis::Az);
    match reference {
        // without further knowledge the constant is the true value there
        Reference::Constant if is_accelerometer => parameters.reference += mean * parameters.scale,
        _ => parameters.offset += mean * parameters.scale,
    }
}

/// Returns whether the values are corrected: by the log if it states so, or by the user; raw otherwise.
fn fitted_on(recording: &Recording, column: &str, stated: FittedOn) -> FittedOn {
    let place = Column::named(column).place();
    let is_corrected = place.is_some_and(|(triad, _)| recording.provenance(triad).corrected_by().is_some());
    if is_corrected { FittedOn::FactoryCorrected } else { stated }
}

/// Returns the longest repetition of a value in the fitted rows, times a margin.
fn stuck_after(recording: &Recording, column: &str, training: &Range<usize>) -> u16 {
    let values = recording.channel(column).map(|channel| &channel.values[training.clone()]).unwrap_or(&[]);
    let longest = values.chunk_by(|a, b| a == b).map(<[f64]>::len).max().unwrap_or(0);
    u16::try_from((STUCK_RATIO * longest).max(STUCK_AT_LEAST)).unwrap_or(u16::MAX)
}

/// Rejects a model whose predictions over the fitted rows, one-step or after 1, 10 and 60 s of free run, leave the
/// range of the error in those rows by more than `LARGEST_EXCURSION` of its widths.
fn refuse_divergent(column: &str, trace: &Trace) -> Result<(), AxisError> {
    let axis = &trace.axes[0];
    let known = || axis.measured.iter().copied().filter(|error| error.is_finite());
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let most = (1.0 + LARGEST_EXCURSION) * (high - low);
    let tracked = axis.one_step.iter().copied().filter(|left| left.is_finite());
    let coasted = axis.horizons.iter().flatten().map(|square| square.sqrt());
    // from any value in the range to its far end and this many widths beyond
    let furthest =
        tracked.chain(coasted).fold(0.0, |most: f64, left| if left.abs() > most.abs() { left } else { most });
    match furthest.abs() <= most || low >= high {
        true => Ok(()),
        false => Err(AxisError::Diverges { column: column.to_owned(), off: furthest.abs(), low, high }),
    }
}

/// Sets the innovation statistics and the longest coast that beats the mean, by running the model over its training
/// data.
fn set_statistics(
    model: &mut SingleAxisModel,
    playback: &Playback<'_>,
    training: Range<usize>,
) -> Result<Trace, ModelError> {
    // longer than any coast of the test, so that nothing fades
    model.axis_mut().parameters.coast_limit_s = f64::from(u16::MAX);
    let trace = evaluate::trace_of(model, playback, training, Coasted::Horizons)?;
    let innovations = trace.stretches_of(&trace.axes[0].one_step);
    let parameters = &mut model.axis_mut().parameters;
    let scale = parameters.scale;
    let variance = signal::variance(&innovations) / (scale * scale);
    parameters.innovation = InnovationStatistics {
        mean: signal::mean(&innovations) / scale,
        // an exact model has no innovations, and the monitor divides by their variance
        variance: variance.max(f64::from(f32::MIN_POSITIVE)),
        lag_1_correlation: autocorrelation(&innovations, 1)
            .map_or(0.0, |result| result.lag_1().clamp(-1.0, 1.0)),
    };
    let mean_square = signal::variance(&trace.stretches_of(&trace.axes[0].measured));
    let beats_the_mean = evaluate::HORIZONS_S
        .iter()
        .zip(&trace.axes[0].horizons)
        .filter(|(_, squares)| !squares.is_empty() && signal::mean(&[squares]) <= mean_square);
    parameters.coast_limit_s = beats_the_mean.map(|(horizon, _)| *horizon).fold(SHORTEST_COAST_S, f64::max);
    Ok(trace)
}

/// Sets the fitted ranges of the inputs, of the physical part and of the remainder.
fn set_ranges(model: &mut SingleAxisModel, regressors: &Regressors) {
    let range = |column: &[f64]| {
        let extremes = regressors
            .known(column)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        Fitted::new(extremes.0, extremes.1)
    };
    let remainder = range(&regressors.remainder);
    model.axis_mut().parameters.range = remainder;
    for (named, column) in model.inputs_mut().inputs.iter_mut().zip(&regressors.inputs) {
        let input = &mut named.input;
        input.range = match input.transform {
            // these have fixed limits, whatever part of the range the training data cover
            Transform::Decay { .. } => Fitted::new(0.0, 1.0),
            Transform::Sine { .. } | Transform::Cosine { .. } => Fitted::new(-1.0, 1.0),
            _ => range(column),
        };
        input.source_range = match input.source {
            Source::Clock => Fitted::new(0.0, 0.0),
            Source::Remainder(_) => remainder,
            // a low-pass stays within the range of its input; a variance or a rate does not bound it
            Source::Quantity(_) => Fitted::new(-SOURCE_LIMIT, SOURCE_LIMIT),
        };
    }
    let terms = model.axis().physical.chunks(1);
    let parts: Vec<Part<'_>> = terms.map(|terms| Part { terms, within: Fitted::unlimited() }).collect();
    let rows = regressors.stretches.iter().cloned().flatten();
    let limits = physical_range(&model.inputs, &regressors.inputs, rows, &parts);
    model.axis_mut().parameters.physical_range = limits;
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};
    use fos_testkit::series::every_kind;

    fn recording(column: &str, values: &[f64]) -> Recording {
        let columns = vec![
            ("t_s".to_owned(), (0..values.len()).map(|row| row as f64 / 20.0).collect()),
            (column.to_owned(), values.to_vec()),
            ("temp_c".to_owned(), (0..values.len()).map(|row| 25.0 + (row as f64 / 300.0).sin()).collect()),
        ];
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
    }

    /// A trace of three rows whose error lies between −1 and 1.
    fn trace_of(one_step: [f64; 3], squares: Vec<f64>) -> Trace {
        let axis = evaluate::AxisTrace {
            measured: vec![-1.0, 0.0, 1.0],
            one_step: one_step.to_vec(),
            horizons: [squares, Vec::new(), Vec::new()],
            ..Default::default()
        };
        Trace {
            rows: 0..3,
            period_s: 0.01,
            stretches: std::iter::once(0..3).collect(),
            axes: vec![axis],
            strapdown: None,
        }
    }

    #[test]
    fn fitted_models_stay_near_their_training_rows() {
        let mut fitted = 0;
        for (name, values) in every_kind(800) {
            let recording = recording("gx_rads", &values);
            let options = FitOptions {
                max_lag: 4,
                max_terms: 8,
                train: Train::Share(0.6),
                physical: vec!["temp_c".parse().unwrap()],
                ..FitOptions::default()
            };
            let rest = rest(&recording, options.train);
            let Ok(mut fit) = fit_axis(&recording, &rest, "gx", &options) else { continue };
            fitted += 1;
            let rows = training_rows(&recording, options.train);
            let playback = Playback::new(&recording, &fit.model, &rest.still).unwrap();
            let trace = set_statistics(&mut fit.model, &playback, rows).unwrap();
            assert!(refuse_divergent("gx_rads", &trace).is_ok(), "{name}");
        }
        assert!(fitted > 0);
        let far = refuse_divergent("gx_rads", &trace_of([0.1, -4.5, 0.1], vec![0.5]));
        println!(
            "attack: divergent models | {fitted} models of all kinds of data stay near the fitted rows, both tracking and after free runs of 1, 10 and 60 s | negative control: a prediction that is off by twice the range of the error is {}",
            if far.is_err() { "refused" } else { "accepted" },
        );
    }

    /// Rests of 3 s at 20 Hz, each possibly in another orientation.
    fn in_orientations(count: usize) -> Result<AxisFit, AxisError> {
        let n = 60 * count;
        let noise = fos_testkit::noise::white_noise(4, n);
        let values: Vec<f64> = noise.iter().map(|noise| 9.8 + 0.01 * noise).collect();
        let recording = recording("ax_mps2", &values);
        let turns = (60..n).step_by(60).collect();
        let rest = Stillness { still: vec![true; n], turns, ..stillness::find(&recording) };
        let options = FitOptions {
            max_lag: 1,
            degree: 1,
            memory_s: Vec::new(),
            physical: vec!["temp_c".parse().unwrap()],
            train: Train::Share(0.5),
            ..FitOptions::default()
        };
        fit_axis(&recording, &rest, "ax", &options)
    }

    /// "u126 cannot be a term" was the message.
    #[test]
    fn rejects_more_orientations_than_levels() {
        assert!(in_orientations(2 * 126).is_ok());
        let error = in_orientations(2 * 127).unwrap_err().to_string();
        assert!(error.contains("rests in 127 orientations") && error.contains("at most 126"), "{error}");
    }

    #[test]
    fn rejects_divergent_model() {
        let verdict = |one_step, squares| refuse_divergent("gx_rads", &trace_of(one_step, squares));
        assert!(verdict([0.1, -0.2, f64::NAN], vec![0.5]).is_ok());
        // one-step, and in a free run: twice the range of the error away
        for diverged in [verdict([0.1, -4.5, 0.1], vec![0.5]), verdict([0.1, 0.1, 0.1], vec![0.5, 20.5])] {
            let error = diverged.unwrap_err().to_string();
            assert!(error.starts_with("gx_rads: the model diverges"), "{error}");
        }
    }
}
