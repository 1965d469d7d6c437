//! Runs a model over a recording once and keeps what is left of the error: one-step, and from its own history.

use std::ops::Range;

use fos_core::{Correction, ModelError, Predictor, Real, y};
use rayon::prelude::*;

use crate::model::{AXES, FittedAxis, FittedTerm, INPUTS, SmallPredictor, UnitModel};
use crate::playback::{Feed, Playback};
use fos_data::interrupt;
use fos_data::recording::pieces;

/// Horizons of the coast error, s.
pub const HORIZONS_S: [f64; 3] = [1.0, 10.0, 60.0];

/// Steps spent on the coasts of one horizon. 2·10⁶ at 200 Hz are 10,000 coasts of 1 s or 166 of 60 s.
const STEPS_PER_HORIZON: usize = 2_000_000;

/// A coast begins so long after a stretch does, s, at most a quarter of it: it is to start from measured history, not
/// from the coast through the motion before.
const LEAD_S: f64 = 5.0;

/// Length of the coasts that follow one another over the whole recording, s: the longest horizon.
const BLOCK_S: f64 = 60.0;

/// What is left of the error of every axis.
#[derive(Debug, Clone)]
pub struct Trace {
    /// The rows that were judged.
    pub rows: Range<usize>,
    /// Sample period, s.
    pub period_s: f64,
    /// Gap-free stretches of still rows, those of the recording.
    pub stretches: Vec<Range<usize>>,
    /// One per axis of the model.
    pub axes: Vec<AxisTrace>,
}

/// What is left of the error of one axis, in its unit; one value per judged row, NaN where it is not known.
#[derive(Debug, Clone, Default)]
pub struct AxisTrace {
    /// Measured error, offset included.
    pub measured: Vec<f64>,
    /// Measured minus one-step prediction, from measured history: the innovation.
    pub one_step: Vec<f64>,
    /// Measured minus prediction from own history, starting anew from measured history every 60 s.
    pub coast: Vec<f64>,
    /// The same without ever starting anew.
    pub coast_whole: Vec<f64>,
    /// Squared errors after exactly the horizon, one per origin, for each of [`HORIZONS_S`].
    pub horizons: [Vec<f64>; 3],
    /// Rows whose prediction was given with a caution other than warming up or coasting.
    pub cautions: usize,
}

/// Runs `model` over the recording behind `playback`: from its first row, to warm up, and keeps what is left in `rows`.
///
/// # Errors
///
/// What fos-core finds wrong with the model.
pub fn trace<R: Real>(
    model: &UnitModel,
    playback: &Playback<'_>,
    rows: Range<usize>,
    progress: impl FnMut(usize),
) -> Result<Trace, ModelError> {
    // a predictor is copied for every coast
    match model.with(SmallPredictor::<R>::new) {
        Ok(small) => Ok(Run::new(small, model, playback, rows).trace(progress)),
        Err(_) => Ok(Run::new(model.predictor::<R>()?, model, playback, rows).trace(progress)),
    }
}

/// One way through a recording.
struct Run<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> {
    playback: &'p Playback<'a>,
    feed: Feed<'p, 'a, R>,
    origins: Origins,
    predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    /// A coast goes on as it begins.
    is_held: bool,
    trace: Trace,
}

/// A coast that is to begin in `row` and goes on for `reach` samples, and the predictor that has seen all rows before.
struct Coast<P> {
    predictor: P,
    row: usize,
    reach: usize,
}

/// Coasts that are run at once, beside one another: some megabytes of predictors at most.
const AT_ONCE: usize = 256;

impl<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> Run<'p, 'a, R, TERMS, HISTORY> {
    fn new(
        predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        model: &UnitModel,
        playback: &'p Playback<'a>,
        rows: Range<usize>,
    ) -> Self {
        let stretches = playback.still_stretches(rows.clone());
        let origins = Origins::new(&stretches, model.period_s);
        let axes = vec![AxisTrace::with_rows(rows.len()); model.axes.len()];
        let trace = Trace { rows, period_s: model.period_s, stretches, axes };
        let is_held = is_held(model);
        Self { playback, feed: playback.feed(), origins, predictor, is_held, trace }
    }

    fn trace(mut self, mut progress: impl FnMut(usize)) -> Trace {
        let rows = self.trace.rows.clone();
        for row in 0..rows.start {
            let _ = self.feed.step(&mut self.predictor, row);
        }
        let mut whole = self.predictor.clone();
        let mut block: Option<(Predictor<R, AXES, INPUTS, TERMS, HISTORY>, Range<usize>)> = None;
        let (mut reaches, mut blocks) = (
            std::mem::take(&mut self.origins.reaches).into_iter().peekable(),
            std::mem::take(&mut self.origins.blocks).into_iter().peekable(),
        );
        let mut waiting = Vec::with_capacity(AT_ONCE);
        for row in rows {
            if row.is_multiple_of(1024) {
                interrupt::check();
            }
            if row % 65_536 == 0 {
                progress(row);
            }
            // from here on the predictor has seen all rows before this one, and none after
            if let Some((row, reach)) = reaches.next_if(|(begin, _)| *begin == row) {
                waiting.push(Coast { predictor: self.predictor.clone(), row, reach });
                if waiting.len() == AT_ONCE {
                    self.coast(&mut waiting);
                }
            }
            if let Some(span) = blocks.next_if(|block| block.start == row) {
                block = Some((self.predictor.clone(), span));
            }
            if let Some((coasting, span)) = &mut block
                && span.contains(&row)
            {
                let corrections = self.feed.coast(coasting, row);
                self.trace.keep(self.playback, row, corrections, |axis| &mut axis.coast);
            }
            self.playback.catch_up(&mut whole, row);
            let corrections = self.feed.coast(&mut whole, row);
            if self.playback.is_still(row) {
                self.trace.keep(self.playback, row, corrections, |axis| &mut axis.coast_whole);
            }
            self.step(row);
        }
        self.coast(&mut waiting);
        self.trace
    }

    /// One row from measured history.
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

    /// Runs the coasts that wait, on all cores, and keeps what they leave at the horizons in the order of their rows.
    fn coast(&mut self, waiting: &mut Vec<Coast<Predictor<R, AXES, INPUTS, TERMS, HISTORY>>>) {
        let left_by = |mut coast: Coast<Predictor<R, AXES, INPUTS, TERMS, HISTORY>>| {
            let mut feed = self.feed.clone();
            let mut left = Vec::new();
            let is_held = self.is_held && self.playback.is_measured(coast.row..coast.row + coast.reach);
            for ahead in 0..coast.reach {
                let row = coast.row + ahead;
                if ahead == 0 || !is_held {
                    let _ = feed.coast(&mut coast.predictor, row);
                }
                if let Some(horizon) = self.origins.horizon_of(ahead + 1) {
                    let corrections = coast.predictor.corrections();
                    left.extend(corrections.iter().enumerate().map(|(axis, correction)| {
                        (horizon, axis, self.playback.error(axis, row) - correction.predicted.to_f64())
                    }));
                }
            }
            left
        };
        let left: Vec<Vec<(usize, usize, f64)>> = waiting.par_drain(..).map(left_by).collect();
        for (horizon, axis, left) in left.into_iter().flatten().filter(|(.., left)| left.is_finite()) {
            self.trace.axes[axis].horizons[horizon].push(left * left);
        }
    }
}

/// Whether a coast of the model goes on as it begins, while there are samples: a constant, or the last value.
fn is_held(model: &UnitModel) -> bool {
    let is_last = |term: &FittedTerm| term.coefficient == 1.0 && term.factors == [y(1)];
    model.inputs.is_empty()
        && model.axes.iter().all(|FittedAxis { parameters, physical, stochastic, .. }| {
            physical.is_empty()
                && parameters.constant == 0.0
                && stochastic.len() <= 1
                && stochastic.iter().all(is_last)
                // what fades, changes
                && parameters.coast_limit_s > f64::from(u32::MAX) * model.period_s
        })
}

impl AxisTrace {
    fn with_rows(n_rows: usize) -> Self {
        let unknown = || vec![f64::NAN; n_rows];
        Self {
            measured: unknown(),
            one_step: unknown(),
            coast: unknown(),
            coast_whole: unknown(),
            ..Self::default()
        }
    }
}

impl Trace {
    /// What `corrections` leave of the error in `row`, in one series of each axis.
    #[inline]
    fn keep<R: Real>(
        &mut self,
        playback: &Playback<'_>,
        row: usize,
        corrections: &[Correction<R>],
        series: impl Fn(&mut AxisTrace) -> &mut Vec<f64>,
    ) {
        let at = row - self.rows.start;
        for ((number, axis), correction) in self.axes.iter_mut().enumerate().zip(corrections) {
            series(axis)[at] = playback.error(number, row) - correction.predicted.to_f64();
        }
    }

    /// The part of it in `rows` of the recording, but for what is only looked at as a whole.
    pub fn within(&self, rows: Range<usize>) -> Self {
        let start = rows.start.clamp(self.rows.start, self.rows.end);
        let rows = start..rows.end.clamp(start, self.rows.end);
        let part = |values: &[f64]| values[rows.start - self.rows.start..rows.end - self.rows.start].to_vec();
        let clipped = self.stretches.iter().map(|s| s.start.max(rows.start)..s.end.min(rows.end));
        Self {
            period_s: self.period_s,
            stretches: clipped.filter(|stretch| !stretch.is_empty()).collect(),
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

    /// The finite values of `series` in stretches without a break: what statistics may be computed over.
    pub fn stretches_of<'s>(&self, series: &'s [f64]) -> Vec<&'s [f64]> {
        let mut parts = Vec::new();
        for stretch in &self.stretches {
            let values = &series[stretch.start - self.rows.start..stretch.end - self.rows.start];
            parts.extend(values.split(|value| !value.is_finite()).filter(|part| !part.is_empty()));
        }
        parts
    }
}

/// From which rows to coast, and how far: evenly spread, every coast inside one still stretch.
struct Origins {
    ticks: [usize; 3],
    /// (row, ticks), sorted by row.
    reaches: Vec<(usize, usize)>,
    /// Consecutive coasts that cover the stretches.
    blocks: Vec<Range<usize>>,
}

impl Origins {
    fn new(stretches: &[Range<usize>], period_s: f64) -> Self {
        let ticks = HORIZONS_S.map(|horizon| ((horizon / period_s).round() as usize).max(1));
        let lead = (LEAD_S / period_s) as usize;
        let after_lead = |stretch: &Range<usize>| stretch.start + lead.min(stretch.len() / 4)..stretch.end;
        let stretches: Vec<Range<usize>> = stretches.iter().map(after_lead).collect();
        let mut reaches = Vec::new();
        for ticks in ticks {
            let places = |stretch: &Range<usize>| (stretch.len() + 1).saturating_sub(ticks);
            let available: usize = stretches.iter().map(places).sum();
            let wanted = (STEPS_PER_HORIZON / ticks).max(1);
            let spacing = available.div_ceil(wanted).max(1);
            for stretch in &stretches {
                reaches.extend(
                    (0..places(stretch)).step_by(spacing).map(|place| (stretch.start + place, ticks)),
                );
            }
        }
        reaches.sort_unstable();
        // where several start in one row, the longest passes through the shorter ones
        reaches.dedup_by(|later, kept| {
            let same = later.0 == kept.0;
            if same {
                kept.1 = kept.1.max(later.1);
            }
            same
        });
        let block = ((BLOCK_S / period_s).round() as usize).max(1);
        let blocks = pieces(&stretches, block);
        Self { ticks, reaches, blocks }
    }

    fn horizon_of(&self, ticks: usize) -> Option<usize> {
        self.ticks.iter().position(|horizon| *horizon == ticks)
    }
}
