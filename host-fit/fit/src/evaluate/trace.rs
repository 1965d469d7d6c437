//! Runs a model over a recording once and keeps what is left of the error: one-step, and from its own history.

use std::ops::Range;

use fos_core::{ModelError, Real};

use crate::model::{HostPredictor, UnitModel};
use crate::playback::Playback;
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
    mut progress: impl FnMut(usize),
) -> Result<Trace, ModelError> {
    let mut predictor: HostPredictor<R> = model.predictor()?;
    let stretches = playback.still_stretches(rows.clone());
    let origins = Origins::new(&stretches, model.period_s);
    let mut axes = vec![AxisTrace::with_rows(rows.len()); model.axes.len()];
    for row in 0..rows.start {
        let _ = playback.step(&mut predictor, row);
    }
    let mut whole = predictor.clone();
    let mut block: Option<(HostPredictor<R>, Range<usize>)> = None;
    for row in rows.clone() {
        let at = row - rows.start;
        if row.is_multiple_of(1024) {
            interrupt::check();
        }
        if row % 65_536 == 0 {
            progress(row);
        }
        // from here on `predictor` has seen all rows before this one, and none after
        if let Some(reach) = origins.reach(row) {
            let mut coasting = predictor.clone();
            for ahead in 0..reach {
                let corrections = playback.coast(&mut coasting, row + ahead);
                if let Some(horizon) = origins.horizon_of(ahead + 1) {
                    for (axis, correction) in corrections.iter().enumerate() {
                        let left = playback.error(axis, row + ahead) - correction.predicted.to_f64();
                        if left.is_finite() {
                            axes[axis].horizons[horizon].push(left * left);
                        }
                    }
                }
            }
        }
        if let Some(span) = origins.block_at(row) {
            block = Some((predictor.clone(), span));
        }
        if let Some((coasting, span)) = &mut block
            && span.contains(&row)
        {
            for (axis, correction) in playback.coast(coasting, row).iter().enumerate() {
                axes[axis].coast[at] = playback.error(axis, row) - correction.predicted.to_f64();
            }
        }
        playback.catch_up(&mut whole, row);
        for (axis, correction) in playback.coast(&mut whole, row).iter().enumerate() {
            if playback.is_still(row) {
                axes[axis].coast_whole[at] = playback.error(axis, row) - correction.predicted.to_f64();
                axes[axis].measured[at] = playback.error(axis, row);
            }
        }
        for (axis, correction) in playback.step(&mut predictor, row).iter().enumerate() {
            use fos_core::Validity;
            let harmless = Validity::WARMING_UP | Validity::OWN_HISTORY | Validity::COASTING_TOO_LONG;
            if correction.validity | harmless != harmless {
                axes[axis].cautions += 1;
            }
            if let Some(innovation) = correction.innovation
                && !correction.validity.intersects(Validity::OWN_HISTORY)
            {
                axes[axis].one_step[at] = innovation.to_f64();
            }
        }
    }
    Ok(Trace { rows, period_s: model.period_s, stretches, axes })
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

    fn reach(&self, row: usize) -> Option<usize> {
        let found = self.reaches.binary_search_by_key(&row, |(row, _)| *row).ok()?;
        Some(self.reaches[found].1)
    }

    fn horizon_of(&self, ticks: usize) -> Option<usize> {
        self.ticks.iter().position(|horizon| *horizon == ticks)
    }

    fn block_at(&self, row: usize) -> Option<Range<usize>> {
        let found = self.blocks.binary_search_by_key(&row, |block| block.start).ok()?;
        Some(self.blocks[found].clone())
    }
}
