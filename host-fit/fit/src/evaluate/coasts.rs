//! Coasts from many rows of a recording, and what each leaves of the error.

use std::ops::Range;

use fos_core::{Coasts, Predictor, Real, y};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::origins::Origins;
use super::unaided::{Integral, UNAIDED_S};
use crate::model::{AXES, FittedAxis, FittedTerm, INPUTS, UnitModel};
use crate::playback::{Feed, Playback};
use fos_data::interrupt::{self, in_parallel};

/// Coasts that run side by side: what a processor computes at once, twice.
const LANES: usize = 8;

/// Lanes that take more than this, bytes, would not fit onto the stack of a thread, on which they are made: coasts of a model
/// that is so large run one after the other.
const LARGEST_LANES: usize = 1 << 17;

/// Coasts wait until there are so many groups of one length: work for all cores, of some megabytes. Of blocks, which leave an
/// error in every row, fewer.
const AT_ONCE: [usize; LENGTHS] = [16, 8, 4, 2, 16, 8, 4, 2];

/// The length of blocks, beside those of the horizons.
const BLOCKS: usize = 3;

/// The first length of windows without aiding.
const WINDOWS: usize = BLOCKS + 1;

/// Lengths of coasts: those of the horizons, of blocks, of windows without aiding.
const LENGTHS: usize = WINDOWS + UNAIDED_S.len();

/// What a coast leaves of the error at a horizon: the row that it began in, the axis, the error.
type Left = (usize, usize, f64);

/// The errors of one axis that are left when all coasts have run.
#[derive(Debug, Clone, Default)]
pub(super) struct Finished {
    /// Squared errors after exactly each horizon.
    pub(super) squares: [Vec<f64>; 3],
    /// Errors at the ends of windows without aiding of each length, rad or m.
    pub(super) ends: [Vec<f64>; UNAIDED_S.len()],
}

/// The coasts of a model over a recording, of which some wait to be run.
pub(super) struct Coasting<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> {
    playback: &'p Playback<'a>,
    feed: Feed<'p, 'a, R>,
    ticks: [usize; 3],
    /// A coast goes on as it begins.
    is_held: bool,
    /// Of each axis, how windows without aiding are integrated.
    integrals: Vec<Option<Integral>>,
    period_s: f64,
    /// Those to each horizon, blocks, and windows without aiding.
    waiting: [Waiting<R, TERMS, HISTORY>; LENGTHS],
    left: [Vec<Left>; 3],
    /// Of each length of windows, the integrated errors at their ends.
    ends: [Vec<Left>; UNAIDED_S.len()],
}

/// Coasts that wait: of each what it begins from and no more. The room of those that have been run is used again.
struct Waiting<R: Real, const TERMS: usize, const HISTORY: usize> {
    groups: Vec<Group<R, TERMS, HISTORY>>,
    /// Groups with a coast in them.
    n_begun: usize,
    /// Those to be looked at sample by sample.
    alone: Vec<Alone<R, TERMS, HISTORY>>,
}

/// Coasts side by side, and the rows of each lane that has one.
struct Group<R: Real, const TERMS: usize, const HISTORY: usize> {
    coasts: Box<Coasts<R, LANES, AXES, INPUTS, TERMS, HISTORY>>,
    lanes: Vec<Range<usize>>,
}

/// A coast over `rows`, and the predictor that has seen all rows before.
struct Alone<R: Real, const TERMS: usize, const HISTORY: usize> {
    predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    rows: Range<usize>,
}

impl<R: Real, const TERMS: usize, const HISTORY: usize> Waiting<R, TERMS, HISTORY> {
    const fn new() -> Self {
        Self { groups: Vec::new(), n_begun: 0, alone: Vec::new() }
    }

    /// Takes a coast over `rows` into a lane. Whether it could.
    fn take(&mut self, predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>, rows: &Range<usize>) -> bool {
        let evaluator = predictor.evaluator();
        let last = self.n_begun.checked_sub(1).and_then(|last| self.groups.get_mut(last));
        if let Some(group) = last.filter(|group| group.lanes.len() < LANES) {
            let has_begun = group.coasts.begin(group.lanes.len(), evaluator);
            if has_begun {
                group.lanes.push(rows.clone());
            }
            return has_begun;
        }
        match self.groups.get_mut(self.n_begun) {
            Some(group) => {
                if !group.coasts.begin_all(evaluator) {
                    return false;
                }
                group.lanes.push(rows.clone());
            }
            None => {
                let Some(group) = Group::new(predictor, rows) else { return false };
                self.groups.push(group);
            }
        }
        self.n_begun += 1;
        true
    }

    /// Whether there is work for all cores.
    fn is_full(&self, groups: usize) -> bool {
        let has_room = self.groups[..self.n_begun].last().is_none_or(|last| last.lanes.len() < LANES);
        self.n_begun == groups && !has_room || self.alone.len() == groups * LANES
    }
}

impl<R: Real, const TERMS: usize, const HISTORY: usize> Group<R, TERMS, HISTORY> {
    // not part of the frame of what does without
    #[inline(never)]
    fn new(predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>, rows: &Range<usize>) -> Option<Self> {
        let coasts = Box::new(Coasts::new(predictor.evaluator())?);
        Some(Self { coasts, lanes: vec![rows.clone()] })
    }
}

impl<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> Coasting<'p, 'a, R, TERMS, HISTORY> {
    pub(super) fn new(model: &UnitModel, playback: &'p Playback<'a>, origins: &Origins) -> Self {
        Self {
            playback,
            feed: playback.feed(),
            ticks: origins.ticks,
            is_held: is_held(model),
            integrals: model.axes.iter().map(|axis| Integral::of(&axis.column)).collect(),
            period_s: model.period_s,
            waiting: [const { Waiting::new() }; LENGTHS],
            left: [const { Vec::new() }; 3],
            ends: [const { Vec::new() }; UNAIDED_S.len()],
        }
    }

    /// Whether a coast goes on as it begins, as long as there is a sample in every row.
    pub(super) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Takes a coast of `reach` samples from `row` on, before which `predictor` has seen all rows.
    pub(super) fn begin(
        &mut self,
        predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        (row, reach): (usize, usize),
    ) {
        let Some(length) = self.horizon_of(reach) else { return };
        if self.wait(predictor, row..row + reach, length) {
            self.run(length);
        }
    }

    /// Takes a coast over a block of rows, before which `predictor` has seen all. `keep` gets what is left in each row of an axis:
    /// the first row, the axis, and the errors, of this block and others that waited.
    pub(super) fn begin_block(
        &mut self,
        predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        rows: Range<usize>,
        keep: impl FnMut(usize, usize, &[f64]),
    ) {
        if self.wait(predictor, rows, BLOCKS) {
            self.run_blocks(keep);
        }
    }

    /// Takes a window without aiding, before which `predictor` has seen all rows; `length` as in [`UNAIDED_S`].
    pub(super) fn begin_window(
        &mut self,
        predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        (rows, length): (Range<usize>, usize),
    ) {
        if self.wait(predictor, rows, WINDOWS + length) {
            self.run_windows(length);
        }
    }

    /// Runs the coasts that still wait. Of each axis, in the order of the rows that the coasts began in: squared errors
    /// after exactly each horizon, and the errors at the ends of windows without aiding. `keep` as for
    /// [`begin_block`](Self::begin_block).
    pub(super) fn finish(mut self, keep: impl FnMut(usize, usize, &[f64])) -> Vec<Finished> {
        (0..self.ticks.len()).for_each(|length| self.run(length));
        self.run_blocks(keep);
        (0..UNAIDED_S.len()).for_each(|length| self.run_windows(length));
        let mut finished = vec![Finished::default(); self.integrals.len()];
        for (horizon, mut left) in self.left.into_iter().enumerate() {
            left.sort_by_key(|(row, ..)| *row);
            for (_, axis, left) in left.into_iter().filter(|(.., left)| left.is_finite()) {
                finished[axis].squares[horizon].push(left * left);
            }
        }
        for (length, mut ends) in self.ends.into_iter().enumerate() {
            ends.sort_by_key(|(row, ..)| *row);
            for (_, axis, end) in ends.into_iter().filter(|(.., end)| end.is_finite()) {
                finished[axis].ends[length].push(end);
            }
        }
        finished
    }

    /// Whether there wait as many now as are run at once.
    fn wait(
        &mut self,
        predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        rows: Range<usize>,
        length: usize,
    ) -> bool {
        let fits = size_of::<Coasts<R, LANES, AXES, INPUTS, TERMS, HISTORY>>() <= LARGEST_LANES;
        let may_stand_in_a_lane = fits && !self.is_held && self.playback.is_measured(rows.clone());
        let waiting = &mut self.waiting[length];
        if !may_stand_in_a_lane || !waiting.take(predictor, &rows) {
            waiting.alone.push(Alone { predictor: predictor.clone(), rows });
        }
        waiting.is_full(AT_ONCE[length])
    }

    /// Runs the coasts that wait for a horizon.
    fn run(&mut self, length: usize) {
        let ticks = self.ticks;
        let horizon_of = |ahead: usize| ticks.iter().position(|ticks| *ticks == ahead + 1);
        let left = self.run_waiting(
            length,
            |ahead| horizon_of(ahead).is_some(),
            |kept: &mut Vec<(usize, Left)>, (rows, _), axis, ahead, error| {
                if let Some(horizon) = horizon_of(ahead) {
                    kept.push((horizon, (rows.start, axis, error)));
                }
            },
        );
        for (horizon, left) in left.into_iter().flat_map(|(_, left)| left) {
            self.left[horizon].push(left);
        }
    }

    /// Runs the blocks that wait.
    fn run_blocks(&mut self, mut keep: impl FnMut(usize, usize, &[f64])) {
        let n_axes = self.integrals.len();
        let left = self.run_waiting(
            BLOCKS,
            |_| true,
            |kept: &mut Vec<Vec<f64>>, (rows, lane), axis, ahead, error| {
                if kept.len() <= lane * n_axes + axis {
                    kept.resize_with((lane + 1) * n_axes, || Vec::with_capacity(rows.len()));
                }
                if ahead < rows.len() {
                    kept[lane * n_axes + axis].push(error);
                }
            },
        );
        for (lanes, errors) in left {
            for (index, errors) in errors.iter().enumerate() {
                keep(lanes[index / n_axes].start, index % n_axes, errors);
            }
        }
    }

    /// Runs the windows without aiding of a length that wait.
    fn run_windows(&mut self, length: usize) {
        let (integrals, period_s) = (self.integrals.clone(), self.period_s);
        let n_axes = integrals.len();
        let left = self.run_waiting(
            WINDOWS + length,
            |_| true,
            |ends: &mut Vec<f64>, (rows, lane), axis, ahead, error| {
                ends.resize(ends.len().max((lane + 1) * n_axes), 0.0);
                let weight =
                    integrals[axis].map_or(0.0, |integral| integral.weight(ahead, rows.len(), period_s));
                ends[lane * n_axes + axis] += weight * error;
            },
        );
        for (lanes, ends) in left {
            for (index, end) in ends.into_iter().enumerate() {
                self.ends[length].push((lanes[index / n_axes].start, index % n_axes, end));
            }
        }
    }

    /// Runs the coasts that wait for a length, on all cores: of each group its rows and what `keep` makes of the errors, which it
    /// gets `when` so many samples lie before: (rows and lane of a coast, axis, samples before, error).
    fn run_waiting<T: Default + Send>(
        &mut self,
        length: usize,
        when: impl Fn(usize) -> bool + Sync,
        keep: impl Fn(&mut T, (&Range<usize>, usize), usize, usize, f64) + Sync,
    ) -> Vec<(Vec<Range<usize>>, T)> {
        let mut waiting = std::mem::replace(&mut self.waiting[length], Waiting::new());
        let side_by_side = in_parallel(waiting.groups[..waiting.n_begun].par_iter_mut(), |group| {
            let lanes = std::mem::take(&mut group.lanes);
            let mut kept = T::default();
            Arch::new().dispatch(SideBySide {
                playback: self.playback,
                coasts: &mut group.coasts,
                lanes: &lanes,
                when: &when,
                keep: |lane: usize, axis, ahead, error| {
                    keep(&mut kept, (&lanes[lane], lane), axis, ahead, error);
                },
            });
            (lanes, kept)
        });
        let of_alone = |Alone { predictor, rows }| {
            let mut kept = T::default();
            self.alone(predictor, &rows, &when, |axis, ahead, error| {
                keep(&mut kept, (&rows, 0), axis, ahead, error);
            });
            (vec![rows], kept)
        };
        let alone: Vec<_> = match self.is_held {
            // one step each: nothing to wait for others with, who would begin a trace of their own meanwhile
            true => waiting.alone.drain(..).map(of_alone).collect(),
            false => in_parallel(waiting.alone.par_drain(..), of_alone),
        };
        waiting.n_begun = 0;
        self.waiting[length] = waiting;
        side_by_side.into_iter().chain(alone).collect()
    }

    /// One coast, sample by sample.
    fn alone(
        &self,
        mut predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        rows: &Range<usize>,
        when: impl Fn(usize) -> bool,
        mut keep: impl FnMut(usize, usize, f64),
    ) {
        let mut feed = self.feed.clone();
        let is_held = self.is_held && self.playback.is_measured(rows.clone());
        for (ahead, row) in rows.clone().enumerate() {
            if ahead == 0 || !is_held {
                let _ = feed.coast(&mut predictor, row);
            }
            if !when(ahead) {
                continue;
            }
            for (axis, correction) in predictor.corrections().iter().enumerate() {
                keep(axis, ahead, self.playback.error(axis, row) - correction.predicted.to_f64());
            }
        }
    }

    fn horizon_of(&self, ticks: usize) -> Option<usize> {
        self.ticks.iter().position(|horizon| *horizon == ticks)
    }
}

/// The coasts of a group over their rows, by one instruction for several of them.
struct SideBySide<'s, 'a, R: Real, W, K, const TERMS: usize, const HISTORY: usize> {
    playback: &'s Playback<'a>,
    coasts: &'s mut Coasts<R, LANES, AXES, INPUTS, TERMS, HISTORY>,
    lanes: &'s [Range<usize>],
    when: W,
    keep: K,
}

impl<R: Real, W, K, const TERMS: usize, const HISTORY: usize> WithSimd
    for SideBySide<'_, '_, R, W, K, TERMS, HISTORY>
where
    W: Fn(usize) -> bool,
    K: FnMut(usize, usize, usize, f64),
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { playback, coasts, lanes, when, mut keep } = self;
        let Some(first) = lanes.first() else { return };
        let reach = lanes.iter().map(Range::len).fold(0, usize::max);
        // lanes without a coast run as the first; those that have ended stay in their last row, of which nothing is kept
        let mut of: [&Range<usize>; LANES] = [first; LANES];
        of.iter_mut().zip(lanes).for_each(|(of, rows)| *of = rows);
        let mut quantities = vec![[R::ZERO; LANES]; playback.n_quantities()];
        for ahead in 0..reach {
            if ahead.is_multiple_of(1024) {
                interrupt::check();
            }
            for (number, values) in quantities.iter_mut().enumerate() {
                for (value, rows) in values.iter_mut().zip(of) {
                    *value = R::from_f64(playback.quantity(number, (rows.start + ahead).min(rows.end - 1)));
                }
            }
            let predicted = coasts.step(&quantities);
            if !when(ahead) {
                continue;
            }
            for (lane, rows) in lanes.iter().enumerate().filter(|(_, rows)| ahead < rows.len()) {
                for (axis, predicted) in predicted.iter().enumerate() {
                    let error = playback.error(axis, rows.start + ahead);
                    keep(lane, axis, ahead, error - predicted[lane].to_f64());
                }
            }
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
