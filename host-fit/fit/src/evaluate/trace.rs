//! Runs a model over a recording once and keeps the residuals: one-step, and of free runs.

use std::ops::Range;

use fos_core::{ModelError, Predictor, Real};

use super::coasts::Coasting;
use super::origins::Origins;
use super::strapdown::{SixAxes, StrapdownEnd};
use super::unaided::UNAIDED_S;
use crate::model::{AXES, INPUTS, SmallPredictor, UnitModel};
use crate::playback::{Feed, Playback};
use fos_data::interrupt;

/// Residuals of every axis of a model over a recording.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Evaluated rows of the recording.
    pub rows: Range<usize>,
    /// Sample period, s.
    pub period_s: f64,
    /// Gap-free stretches of still rows, in rows of the recording.
    pub stretches: Vec<Range<usize>>,
    /// One entry per axis of the model.
    pub axes: Vec<AxisTrace>,
    /// Errors of a strapdown at the ends of windows without aiding, for each length of [`UNAIDED_S`]; none unless it was
    /// requested and the model has all six axes.
    pub strapdown: Option<[Vec<StrapdownEnd>; UNAIDED_S.len()]>,
}

/// Residuals of one axis, in its unit; one value per evaluated row, NaN where unknown.
#[derive(Debug, Clone)]
pub struct AxisTrace {
    /// Measured error, offset included.
    pub measured: Vec<f64>,
    /// Measured minus one-step prediction, from measured history: the innovation.
    pub one_step: Vec<f64>,
    /// Measured minus prediction of a free run, which restarts from measured history every 60 s.
    pub coast: Vec<f64>,
    /// Mean square of measured minus prediction of a free run that is never restarted; NaN without a value.
    pub coast_whole_mse: f64,
    /// Squared errors after exactly the horizon, one per origin, for each of [`HORIZONS_S`](super::HORIZONS_S).
    pub horizons: [Vec<f64>; 3],
    /// Heading errors, rad, or position errors, m, at the ends of windows without aiding, for each length of
    /// [`UNAIDED_S`]; only windows in which the axis was measured throughout.
    pub unaided: [Vec<f64>; UNAIDED_S.len()],
    /// Number of rows whose prediction has a caution other than warming up or coasting.
    pub cautions: usize,
}

// Not generic over the numbers: every crate that calls them would compile the whole evaluation again.

/// Runs `model` over the recording behind `playback`, from its first row on to warm up, and keeps the residuals in
/// `rows`.
pub fn trace(model: &UnitModel, playback: &Playback<'_>, rows: Range<usize>) -> Result<Trace, ModelError> {
    run::<f64>(model, playback, rows, Coasted::AllRows)
}

/// Runs `model` like [`trace`], in the numbers of a device with an FPU.
pub fn trace_in_f32(
    model: &UnitModel,
    playback: &Playback<'_>,
    rows: Range<usize>,
) -> Result<Trace, ModelError> {
    run::<f32>(model, playback, rows, Coasted::AllRows)
}

/// Runs `model` like [`trace`], but keeps these free runs.
pub fn trace_of(
    model: &UnitModel,
    playback: &Playback<'_>,
    rows: Range<usize>,
    coasted: Coasted,
) -> Result<Trace, ModelError> {
    run::<f64>(model, playback, rows, coasted)
}

/// Free runs that are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coasted {
    /// Errors at the horizons: `coast` is empty, `coast_whole_mse` NaN.
    Horizons,
    /// Over all rows, at the horizons, and over windows without aiding.
    AllRows,
    /// The same, and a strapdown of the six axes over the windows.
    AllRowsAndStrapdown,
    /// Over the windows alone, with a strapdown: `coast` and `horizons` are empty, `coast_whole_mse` is NaN.
    Strapdown,
}

impl Coasted {
    fn keeps_rows(self) -> bool {
        matches!(self, Self::AllRows | Self::AllRowsAndStrapdown)
    }
}

fn run<R: Real>(
    model: &UnitModel,
    playback: &Playback<'_>,
    rows: Range<usize>,
    coasted: Coasted,
) -> Result<Trace, ModelError> {
    // a predictor's state is copied for every coast
    match model.with(SmallPredictor::<R>::new) {
        Ok(small) => Ok(Run::new(small, model, playback, rows, coasted).trace()),
        Err(_) => Ok(Run::new(model.predictor::<R>()?, model, playback, rows, coasted).trace()),
    }
}

/// One pass through a recording.
struct Run<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> {
    playback: &'p Playback<'a>,
    feed: Feed<'p, 'a, R>,
    origins: Origins,
    coasting: Coasting<'p, 'a, R, TERMS, HISTORY>,
    predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    coasted: Coasted,
    trace: Trace,
}

impl<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> Run<'p, 'a, R, TERMS, HISTORY> {
    fn new(
        predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        model: &UnitModel,
        playback: &'p Playback<'a>,
        rows: Range<usize>,
        coasted: Coasted,
    ) -> Self {
        let stretches = playback.still_stretches(rows.clone());
        let mut origins = Origins::new(&stretches, model.period_s);
        if !coasted.keeps_rows() {
            origins.blocks.clear();
        }
        match coasted {
            Coasted::Horizons => origins.windows.clear(),
            Coasted::Strapdown => origins.reaches.clear(),
            Coasted::AllRows | Coasted::AllRowsAndStrapdown => {}
        }
        let axes = model.axes.iter().map(|_| AxisTrace::with_rows(rows.len(), coasted)).collect();
        let trace = Trace { rows, period_s: model.period_s, stretches, axes, strapdown: None };
        let six = match coasted {
            Coasted::Horizons | Coasted::AllRows => None,
            Coasted::AllRowsAndStrapdown | Coasted::Strapdown => SixAxes::of(model),
        };
        let coasting = Coasting::new(model, playback, &origins, six);
        Self { playback, feed: playback.feed(), origins, coasting, predictor, coasted, trace }
    }

    fn trace(mut self) -> Trace {
        let rows = self.trace.rows.clone();
        for row in 0..rows.start {
            let _ = self.feed.step(&mut self.predictor, row);
        }
        let mut whole = Whole::new(self.predictor.clone(), self.coasting.is_held(), self.trace.axes.len());
        let (mut reaches, mut blocks, mut windows) = (
            std::mem::take(&mut self.origins.reaches).into_iter().peekable(),
            std::mem::take(&mut self.origins.blocks).into_iter().peekable(),
            std::mem::take(&mut self.origins.windows).into_iter().peekable(),
        );
        let start = rows.start;
        let keep_block = |axes: &mut Vec<AxisTrace>, row: usize, axis: usize, errors: &[f64]| {
            axes[axis].coast[row - start..][..errors.len()].copy_from_slice(errors);
        };
        for row in rows {
            if row.is_multiple_of(1024) {
                interrupt::check();
            }
            // from here on the predictor has seen all rows before this one, and none after
            if let Some(begin) = reaches.next_if(|(begin, _)| *begin == row) {
                self.coasting.begin(&self.predictor, begin);
            }
            if let Some(block) = blocks.next_if(|block| block.start == row) {
                let axes = &mut self.trace.axes;
                self.coasting.begin_block(&self.predictor, block, |row, axis, errors| {
                    keep_block(axes, row, axis, errors);
                });
            }
            while let Some(window) = windows.next_if(|(window, _)| window.start == row) {
                self.coasting.begin_window(&self.predictor, window);
            }
            if self.coasted.keeps_rows() {
                whole.coast(&mut self.feed, self.playback, row);
            }
            self.step(row);
        }
        let axes = &mut self.trace.axes;
        let (finished, strapdown) =
            self.coasting.finish(|row, axis, errors| keep_block(axes, row, axis, errors));
        for ((axis, finished), error) in axes.iter_mut().zip(finished).zip(whole.errors) {
            axis.coast_whole_mse = error.mean();
            axis.horizons = finished.squares;
            axis.unaided = finished.ends;
        }
        self.trace.strapdown = strapdown;
        self.trace
    }

    /// Predicts one row from measured history.
    fn step(&mut self, row: usize) {
        use fos_core::Validity;
        let at = row - self.trace.rows.start;
        let is_still = self.playback.is_still(row);
        let corrections = self.feed.step(&mut self.predictor, row);
        for ((number, axis), correction) in self.trace.axes.iter_mut().enumerate().zip(corrections) {
            if is_still {
                axis.measured[at] = self.playback.error(number, row);
            }
            let harmless = Validity::WARMING_UP | Validity::OWN_HISTORY | Validity::COASTING_TOO_LONG;
            if correction.validity | harmless != harmless {
                axis.cautions += 1;
            }
            if let Some(innovation) = correction.innovation
                && !correction.validity.intersects(Validity::OWN_HISTORY)
            {
                axis.one_step[at] = innovation.to_f64();
            }
        }
    }
}

/// Free run that is never restarted.
struct Whole<R: Real, const TERMS: usize, const HISTORY: usize> {
    predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    /// True while it holds its first prediction: the model does, and every row so far has a sample.
    is_held: bool,
    begun: bool,
    /// Squared errors of each axis in the rows at rest.
    errors: Vec<Squares>,
}

/// Sum of squares.
#[derive(Clone, Default)]
pub(super) struct Squares {
    sum: f64,
    n: usize,
}

impl Squares {
    /// Adds the square of `value` if that is finite.
    pub(super) fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.sum += value * value;
            self.n += 1;
        }
    }

    /// NaN without a value.
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.n as f64
    }
}

impl<R: Real, const TERMS: usize, const HISTORY: usize> Whole<R, TERMS, HISTORY> {
    fn new(predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>, is_held: bool, n_axes: usize) -> Self {
        Self { predictor, is_held, begun: false, errors: vec![Squares::default(); n_axes] }
    }

    #[inline]
    fn coast(&mut self, feed: &mut Feed<'_, '_, R>, playback: &Playback<'_>, row: usize) {
        self.is_held &= playback.missing_before(row) == 0 && playback.is_measured(row..row + 1);
        if !(self.is_held && self.begun) {
            self.begun = true;
            playback.catch_up(&mut self.predictor, row);
            let _ = feed.coast(&mut self.predictor, row);
        }
        if playback.is_still(row) {
            let corrections = self.predictor.corrections();
            for ((axis, errors), correction) in self.errors.iter_mut().enumerate().zip(corrections) {
                errors.add(playback.error(axis, row) - correction.predicted.to_f64());
            }
        }
    }
}

/// No rows.
impl Default for AxisTrace {
    fn default() -> Self {
        Self::with_rows(0, Coasted::Horizons)
    }
}

impl AxisTrace {
    fn with_rows(n_rows: usize, coasted: Coasted) -> Self {
        let unknown = || vec![f64::NAN; n_rows];
        Self {
            measured: unknown(),
            one_step: unknown(),
            coast: if coasted.keeps_rows() { unknown() } else { Vec::new() },
            coast_whole_mse: f64::NAN,
            horizons: Default::default(),
            unaided: Default::default(),
            cautions: 0,
        }
    }
}

impl Trace {
    /// Memory of the series of `n_rows` rows of `n_axes` axes, bytes.
    pub fn bytes(n_rows: usize, n_axes: usize) -> usize {
        const SERIES: usize = 3;
        n_rows * n_axes * SERIES * size_of::<f64>()
    }

    /// Converts the rows to those of a recording that lacks the first `rows`, none of which were evaluated.
    pub fn without_lead_in(mut self, rows: usize) -> Self {
        for range in self.stretches.iter_mut().chain([&mut self.rows]) {
            *range = range.start - rows..range.end - rows;
        }
        self
    }

    /// Returns the part within `rows` of the recording. `coast_whole_mse`, `horizons`, `unaided`, `strapdown` and `cautions`,
    /// which describe the whole, are empty.
    pub fn within(&self, rows: Range<usize>) -> Self {
        let start = rows.start.clamp(self.rows.start, self.rows.end);
        let rows = start..rows.end.clamp(start, self.rows.end);
        let part = |values: &[f64]| values[rows.start - self.rows.start..rows.end - self.rows.start].to_vec();
        let clipped = self.stretches.iter().map(|s| s.start.max(rows.start)..s.end.min(rows.end));
        Self {
            period_s: self.period_s,
            stretches: clipped.filter(|stretch| !stretch.is_empty()).collect(),
            strapdown: None,
            axes: self
                .axes
                .iter()
                .map(|axis| AxisTrace {
                    measured: part(&axis.measured),
                    one_step: part(&axis.one_step),
                    coast: part(&axis.coast),
                    ..AxisTrace::default()
                })
                .collect(),
            rows,
        }
    }

    /// Returns the finite values of `series` in contiguous parts, over which statistics may be computed.
    pub fn stretches_of<'s>(&self, series: &'s [f64]) -> Vec<&'s [f64]> {
        let mut parts = Vec::new();
        for stretch in &self.stretches {
            let values = &series[stretch.start - self.rows.start..stretch.end - self.rows.start];
            parts.extend(values.split(|value| !value.is_finite()).filter(|part| !part.is_empty()));
        }
        parts
    }
}
