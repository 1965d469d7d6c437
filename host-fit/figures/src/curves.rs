//! Data of the figures of a comparison: envelopes over time, spectra, autocorrelation, Allan deviations, block means against channels. All
//! of it is computed here; [`compare`] only draws.
//!
//! [`compare`]: crate::compare

use std::ops::Range;

use fos_data::interrupt::in_parallel;
use fos_data::recording::{Recording, pieces};
use fos_diagnose::compare::{AxisComparison, Comparison};
use fos_fit::evaluate::{AxisTrace, Trace};
use fos_fit::signal::allan::{AllanPoint, TAUS_PER_DECADE, allan_deviation, averaging_times};
use fos_fit::signal::autocorrelation::{Autocorrelation, autocorrelation};
use fos_fit::signal::blocks::{Envelope, envelope};
use fos_fit::signal::spectrum::{Spectrum, segment_length_for, welch};

/// Columns of pixels in a figure over time, shared by all stretches.
const BUCKETS: usize = 1000;

/// Length of the moving mean, s.
pub const MEAN_S: f64 = 1.0;

/// Approximate number of dots in a figure against a channel.
const DOTS: usize = 1200;

/// Longest lag of the autocorrelation, in samples.
const MAX_LAG: usize = 200;

/// Bands per decade that a spectrum is smoothed to.
const BANDS_PER_DECADE: usize = 40;

/// Curves of one axis over a log, or over a part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisCurves {
    /// Measured values minus their mean, their prediction while coasting minus the same mean, and the residual while coasting; one envelope
    /// for each stretch without gaps, in the axis' unit.
    pub over_time: [Vec<Envelope>; 3],
    /// Autocorrelation of the innovations at lags 0 … 200; none if there are too few.
    pub autocorrelation: Option<Autocorrelation>,
    /// Power spectral densities of the samples, the one-step predictions and the innovations, smoothed, in unit²/Hz; then that of white
    /// noise with the variance of the noise floor, if it is known. None if the log is too short.
    pub spectra: Option<([Spectrum; 3], Option<f64>)>,
    /// Allan deviations with 95 % intervals of the samples, and of prediction and residual while coasting, in the axis' unit.
    pub deviations: [Vec<AllanPoint>; 3],
    /// Sample period, s.
    pub period_s: f64,
}

/// Block means of the residual against those of one channel: pairs (channel, axis).
#[derive(Debug, Clone, PartialEq)]
pub struct AgainstChannel {
    /// Column of the channel.
    pub channel: String,
    /// Length of a block, s.
    pub block_s: f64,
    /// Blocks outside the marked rows.
    pub usual: Vec<(f64, f64)>,
    /// Blocks within the marked rows.
    pub apart: Vec<(f64, f64)>,
}

/// Curves of every axis of a comparison, in its order.
pub fn curves(comparison: &Comparison, trace: &Trace, recording: &Recording) -> Vec<AxisCurves> {
    in_parallel(0..comparison.axes.len(), |index| {
        AxisCurves::of(&comparison.axes[index], trace, index, recording)
    })
}

impl AxisCurves {
    /// Curves of axis `index` of a trace, over the rows of the trace.
    pub fn of(axis: &AxisComparison, trace: &Trace, index: usize, recording: &Recording) -> Self {
        let series = &trace.axes[index];
        let centre = mean_of(&series.measured);
        let measured: Vec<f64> = series.measured.iter().map(|value| value - centre).collect();
        let over_time = [&measured, &difference(&measured, &series.coast), &series.coast];
        Self {
            over_time: over_time.map(|series| envelopes(trace, series, recording)),
            autocorrelation: autocorrelation(&trace.stretches_of(&series.one_step), MAX_LAG),
            spectra: spectra(trace, series).map(|spectra| {
                // Two-sided variance over half the sampling rate.
                (spectra, axis.noise_floor.map(|(variance, _)| 2.0 * variance * trace.period_s))
            }),
            deviations: deviations(trace, series),
            period_s: trace.period_s,
        }
    }
}

fn spectra(trace: &Trace, series: &AxisTrace) -> Option<[Spectrum; 3]> {
    let density = |series: &[f64]| -> Option<Spectrum> {
        let stretches = trace.stretches_of(series);
        let length = segment_length_for(&stretches);
        Some(welch(&stretches, 1.0 / trace.period_s, length)?.smoothed(BANDS_PER_DECADE))
    };
    let predicted = difference(&series.measured, &series.one_step);
    Some([density(&series.measured)?, density(&predicted)?, density(&series.one_step)?])
}

fn deviations(trace: &Trace, series: &AxisTrace) -> [Vec<AllanPoint>; 3] {
    [&series.measured, &difference(&series.measured, &series.coast), &series.coast].map(|series| {
        let stretches = trace.stretches_of(series);
        let taus = averaging_times(&stretches, trace.period_s, TAUS_PER_DECADE);
        allan_deviation(&stretches, trace.period_s, &taus)
    })
}

impl AgainstChannel {
    /// Residual of axis `index` against each logged channel that varies; blocks of `marked` rows are listed apart.
    pub fn every_channel(
        axis: &AxisComparison,
        trace: &Trace,
        index: usize,
        recording: &Recording,
        marked: Option<&Range<usize>>,
    ) -> Vec<Self> {
        let left = &trace.axes[index].coast;
        let rows_per_block = (trace.rows.len() / DOTS).max((MEAN_S / trace.period_s) as usize).max(1);
        let blocks = pieces(&trace.stretches, rows_per_block);
        let of_trace = |block: &Range<usize>| block.start - trace.rows.start..block.end - trace.rows.start;
        let errors: Vec<f64> = blocks.iter().map(|block| mean_of(&left[of_trace(block)])).collect();
        let others = recording.channels().iter().filter(|channel| channel.name != axis.column);
        let block_s = rows_per_block as f64 * trace.period_s;
        others
            .filter_map(|channel| {
                let held = &recording.held_from_first(channel)[trace.rows.clone()];
                let values = blocks.iter().map(|block| mean_of(&held[of_trace(block)]));
                let dots = values.zip(&errors).zip(&blocks);
                let (mut usual, mut apart) = (Vec::new(), Vec::new());
                for ((value, error), block) in dots {
                    let is_apart = marked.is_some_and(|marked| marked.contains(&block.start));
                    if is_apart { &mut apart } else { &mut usual }.push((value, *error));
                }
                let first = usual.first().or(apart.first())?.0;
                let changes = usual.iter().chain(&apart).any(|(value, _)| *value != first);
                changes.then(|| Self { channel: channel.name.clone(), block_s, usual, apart })
            })
            .collect()
    }
}

fn difference(from: &[f64], take: &[f64]) -> Vec<f64> {
    from.iter().zip(take).map(|(a, b)| a - b).collect()
}

/// One envelope for each stretch.
fn envelopes(trace: &Trace, series: &[f64], recording: &Recording) -> Vec<Envelope> {
    let total: usize = trace.stretches.iter().map(ExactSizeIterator::len).sum();
    let known = |stretch: &Range<usize>| {
        let values = &series[stretch.start - trace.rows.start..stretch.end - trace.rows.start];
        // the first samples of a stretch have no prediction yet
        let first = values.iter().position(|value| value.is_finite())?;
        let values: Vec<f64> =
            values[first..].iter().copied().take_while(|value| value.is_finite()).collect();
        Some(outline(&values, total, recording.time_s[stretch.start + first], trace.period_s))
    };
    trace.stretches.iter().filter_map(known).collect()
}

/// Envelope of a stretch; it gets a share of the columns in proportion to its length among `total` samples.
pub fn outline(stretch: &[f64], total: usize, start_s: f64, period_s: f64) -> Envelope {
    let buckets = (BUCKETS * stretch.len()).div_ceil(total.max(1)).max(1);
    envelope(stretch, start_s, period_s, buckets, MEAN_S)
}

fn mean_of(series: &[f64]) -> f64 {
    let finite: Vec<f64> = series.iter().copied().filter(|value| value.is_finite()).collect();
    fos_fit::signal::mean(&[&finite])
}
