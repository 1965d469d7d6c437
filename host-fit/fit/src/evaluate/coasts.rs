//! Free runs of a model (coasts) from many rows of a recording, and their errors.

use std::ops::Range;

use fos_core::{Coasts, Predictor, Real, y};
use pulp::{Arch, Simd, WithSimd};

use super::origins::Origins;
use super::strapdown::{SixAxes, Strapdown, StrapdownEnd};
use super::unaided::{Integral, UNAIDED_S};
use crate::model::{AXES, FittedAxis, FittedTerm, INPUTS, UnitModel};
use crate::playback::{Feed, Playback};
use fos_data::interrupt::{self, in_parallel};

/// Number of coasts that run side by side: twice as many as a processor computes at once.
const LANES: usize = 8;

/// Largest size of a group of lanes, bytes. Groups are made on the stack of a thread, which a larger one would
/// overflow: coasts of such a large model run one after the other.
const LARGEST_LANES: usize = 1 << 17;

/// Number of waiting groups of each length at which they are run: work for all cores, within some megabytes. Smaller
/// for blocks, which have an error in every row.
const AT_ONCE: [usize; LENGTHS] = [16, 8, 4, 2, 16, 8, 4, 2];

/// Index of the blocks among the lengths, after the horizons.
const BLOCKS: usize = 3;

/// Index of the first length of windows without aiding.
const WINDOWS: usize = BLOCKS + 1;

/// Number of lengths of coasts: horizons, blocks, windows without aiding.
const LENGTHS: usize = WINDOWS + UNAIDED_S.len();

/// Errors of a strapdown at the ends of windows, for each length of windows.
type Ends = [Vec<StrapdownEnd>; UNAIDED_S.len()];

/// Time over which a strapdown measures gravity at the start of a window, s.
const GRAVITY_S: f64 = 1.0;

/// Error of a coast: the row that it began in, the axis, the error.
type Left = (usize, usize, f64);

/// Errors of one axis after all coasts have run.
#[derive(Debug, Clone, Default)]
pub(super) struct Finished {
    /// Squared errors after exactly each horizon, in the square of the axis' unit.
    pub(super) squares: [Vec<f64>; 3],
    /// Errors at the ends of windows without aiding of each length, rad or m.
    pub(super) ends: [Vec<f64>; UNAIDED_S.len()],
}

/// Coasts of a model over a recording, some of them waiting to be run.
pub(super) struct Coasting<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> {
    playback: &'p Playback<'a>,
    feed: Feed<'p, 'a, R>,
    ticks: [usize; 3],
    /// True if a coast holds its first prediction.
    is_held: bool,
    /// Integration of the residual over windows without aiding, one entry per axis; none for an axis that is neither
    /// gyro nor accelerometer.
    integrals: Vec<Option<Integral>>,
    /// Places of the axes for a strapdown; none without one.
    six: Option<SixAxes>,
    period_s: f64,
    /// Waiting coasts by length: each horizon, blocks, each length of windows without aiding.
    waiting: [Waiting<R, TERMS, HISTORY>; LENGTHS],
    left: [Vec<Left>; 3],
    /// Integrated errors at the ends of windows, for each length of windows.
    ends: [Vec<Left>; UNAIDED_S.len()],
    /// First rows of windows, and the errors of a strapdown at their ends, for each length of windows.
    strapdown: [Vec<(usize, StrapdownEnd)>; UNAIDED_S.len()],
}

/// Errors of the window of one lane so far.
#[derive(Default)]
struct Window {
    /// Integral of each axis, rad or m.
    ends: Vec<f64>,
    /// Residual of each axis in the current row.
    residuals: Vec<f64>,
    strapdown: Option<Strapdown>,
}

/// Waiting coasts, each with no more than its initial state. The memory of coasts that have run is reused.
struct Waiting<R: Real, const TERMS: usize, const HISTORY: usize> {
    groups: Vec<Group<R, TERMS, HISTORY>>,
    /// Number of groups with at least one coast.
    n_begun: usize,
    /// Coasts that run sample by sample, outside the groups.
    alone: Vec<Alone<R, TERMS, HISTORY>>,
}

/// Coasts that run side by side, and the rows of each occupied lane.
struct Group<R: Real, const TERMS: usize, const HISTORY: usize> {
    coasts: Box<Coasts<R, LANES, AXES, INPUTS, TERMS, HISTORY>>,
    lanes: Vec<Range<usize>>,
}

/// Coast over `rows`, with the predictor that has seen all rows before.
struct Alone<R: Real, const TERMS: usize, const HISTORY: usize> {
    predictor: Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
    rows: Range<usize>,
}

impl<R: Real, const TERMS: usize, const HISTORY: usize> Waiting<R, TERMS, HISTORY> {
    const fn new() -> Self {
        Self { groups: Vec::new(), n_begun: 0, alone: Vec::new() }
    }

    /// Takes a coast over `rows` into a lane. Returns false if the history of `predictor` does not consist of
    /// measurements only.
    fn take(&mut self, predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>, rows: &Range<usize>) -> bool {
        let last = self.n_begun.checked_sub(1).and_then(|last| self.groups.get_mut(last));
        if let Some(group) = last.filter(|group| group.lanes.len() < LANES) {
            let has_begun = group.coasts.begin(group.lanes.len(), predictor);
            if has_begun {
                group.lanes.push(rows.clone());
            }
            return has_begun;
        }
        match self.groups.get_mut(self.n_begun) {
            Some(group) => {
                if !group.coasts.begin_all(predictor) {
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

    /// Returns true if there is work for all cores: so many full groups, or as many coasts outside them.
    fn is_full(&self, groups: usize) -> bool {
        let has_room = self.groups[..self.n_begun].last().is_none_or(|last| last.lanes.len() < LANES);
        self.n_begun == groups && !has_room || self.alone.len() == groups * LANES
    }
}

impl<R: Real, const TERMS: usize, const HISTORY: usize> Group<R, TERMS, HISTORY> {
    // keeps a new group out of the stack frame of callers that need none
    #[inline(never)]
    fn new(predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>, rows: &Range<usize>) -> Option<Self> {
        let coasts = Box::new(Coasts::new(predictor)?);
        Some(Self { coasts, lanes: vec![rows.clone()] })
    }
}

impl<'p, 'a, R: Real, const TERMS: usize, const HISTORY: usize> Coasting<'p, 'a, R, TERMS, HISTORY> {
    pub(super) fn new(
        model: &UnitModel,
        playback: &'p Playback<'a>,
        origins: &Origins,
        six: Option<SixAxes>,
    ) -> Self {
        Self {
            playback,
            feed: playback.feed(),
            ticks: origins.ticks,
            is_held: is_held(model),
            integrals: model.axes.iter().map(|axis| Integral::of(&axis.column)).collect(),
            six,
            period_s: model.period_s,
            waiting: [const { Waiting::new() }; LENGTHS],
            left: [const { Vec::new() }; 3],
            ends: [const { Vec::new() }; UNAIDED_S.len()],
            strapdown: [const { Vec::new() }; UNAIDED_S.len()],
        }
    }

    /// Returns true if a coast holds its first prediction as long as every row has a sample.
    pub(super) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Takes a coast of `reach` samples, one of the horizons, from `row` on; `predictor` has seen all rows before.
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

    /// Takes a coast over a block of rows; `predictor` has seen all rows before. `keep` gets the errors of an axis, one
    /// per row: the first row, the axis, and the errors, for this block and others that waited.
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

    /// Takes a window without aiding; `predictor` has seen all rows before, and `length` is an index into
    /// [`UNAIDED_S`].
    pub(super) fn begin_window(
        &mut self,
        predictor: &Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        (rows, length): (Range<usize>, usize),
    ) {
        if self.wait(predictor, rows, WINDOWS + length) {
            self.run_windows(length);
        }
    }

    /// Runs the coasts that still wait. Returns for each axis, in the order of the rows that the coasts began in, the
    /// squared errors after exactly each horizon and the errors at the ends of windows without aiding; then those of a
    /// strapdown, if the model has six axes. `keep` as for [`begin_block`](Self::begin_block).
    pub(super) fn finish(mut self, keep: impl FnMut(usize, usize, &[f64])) -> (Vec<Finished>, Option<Ends>) {
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
        let in_order = |mut ends: Vec<(usize, StrapdownEnd)>| -> Vec<StrapdownEnd> {
            ends.sort_by_key(|(row, _)| *row);
            ends.into_iter().map(|(_, end)| end).filter(StrapdownEnd::is_finite).collect()
        };
        (finished, self.six.map(|_| self.strapdown.map(in_order)))
    }

    /// Queues a coast. Returns true once there are as many as are run at once.
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

    /// Runs the waiting coasts to a horizon.
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

    /// Runs the waiting blocks.
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

    /// Runs the waiting windows without aiding of one length.
    fn run_windows(&mut self, length: usize) {
        let (integrals, six, period_s) = (self.integrals.clone(), self.six, self.period_s);
        let playback = self.playback;
        let n_axes = integrals.len();
        let left = self.run_waiting(
            WINDOWS + length,
            |_| true,
            |windows: &mut Vec<Window>, (rows, lane), axis, ahead, error| {
                if windows.len() <= lane {
                    windows.resize_with(lane + 1, Window::default);
                }
                let window = &mut windows[lane];
                if window.ends.is_empty() {
                    window.ends = vec![0.0; n_axes];
                    window.residuals = vec![0.0; n_axes];
                    let start = |axis| playback.measured_mean(axis, start_of(rows, period_s));
                    window.strapdown =
                        six.map(|six| Strapdown::new(six, six.accelerometers.map(start), period_s));
                }
                let weight =
                    integrals[axis].map_or(0.0, |integral| integral.weight(ahead, rows.len(), period_s));
                window.ends[axis] += weight * error;
                window.residuals[axis] = error;
                // the axes of a row come in their order
                if axis + 1 == n_axes
                    && let Some(strapdown) = &mut window.strapdown
                {
                    strapdown.step(&window.residuals);
                }
            },
        );
        for (lanes, windows) in left {
            for (rows, window) in lanes.iter().zip(windows) {
                let ends = window.ends.into_iter().enumerate();
                self.ends[length].extend(ends.map(|(axis, end)| (rows.start, axis, end)));
                let end = window.strapdown.map(|strapdown| (rows.start, strapdown.end()));
                self.strapdown[length].extend(end);
            }
        }
    }

    /// Runs the waiting coasts of one length on all cores. Returns for each group its rows and the result of `keep`,
    /// which gets the error of every sample whose offset `when` accepts: (rows and lane of a coast, axis, offset,
    /// error).
    fn run_waiting<T: Default + Send>(
        &mut self,
        length: usize,
        when: impl Fn(usize) -> bool + Sync,
        keep: impl Fn(&mut T, (&Range<usize>, usize), usize, usize, f64) + Sync,
    ) -> Vec<(Vec<Range<usize>>, T)> {
        let mut waiting = std::mem::replace(&mut self.waiting[length], Waiting::new());
        let side_by_side = in_parallel(waiting.groups[..waiting.n_begun].iter_mut(), |group| {
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
        // in their places: a predictor is large, and moving it would cost more than a step
        let of_alone = |Alone { predictor, rows }: &mut Alone<R, TERMS, HISTORY>| {
            let mut kept = T::default();
            self.alone(predictor, rows, &when, |axis, ahead, error| {
                keep(&mut kept, (rows, 0), axis, ahead, error);
            });
            (vec![rows.clone()], kept)
        };
        let alone: Vec<_> = match self.is_held {
            // one step each: not worth waiting for other threads, as this one would begin another trace meanwhile
            true => waiting.alone.iter_mut().map(of_alone).collect(),
            false => in_parallel(waiting.alone.iter_mut(), of_alone),
        };
        waiting.alone.clear();
        waiting.n_begun = 0;
        self.waiting[length] = waiting;
        side_by_side.into_iter().chain(alone).collect()
    }

    /// Runs one coast sample by sample.
    fn alone(
        &self,
        predictor: &mut Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        rows: &Range<usize>,
        when: impl Fn(usize) -> bool,
        mut keep: impl FnMut(usize, usize, f64),
    ) {
        let mut feed = self.feed.clone();
        let is_held = self.is_held && self.playback.is_measured(rows.clone());
        for (ahead, row) in rows.clone().enumerate() {
            if ahead == 0 || !is_held {
                let _ = feed.coast(predictor, row);
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

/// Coasts of a group over their rows, several of them per instruction.
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
        // lanes without a coast run as the first one; ended coasts stay in their last row, and their errors are dropped
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

/// Returns the rows at the start of a window in which gravity is measured.
fn start_of(rows: &Range<usize>, period_s: f64) -> Range<usize> {
    let n = ((GRAVITY_S / period_s).round() as usize).clamp(1, rows.len());
    rows.start..rows.start + n
}

/// Returns true if a coast of the model holds its first prediction while there are samples: a constant, or the last
/// value.
fn is_held(model: &UnitModel) -> bool {
    let is_last = |term: &FittedTerm| term.coefficient == 1.0 && term.factors == [y(1)];
    model.inputs.is_empty()
        && model.axes.iter().all(|FittedAxis { parameters, physical, stochastic, .. }| {
            physical.is_empty()
                && parameters.constant == 0.0
                && stochastic.len() <= 1
                && stochastic.iter().all(is_last)
                // a prediction that fades beyond the limit is not constant
                && parameters.coast_limit_s > f64::from(u32::MAX) * model.period_s
        })
}
