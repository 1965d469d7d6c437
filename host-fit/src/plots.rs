//! The figures of a comparison, one set per axis: what is shown is computed here, how it looks in [`figures`].
//!
//! [`figures`]: crate::figures

use fos_data::column::Column;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::escaping::in_file_name;
use crate::figures::compare::{
    Subject, Worst, against, allan, measured_and_predicted, residual, residual_autocorrelation, spectra,
};
use crate::figures::dependence::dependence;
use crate::figures::staircase::{Predicted, Step, staircase};
use crate::figures::{Figure, FigureError, write_png, write_svg};
use fos_data::file::{FileError, check_output, make_folder};
use fos_data::recording::{Recording, pieces};
use fos_diagnose::compare::{AxisComparison, Comparison};
use fos_diagnose::effects::Band;
use fos_diagnose::study::Refinement;
use fos_fit::evaluate::{AxisTrace, Trace};
use fos_fit::signal::allan::{allan_deviation, averaging_times};
use fos_fit::signal::autocorrelation::autocorrelation;
use fos_fit::signal::blocks::{Envelope, envelope};
use fos_fit::signal::spectrum::{Spectrum, segment_length_for, welch};

/// Columns of pixels in a figure over time, shared by all stretches.
const BUCKETS: usize = 1000;

/// Length of the moving mean, s.
const MEAN_S: f64 = 1.0;

/// Dots of a figure against a channel, about.
const DOTS: usize = 1200;

/// What is shaded.
const WORST: &str = "worst stretches";

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
    #[error(transparent)]
    Folder(#[from] FileError),
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
pub fn write_staircase(folder: &Path, growth: &Refinement) -> Result<(), PlotError> {
    write(folder, &growth.column, &[(STAIRCASE, staircase_of(growth))])
}

/// The staircase of an axis that grew.
pub fn staircase_of(growth: &Refinement) -> Figure {
    let mut steps: Vec<Step> = Vec::new();
    for stair in &growth.steps {
        let before = steps.last().map(|step| (step.slow, step.wide));
        let predicted = stair.added.as_ref().zip(before).and_then(|(added, (slow, wide))| {
            let finding = &added.finding;
            let is_wide = finding.band == Band::Wide;
            let left = |drop: f64| if is_wide { wide } else { slow } * (1.0 - drop).max(0.0).sqrt();
            let [low, high] = finding.predicted_reduction_interval;
            (finding.predicted_reduction > 0.0).then(|| Predicted {
                wide: is_wide,
                left: left(finding.predicted_reduction),
                interval: [left(high), left(low)],
            })
        });
        steps.push(Step {
            name: stair.errors.model.clone(),
            slow: stair.left.slow.sqrt(),
            wide: stair.left.wide.sqrt(),
            predicted,
            coast: stair.errors.coast.iter().map(|coast| (coast.horizon_s, coast.mse.sqrt())).collect(),
        });
    }
    staircase(Column::named(&growth.column).label(), Column::named(&growth.column).unit().label(), &steps)
}

/// Writes figures of a column into `folder`, each as SVG and as PNG, named by column and name.
///
/// # Errors
///
/// The folder cannot be made, or a file in it cannot be written.
pub fn write(folder: &Path, column: &str, figures: &[(&str, Figure)]) -> Result<(), PlotError> {
    check(folder, column, figures.iter().map(|(name, _)| *name))?;
    make_folder(folder)?;
    for (name, figure) in figures {
        let [svg, png] = paths(folder, column, name);
        write_svg(figure, &svg)?;
        write_png(figure, &png)?;
    }
    Ok(())
}

/// Whether figures of these names can be written there, asked before anything is.
///
/// # Errors
///
/// One would take the place of what was read, or of what is no file.
pub fn check<'a>(
    folder: &Path,
    column: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Result<(), PlotError> {
    let mut paths = names.into_iter().flat_map(|name| paths(folder, column, name));
    Ok(paths.try_for_each(|path| check_output(&path))?)
}

fn paths(folder: &Path, column: &str, name: &str) -> [PathBuf; 2] {
    ["svg", "png"].map(|ending| folder.join(format!("{}_{name}.{ending}", in_file_name(column))))
}

/// How the figure of a staircase is called.
const STAIRCASE: &str = "staircase";

/// Whether [`write_staircase`] can write, asked before a study is changed.
///
/// # Errors
///
/// As of [`check`].
pub fn check_staircase(folder: &Path, column: &str) -> Result<(), PlotError> {
    check(folder, column, [STAIRCASE])
}

/// The figures of one axis, with their names; one that the data are too short for is left out.
pub fn figures(
    axis: &AxisComparison,
    trace: &Trace,
    index: usize,
    recording: &Recording,
) -> Vec<(&'static str, Figure)> {
    let view = View { axis, trace, index, recording };
    let mut figures = vec![("1_over_time", view.over_time()), ("2_residual", view.residual())];
    figures.extend(view.autocorrelation().map(|figure| ("3_autocorrelation", figure)));
    figures.extend(view.spectrum().map(|figure| ("4_spectrum", figure)));
    figures.push(("5_allan", view.allan()));
    figures.extend(view.dependence().map(|figure| ("6_dependence", figure)));
    figures
}

/// One axis of a comparison, to be shown: all of it, or a part of its trace.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// What was computed.
    pub axis: &'a AxisComparison,
    /// What is left, of the rows to be shown.
    pub trace: &'a Trace,
    /// Which axis of the trace.
    pub index: usize,
    /// The log.
    pub recording: &'a Recording,
}

impl View<'_> {
    fn subject(&self) -> Subject<'_> {
        Subject { channel: Column::named(&self.axis.column).label(), unit: &self.axis.unit }
    }

    fn series(&self) -> &AxisTrace {
        &self.trace.axes[self.index]
    }

    /// The worst stretches, the worst first, s.
    fn worst_s(&self) -> Vec<(f64, f64)> {
        self.axis.worst.iter().map(|stretch| (stretch.begin_s, stretch.end_s)).collect()
    }

    fn envelopes(&self, series: &[f64]) -> Vec<Envelope> {
        envelopes(self.trace, series, self.recording)
    }

    /// All figures in the order of thought; one that the data are too short for is left out.
    pub fn all(&self) -> Vec<Figure> {
        let mut figures = vec![self.over_time(), self.residual()];
        figures.extend(self.dependence());
        figures.extend(self.spectrum());
        figures.extend(self.autocorrelation());
        figures.push(self.allan());
        figures
    }

    /// Measured and predicted over time.
    pub fn over_time(&self) -> Figure {
        let series = self.series();
        let centre = mean_of(&series.measured);
        let measured: Vec<f64> = series.measured.iter().map(|value| value - centre).collect();
        let coasted = difference(&measured, &series.coast);
        let worst_s = self.worst_s();
        measured_and_predicted(
            self.subject(),
            &self.envelopes(&measured),
            &self.envelopes(&coasted),
            &mean_label(),
            Worst { label: WORST, ranges_s: &worst_s },
        )
    }

    /// What is left over time.
    pub fn residual(&self) -> Figure {
        let worst_s = self.worst_s();
        let worst = Worst { label: WORST, ranges_s: &worst_s };
        residual(self.subject(), &self.envelopes(&self.series().coast), &mean_label(), worst)
    }

    /// Whether the innovations remember; none where there are too few.
    pub fn autocorrelation(&self) -> Option<Figure> {
        let innovations = self.trace.stretches_of(&self.series().one_step);
        let correlation = autocorrelation(&innovations, MAX_LAG)?;
        Some(residual_autocorrelation(self.subject(), &correlation, self.trace.period_s))
    }

    /// Spectra of measured, predicted and left; none where there is too little.
    pub fn spectrum(&self) -> Option<Figure> {
        let series = self.series();
        let predicted = difference(&series.measured, &series.one_step);
        let (measured, predicted, left) =
            (self.density(&series.measured)?, self.density(&predicted)?, self.density(&series.one_step)?);
        // white noise of the floor's variance over half the sample rate
        let floor = self.axis.noise_floor.map(|(variance, _)| 2.0 * variance * self.trace.period_s);
        Some(spectra(self.subject(), &measured, &predicted, &left, floor))
    }

    fn density(&self, series: &[f64]) -> Option<Spectrum> {
        let stretches = self.trace.stretches_of(series);
        let length = segment_length_for(&stretches);
        Some(welch(&stretches, 1.0 / self.trace.period_s, length)?.smoothed(BANDS_PER_DECADE))
    }

    /// Allan deviations of measured, predicted and left.
    pub fn allan(&self) -> Figure {
        let series = self.series();
        let predicted = difference(&series.measured, &series.coast);
        let deviations = |series: &[f64]| {
            let stretches = self.trace.stretches_of(series);
            let taus = averaging_times(&stretches, self.trace.period_s, TAUS_PER_DECADE);
            allan_deviation(&stretches, self.trace.period_s, &taus)
        };
        let [measured, predicted, left] =
            [&series.measured, &predicted, &series.coast].map(|series| deviations(series));
        allan(self.subject(), &measured, &predicted, &left)
    }

    /// What is left against everything that is logged, with what chance explains; none where that is not known.
    pub fn dependence(&self) -> Option<Figure> {
        self.axis.dependence.as_ref().map(|found| dependence(self.subject(), found))
    }

    /// What is left against each logged channel that changes, in block means, with the column; those of `marked` rows apart.
    pub fn against(&self, marked: Option<&Range<usize>>) -> Vec<(String, Figure)> {
        let left = &self.series().coast;
        let rows_per_block =
            (self.trace.rows.len() / DOTS).max((MEAN_S / self.trace.period_s) as usize).max(1);
        let blocks = pieces(&self.trace.stretches, rows_per_block);
        let of_trace =
            |block: &Range<usize>| block.start - self.trace.rows.start..block.end - self.trace.rows.start;
        let errors: Vec<f64> = blocks.iter().map(|block| mean_of(&left[of_trace(block)])).collect();
        let others = self.recording.channels().iter().filter(|channel| channel.name != self.axis.column);
        let block_s = rows_per_block as f64 * self.trace.period_s;
        others
            .filter_map(|channel| {
                let held = &self.recording.held_from_first(channel)[self.trace.rows.clone()];
                let values = blocks.iter().map(|block| mean_of(&held[of_trace(block)]));
                let dots = values.zip(&errors).zip(&blocks);
                let (mut usual, mut apart) = (Vec::new(), Vec::new());
                for ((value, error), block) in dots {
                    let is_apart = marked.is_some_and(|marked| marked.contains(&block.start));
                    if is_apart { &mut apart } else { &mut usual }.push((value, *error));
                }
                let first = usual.first().or(apart.first())?.0;
                let changes = usual.iter().chain(&apart).any(|(value, _)| *value != first);
                changes.then(|| {
                    let figure = against(self.subject(), &channel.name, block_s, usual, apart);
                    (channel.name.clone(), figure)
                })
            })
            .collect()
    }
}

fn mean_label() -> String {
    format!("{MEAN_S} s mean")
}

fn difference(from: &[f64], take: &[f64]) -> Vec<f64> {
    from.iter().zip(take).map(|(a, b)| a - b).collect()
}

/// One envelope per stretch.
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

/// The envelope of one of several stretches with `total` samples in all; it gets columns by its length.
pub(crate) fn outline(stretch: &[f64], total: usize, start_s: f64, period_s: f64) -> Envelope {
    let buckets = (BUCKETS * stretch.len()).div_ceil(total.max(1)).max(1);
    envelope(stretch, start_s, period_s, buckets, MEAN_S)
}

fn mean_of(series: &[f64]) -> f64 {
    let finite: Vec<f64> = series.iter().copied().filter(|value| value.is_finite()).collect();
    fos_fit::signal::mean(&[&finite])
}
