//! Compares all methods at all orders on one axis of a log.

use std::ops::Range;

use super::evaluate::{Prepared, evaluate};
use super::result::{Cell, Comparison, Entry};
use super::settings::Settings;
use super::split::{Split, SplitError, split};
use fos_data::column::Column;
use fos_data::recording::{ErrorSeries, Recording};
use fos_data::stillness::Stillness;
use fos_fit::fit::autoregression::Method;
use fos_fit::signal;
use fos_fit::signal::noise_floor::noise_floor;

/// The comparison failed.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The log cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// The training part is constant.
    #[error(
        "{0}: every value in the training part is the same: a stuck or unconnected axis\nhelp: leave the axis out"
    )]
    Constant(String),
}

/// Compares the methods on the errors of one axis of `recording`; returns the comparison and its split.
///
/// # Errors
/// The log is too short for three parts, or the axis is stuck.
pub fn compare(
    recording: &Recording,
    stillness: &Stillness,
    series: &ErrorSeries,
    settings: &Settings,
    mut progress: impl FnMut(&Cell),
) -> Result<(Comparison, Split), PaperError> {
    let rate_hz = recording.rate.true_hz;
    let split = split(recording, stillness, &series.values, settings)?;
    let parts = |ranges: &[Range<usize>]| -> Vec<&[f64]> {
        ranges.iter().map(|range| &series.values[range.clone()]).collect()
    };
    let train = parts(&split.train);
    let (mean, scale) = (signal::mean(&train), signal::variance(&train).sqrt());
    if scale == 0.0 {
        return Err(PaperError::Constant(series.channel.clone()));
    }
    let samples: Vec<f64> = series.values.iter().map(|value| (value - mean) / scale).collect();
    // Each part is de-noised separately, without data of the others.
    let mut denoised = vec![f64::NAN; samples.len()];
    for range in split.parts().flatten().filter(|range| range.len() >= settings.denoising.shortest()) {
        denoised[range.clone()].copy_from_slice(&settings.denoising.denoise(&samples[range.clone()]));
    }
    let predicted = parts(&split.predict);
    let floor = noise_floor(&predicted);
    let prepared = Prepared { column: &series.channel, samples, denoised, scale, split, floor };

    let entries = Method::ALL
        .map(Entry::Denoised)
        .into_iter()
        .chain(Method::ALL.map(Entry::Raw))
        .chain((1..=settings.max_degree).map(Entry::Fos));
    let mut cells = Vec::new();
    for entry in entries {
        for order in 1..=settings.max_order {
            let evaluation = evaluate(&prepared, entry, order, settings);
            let cell = Cell { entry, order, result: evaluation.map_err(|error| error.to_string()) };
            progress(&cell);
            cells.push(cell);
        }
    }
    let evaluation = |cell: &Cell| match (&cell.entry, &cell.result) {
        (Entry::Fos(_), Ok(evaluation)) => Some(evaluation.mse_evaluation),
        _ => None,
    };
    let candidates = cells.iter().enumerate().filter_map(|(i, cell)| Some((i, evaluation(cell)?)));
    let chosen = candidates.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
    let comparison = Comparison {
        column: series.channel.clone(),
        unit: Column::named(&series.channel).unit().label().to_owned(),
        rate_hz,
        samples: prepared.split.samples(),
        band_hz: settings.denoising.band_hz(rate_hz),
        variance: signal::variance(&predicted),
        noise_floor: prepared.floor.map(|floor| (floor.variance, floor.interval)),
        cells,
        chosen,
    };
    Ok((comparison, prepared.split))
}
