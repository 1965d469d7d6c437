//! The figures of a comparison, one set per axis: what is shown is computed here, how it looks in [`figures`].
//!
//! [`figures`]: crate::figures

use std::path::{Path, PathBuf};

use crate::compare::{AxisComparison, Comparison};
use crate::effects::Band;
use crate::evaluate::Trace;
use crate::figures::compare::{
    Subject, Worst, allan, measured_and_predicted, residual, residual_autocorrelation, spectra,
};
use crate::figures::dependence::dependence;
use crate::figures::staircase::{Foretold, Step, staircase};
use crate::figures::{Figure, FigureError, write_png, write_svg};
use crate::grow::Growth;
use crate::recording::Recording;
use crate::signal::allan::{allan_deviation, averaging_times};
use crate::signal::autocorrelation::autocorrelation;
use crate::signal::blocks::{Envelope, envelope};
use crate::signal::spectrum::{Spectrum, segment_length_for, welch};

/// Columns of pixels in a figure over time, shared by all stretches.
const BUCKETS: usize = 1000;

/// Length of the moving mean, s.
const MEAN_S: f64 = 1.0;

/// Longest lag of the autocorrelation.
const MAX_LAG: usize = 200;

/// Bands per decade that a spectrum is smoothed to.
const BANDS_PER_DECADE: usize = 40;

/// Averaging times per decade.
const TAUS_PER_DECADE: usize = 8;

/// Why the figures are not there.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The folder cannot be made.
    #[error("{}: cannot make the folder: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A figure cannot be drawn or written.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// Writes the six figures of every axis into `folder`, each as SVG and as PNG.
///
/// # Errors
///
/// The folder cannot be made, or a file in it cannot be written.
pub fn write_all(
    folder: &Path,
    comparison: &Comparison,
    trace: &Trace,
    recording: &Recording,
) -> Result<(), PlotError> {
    for (index, axis) in comparison.axes.iter().enumerate() {
        write(folder, &axis.column, &figures(axis, trace, index, recording))?;
    }
    Ok(())
}

/// Writes the staircase of an axis that grew into `folder`, as SVG and as PNG.
///
/// # Errors
///
/// The folder cannot be made, or a file in it cannot be written.
pub fn write_staircase(folder: &Path, growth: &Growth) -> Result<(), PlotError> {
    let mut steps: Vec<Step> = Vec::new();
    for stair in &growth.stairs {
        let before = steps.last().map(|step| (step.slow, step.wide));
        let foretold = stair.added.as_ref().zip(before).and_then(|(added, (slow, wide))| {
            let finding = &added.finding;
            let is_wide = finding.band == Band::Wide;
            let left = |drop: f64| if is_wide { wide } else { slow } * (1.0 - drop).max(0.0).sqrt();
            let [low, high] = finding.expected_drop_ci;
            (finding.expected_drop > 0.0).then(|| Foretold {
                wide: is_wide,
                left: left(finding.expected_drop),
                interval: [left(high), left(low)],
            })
        });
        steps.push(Step {
            name: stair.errors.model.clone(),
            slow: stair.left.slow.sqrt(),
            wide: stair.left.wide.sqrt(),
            foretold,
            coast: stair.errors.coast.iter().map(|coast| (coast.horizon_s, coast.mse.sqrt())).collect(),
        });
    }
    let figure = staircase(in_words(&growth.column), crate::model::unit_of(&growth.column), &steps);
    write(folder, &growth.column, &[("staircase", figure)])
}

/// Writes figures of a column into `folder`, each as SVG and as PNG, named by column and name.
///
/// # Errors
///
/// The folder cannot be made, or a file in it cannot be written.
pub fn write(folder: &Path, column: &str, figures: &[(&str, Figure)]) -> Result<(), PlotError> {
    std::fs::create_dir_all(folder)
        .map_err(|source| PlotError::Folder { path: folder.to_owned(), source })?;
    for (name, figure) in figures {
        let path = folder.join(format!("{column}_{name}"));
        write_svg(figure, &path.with_extension("svg"))?;
        write_png(figure, &path.with_extension("png"))?;
    }
    Ok(())
}

/// The figures of one axis, with their names; one that the data are too short for is left out.
fn figures(
    axis: &AxisComparison,
    trace: &Trace,
    index: usize,
    recording: &Recording,
) -> Vec<(&'static str, Figure)> {
    let subject = Subject { channel: in_words(&axis.column), unit: &axis.unit };
    let worst_s: Vec<(f64, f64)> =
        axis.worst.iter().map(|stretch| (stretch.begin_s, stretch.end_s)).collect();
    let worst = Worst { label: "worst stretches", ranges_s: &worst_s };
    let series = &trace.axes[index];
    let difference =
        |from: &[f64], take: &[f64]| -> Vec<f64> { from.iter().zip(take).map(|(a, b)| a - b).collect() };
    let centre = mean_of(&series.measured);
    let measured: Vec<f64> = series.measured.iter().map(|value| value - centre).collect();
    let coasted = difference(&measured, &series.coast);
    let predicted = difference(&series.measured, &series.one_step);

    let over_time = |series: &[f64]| envelopes(trace, series, recording);
    let mean_label = format!("{MEAN_S} s mean");
    let mut figures = vec![
        (
            "1_over_time",
            measured_and_predicted(subject, &over_time(&measured), &over_time(&coasted), &mean_label, worst),
        ),
        ("2_residual", residual(subject, &over_time(&series.coast), &mean_label, worst)),
    ];
    let innovations = trace.stretches_of(&series.one_step);
    if let Some(correlation) = autocorrelation(&innovations, MAX_LAG) {
        figures.push(("3_autocorrelation", residual_autocorrelation(subject, &correlation, trace.period_s)));
    }
    let spectrum = |series: &[f64]| -> Option<Spectrum> {
        let stretches = trace.stretches_of(series);
        let length = segment_length_for(&stretches);
        Some(welch(&stretches, 1.0 / trace.period_s, length)?.smoothed(BANDS_PER_DECADE))
    };
    if let (Some(measured), Some(predicted), Some(left)) =
        (spectrum(&series.measured), spectrum(&predicted), spectrum(&series.one_step))
    {
        // white noise of the floor's variance over half the sample rate
        let floor = axis.noise_floor.map(|(variance, _)| 2.0 * variance * trace.period_s);
        figures.push(("4_spectrum", spectra(subject, &measured, &predicted, &left, floor)));
    }
    let deviations = |series: &[f64]| {
        let stretches = trace.stretches_of(series);
        let taus = averaging_times(&stretches, trace.period_s, TAUS_PER_DECADE);
        allan_deviation(&stretches, trace.period_s, &taus)
    };
    figures.push(("5_allan", allan(subject, &deviations(&series.measured), &deviations(&series.coast))));
    if let Some(found) = &axis.dependence {
        figures.push(("6_dependence", dependence(subject, found)));
    }
    figures
}

/// One envelope per stretch.
fn envelopes(trace: &Trace, series: &[f64], recording: &Recording) -> Vec<Envelope> {
    let total: usize = trace.stretches.iter().map(ExactSizeIterator::len).sum();
    let known = |stretch: &std::ops::Range<usize>| {
        let values = &series[stretch.start - trace.rows.start..stretch.end - trace.rows.start];
        // the first samples of a stretch have no prediction yet
        let first = values.iter().position(|value| value.is_finite())?;
        let values: Vec<f64> =
            values[first..].iter().copied().take_while(|value| value.is_finite()).collect();
        Some(outline(&values, total, recording.time_s[stretch.start + first], trace.period_s))
    };
    trace.stretches.iter().filter_map(known).collect()
}

/// The envelope of one of several stretches with `total` samples in all; it gets columns by its length.
pub(crate) fn outline(stretch: &[f64], total: usize, start_s: f64, period_s: f64) -> Envelope {
    let buckets = (BUCKETS * stretch.len()).div_ceil(total.max(1)).max(1);
    envelope(stretch, start_s, period_s, buckets, MEAN_S)
}

fn mean_of(series: &[f64]) -> f64 {
    let finite: Vec<f64> = series.iter().copied().filter(|value| value.is_finite()).collect();
    crate::signal::mean(&[&finite])
}

/// A column in words.
pub(crate) fn in_words(column: &str) -> &str {
    match column {
        "ax_mps2" => "accelerometer x",
        "ay_mps2" => "accelerometer y",
        "az_mps2" => "accelerometer z",
        "gx_rads" => "gyro x",
        "gy_rads" => "gyro y",
        "gz_rads" => "gyro z",
        other => other,
    }
}
