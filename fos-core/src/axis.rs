//! State of one axis: turns the measured and predicted value of a sample into a correction and the next history entry.

use core::hint::cold_path;

use crate::exponential::exp_m1;
use crate::model::AxisParameters;
use crate::program::{Part, Uses};
use crate::real::scalar;
use crate::{Range, Real, Scalar, Validity};

/// Widening of the fitted range of the remainder on either side, as a share of its width, before a value is limited:
/// half the width on either side doubles the range. The extreme of a normal record of 10⁴ samples is 3.9 σ, of 10¹⁰ samples
/// 6.5 σ: less than twice as far out, so noise alone is never limited.
pub(crate) const RANGE_MARGIN: f64 = 0.5;

/// Gain below which the fading stochastic part is set to 0, so that the gain never becomes subnormal.
const FADED: f64 = 1e-6;

/// Output of a [`Predictor`](crate::Predictor) for one axis and one sample.
#[must_use = "carries whether the corrected value can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Correction<R> {
    /// Predicted and subtracted error, offset included, in the axis' unit.
    pub predicted: R,
    /// Measured error minus predicted error, in the axis' unit; `None` unless the true value is known and the history is
    /// full.
    pub innovation: Option<R>,
    /// Measured value minus predicted error, in the axis' unit; the previous one if there was no finite sample.
    pub corrected: R,
    /// Reasons not to trust the values above.
    pub validity: Validity,
}

impl<R: Scalar> Correction<R> {
    /// Correction before the first sample.
    pub const NONE: Self =
        Self { predicted: R::ZERO, innovation: None, corrected: R::ZERO, validity: Validity::WARMING_UP };

    /// The correction in the float of the model.
    #[inline(always)]
    pub fn stored(&self) -> Correction<R::Stored> {
        Correction {
            predicted: self.predicted.stored(),
            innovation: self.innovation.map(R::stored),
            corrected: self.corrected.stored(),
            validity: self.validity,
        }
    }
}

/// Constants of an axis for the hot path, and its state.
#[derive(Debug, Clone)]
pub(crate) struct RunningAxis<R: Scalar> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    /// Bit i is set if a term uses input i.
    pub(crate) inputs_used: u32,
    /// Longest lag: samples that the history must hold before the terms can be evaluated.
    depth: u16,
    pub(crate) reference: R,
    offset: R,
    scale: R::Gain,
    per_scale: R::Gain,
    range: Range<R>,
    physical_range: Range<R>,
    /// Range of the remainder, against the model's own reference, in which the measured value is certainly below full
    /// scale and the remainder within its limits.
    fast_path_range: Range<R>,
    full_scale: R,
    /// Wider than the count, so that a disabled test never triggers.
    stuck_after_repeats: u32,
    gap_limit_samples: u8,
    coast_limit: u32,
    fade: R::Gain,

    /// p at this tick.
    pub(crate) p: R,
    /// r̂ at this tick, before it is limited.
    pub(crate) predicted_remainder: R,
    /// p went beyond its limits at this tick.
    limited: bool,
    /// r(n − 1), limited; 0 while it is not known.
    pub(crate) remainder: R,
    /// A remainder is available since the start or restart.
    known: bool,
    /// The history holds only measurements, and no counter below needs a reset: the usual state at rest.
    steady: bool,
    last_measured: R,
    repeats: u16,
    /// Consecutive measured samples up to now.
    measured_run: u16,
    ready: bool,
    missing: u8,
    coasted: u32,
    gain: R,
    corrected: R,
}

/// The compiled terms of an axis.
pub(crate) struct AxisProgram<R> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    pub(crate) uses: Uses,
}

impl<R: Scalar> RunningAxis<R> {
    /// Needs a call of [`begin`](Self::begin) at its final place.
    #[inline(never)]
    pub(crate) fn new(
        parameters: &AxisParameters<R::Stored>,
        program: AxisProgram<R>,
        period_s: f64,
    ) -> Self {
        // abs: a limit of −0 would turn the sign of the fading
        let coast_limit_s: R::Built = scalar(parameters.coast_limit_s.abs());
        let (scale, period_s): (R::Built, R::Built) = (scalar(parameters.scale), scalar(period_s));
        let full_scale = R::of(parameters.full_scale);
        Self {
            physical: program.physical,
            stochastic: program.stochastic,
            inputs_used: program.uses.inputs,
            depth: program.uses.depth,
            reference: R::of(parameters.reference),
            offset: R::of(parameters.offset),
            scale: R::gain(scale.to_f64()),
            per_scale: R::gain((R::Built::ONE / scale).to_f64()),
            range: Self::limits(parameters).convert(),
            physical_range: parameters.physical_limits().convert(),
            fast_path_range: Range::new(R::ONE, R::ZERO),
            full_scale: if full_scale > R::ZERO { full_scale } else { R::MAX },
            stuck_after_repeats: match parameters.stuck_after_repeats {
                0 => u32::MAX,
                repeats => u32::from(repeats),
            },
            gap_limit_samples: parameters.gap_limit_samples,
            coast_limit: (coast_limit_s / period_s).to_u32(),
            fade: R::gain((R::Built::ONE + exp_m1(-period_s / coast_limit_s)).to_f64()),
            p: R::ZERO,
            predicted_remainder: R::ZERO,
            limited: false,
            remainder: R::ZERO,
            known: false,
            steady: false,
            last_measured: R::ZERO,
            repeats: 0,
            measured_run: 0,
            ready: false,
            missing: 0,
            coasted: 0,
            gain: R::ONE,
            corrected: R::ZERO,
        }
    }

    /// Limits of the remainder, measured or predicted.
    pub(crate) fn limits(parameters: &AxisParameters<R::Stored>) -> Range<R::Stored> {
        parameters.range.widened(R::Stored::from_f64(RANGE_MARGIN))
    }

    /// Limits p; returns true if p was outside. p is finite, because the inputs are within their limits.
    #[inline(always)]
    pub(crate) fn limit_physical(&mut self) -> bool {
        let Range { low, high } = self.physical_range;
        self.p = if self.p > high {
            high
        } else if self.p < low {
            low
        } else {
            return false;
        };
        self.limited = true;
        true
    }

    /// Returns the reason not to trust p and clears it.
    pub(crate) fn take_limited(&mut self) -> Validity {
        Validity::when(core::mem::take(&mut self.limited), Validity::INPUT_OUT_OF_RANGE)
    }

    pub(crate) fn limit_full_scale(&mut self, full_scale: R) {
        if full_scale > R::ZERO && full_scale < self.full_scale {
            self.full_scale = full_scale;
            self.update_fast_path_range();
        }
    }

    /// Sets the fast path to the whole range of the remainder if no value in it can be at full scale; otherwise to an
    /// empty range, so that every sample is compared with full scale.
    fn update_fast_path_range(&mut self) {
        let built = |value: R| -> R::Built { scalar(value) };
        let p = if self.physical.is_empty { R::ZERO } else { self.physical_range.magnitude() };
        let scale: R::Built = scalar(R::gain_to_f64(self.scale));
        let error = scale * (built(self.range.magnitude()) + built(p));
        let furthest = built(self.reference.abs()) + built(self.offset.abs()) + error;
        // allowance for rounding
        let below = furthest * R::Built::from_f64(1.000_01) < built(self.full_scale);
        self.fast_path_range = if below { self.range } else { Range::new(R::ONE, R::ZERO) };
    }

    /// Initialises the axis in place: a second copy of an axis would need much stack.
    pub(crate) fn begin(&mut self) {
        self.update_fast_path_range();
        self.reset();
    }

    /// Returns to the state before the first sample.
    pub(crate) fn reset(&mut self) {
        self.restart(0);
        (self.repeats, self.missing, self.coasted, self.gain) = (0, 0, 0, R::ONE);
        self.corrected = self.reference;
        // equals nothing, so that the first sample is no repetition
        self.last_measured = R::NAN;
    }

    /// Discards the history after too many missing samples, `ticks` of which were skipped; the axis warms up again. A
    /// stochastic part that had begun to fade is set to 0.
    #[cold]
    pub(crate) fn restart(&mut self, ticks: u32) {
        (self.measured_run, self.missing) = (0, self.gap_limit_samples);
        self.ready = self.depth == 0;
        (self.remainder, self.known, self.steady) = (R::ZERO, false, false);
        self.coasted = self.coasted.saturating_add(ticks);
        if self.coasted > self.coast_limit {
            self.gain = R::ZERO;
        }
    }

    /// The larger of gap limit and longest lag, ticks: in a gap, the axis reaches a steady state after them.
    pub(crate) fn settling_ticks(&self) -> u32 {
        u32::from(self.depth.max(u16::from(self.gap_limit_samples)))
    }

    /// r(n − 1), limited. `None` before the first sample, in a gap beyond the limit, and after it until the history is
    /// full again.
    pub(crate) fn remainder(&self) -> Option<R> {
        self.known.then_some(self.remainder)
    }

    /// Processes a sample whose true value is the model's own reference.
    ///
    /// A sample without fault takes the fast path: the measurement enters the history.
    #[inline(always)]
    pub(crate) fn track(&mut self, measured: R, correction: &mut Correction<R>) {
        let remainder = self.remainder_of(measured, self.reference);
        if !(self.is_fresh(measured)
            && !measured.is_absent()
            && self.fast_path_range.contains(remainder)
            && self.steady)
        {
            return self.track_slow_path(measured, remainder, correction);
        }
        let (stochastic, validity) = self.in_range(self.predicted_remainder);
        self.compare(measured, remainder, stochastic, correction);
        (self.remainder, correction.validity) = (remainder, validity);
    }

    /// Processes a sample whose true value is `reference`.
    pub(crate) fn track_against(&mut self, measured: R, reference: R, correction: &mut Correction<R>) {
        self.is_fresh(measured);
        self.track_slow_path(measured, self.remainder_of(measured, reference), correction);
    }

    /// Processes a sample that needs checks, because of its value or the history before it.
    #[inline(never)]
    fn track_slow_path(&mut self, measured: R, remainder: R, correction: &mut Correction<R>) {
        let stuck = u32::from(self.repeats) >= self.stuck_after_repeats;
        // false for NaN
        let below_full_scale = !measured.is_absent() && measured.abs() < self.full_scale;
        if stuck || !below_full_scale {
            return self.track_faulty(measured, remainder, correction);
        }
        let (limited, out_of_range) = self.in_range(remainder);
        if !out_of_range.is_valid() {
            // twice the remainder in the axis' unit: if that is finite, so is the innovation
            let error = (remainder + remainder).times(self.scale);
            if !error.is_finite() {
                return self.track_faulty(measured, error, correction);
            }
        }
        let (stochastic, validity) = self.limited();
        self.compare(measured, remainder, stochastic, correction);
        (self.remainder, correction.validity) = (limited, validity | out_of_range);
        if !self.steady {
            self.settle(correction);
        }
    }

    /// Fills in prediction, innovation and corrected value.
    #[inline(always)]
    fn compare(&mut self, measured: R, remainder: R, stochastic: R, correction: &mut Correction<R>) {
        correction.predicted = self.offset + (self.p + stochastic).times(self.scale);
        correction.innovation = Some((remainder - stochastic).times(self.scale));
        self.corrected = measured - correction.predicted;
        correction.corrected = self.corrected;
    }

    /// Processes a faulty sample with known true value: it does not enter the history.
    #[cold]
    #[inline(never)]
    fn track_faulty(&mut self, measured: R, remainder: R, correction: &mut Correction<R>) {
        let fault = self.fault(measured, remainder);
        self.coast_over(measured, fault, true, correction);
    }

    /// Processes a sample whose true value is not known.
    #[inline(never)]
    pub(crate) fn coast(&mut self, measured: R, correction: &mut Correction<R>) {
        // a value below full scale is finite
        if !(self.is_fresh(measured) && !measured.is_absent() && measured.abs() < self.full_scale) {
            return self.coast_faulty(measured, correction);
        }
        self.missing = 0;
        let (stochastic, validity) = self.limited();
        self.extrapolate(stochastic, measured, validity, correction);
    }

    #[cold]
    fn coast_faulty(&mut self, measured: R, correction: &mut Correction<R>) {
        let fault = self.fault(measured, measured);
        let is_lost = fault.intersects(Validity::NOT_FINITE);
        self.coast_over(measured, fault, is_lost, correction);
    }

    /// Predicts without a sample, for any length of time.
    #[cold]
    pub(crate) fn forecast(&mut self, correction: &mut Correction<R>) {
        let (stochastic, validity) = self.limited();
        // NaN before the first sample
        let fault = self.fault(self.last_measured, self.last_measured);
        self.extrapolate(stochastic, self.last_measured, validity | fault, correction);
    }

    /// Processes a missing sample.
    #[cold]
    pub(crate) fn miss(&mut self, correction: &mut Correction<R>) {
        self.coast_over(self.last_measured, Validity::MISSING, true, correction);
    }

    /// Coasts over a faulty sample; if it is lost, restarts beyond the gap limit.
    // not inlined: one copy for all samples that are not on the hot path
    #[inline(never)]
    fn coast_over(&mut self, measured: R, reason: Validity, is_lost: bool, correction: &mut Correction<R>) {
        let (stochastic, validity) = self.limited();
        let coasts = !is_lost || self.missing < self.gap_limit_samples;
        if !coasts {
            self.restart(0);
        } else if is_lost {
            self.missing += 1;
        } else {
            self.missing = 0;
        }
        self.extrapolate(stochastic, measured, validity | reason, correction);
        // also for a model without lagged outputs: inputs computed from the remainder must not run on predictions
        self.known = self.known && coasts;
    }

    /// r = y − p, scaled.
    #[inline(always)]
    fn remainder_of(&self, measured: R, reference: R) -> R {
        (measured - reference - self.offset).times(self.per_scale) - self.p
    }

    /// r̂ within its limits, 0 until the history is full; with the reasons not to trust it.
    #[inline(always)]
    fn limited(&self) -> (R, Validity) {
        if !self.ready {
            cold_path();
            return (R::ZERO, Validity::WARMING_UP);
        }
        self.in_range(self.predicted_remainder)
    }

    /// The remainder within its limits, and a flag if it was outside.
    #[inline(always)]
    fn in_range(&self, remainder: R) -> (R, Validity) {
        if self.range.contains(remainder) {
            return (remainder, Validity::VALID);
        }
        cold_path();
        (self.range.limit(remainder), Validity::OUTPUT_OUT_OF_RANGE)
    }

    /// Counts repetitions of the measured value; returns false if the sensor counts as stuck.
    #[inline(always)]
    fn is_fresh(&mut self, measured: R) -> bool {
        if measured == self.last_measured && !measured.is_absent() {
            self.repeats = self.repeats.saturating_add(1);
            return u32::from(self.repeats) < self.stuck_after_repeats;
        }
        (self.last_measured, self.repeats) = (measured, 0);
        true
    }

    /// Faults of a measured value: not finite, saturated or stuck.
    fn fault(&self, measured: R, remainder: R) -> Validity {
        Validity::when(!(measured.is_finite() && remainder.is_finite()), Validity::NOT_FINITE)
            | Validity::when(measured.abs() >= self.full_scale, Validity::SATURATED)
            | Validity::when(u32::from(self.repeats) >= self.stuck_after_repeats, Validity::STUCK)
    }

    /// Counts a measured sample until the history holds only measurements.
    #[inline(never)]
    fn settle(&mut self, correction: &mut Correction<R>) {
        if !self.ready {
            correction.innovation = None;
        } else if self.measured_run < self.depth {
            correction.validity |= Validity::OWN_HISTORY;
        }
        if self.measured_run < self.depth {
            self.measured_run += 1;
            self.ready = self.ready || self.measured_run == self.depth;
        }
        (self.missing, self.coasted, self.gain, self.known) = (0, 0, R::ONE, true);
        self.steady = self.measured_run == self.depth;
    }

    /// Fills in the prediction; the model's own output enters the history.
    #[inline(always)]
    fn extrapolate(&mut self, stochastic: R, measured: R, reasons: Validity, correction: &mut Correction<R>) {
        let mut validity = reasons;
        (self.measured_run, self.steady) = (0, false);
        if self.coasts_too_long() {
            validity |= Validity::COASTING_TOO_LONG;
        }
        if self.ready {
            validity |= Validity::when(self.depth > 0, Validity::OWN_HISTORY);
            // not faded: fed back, it would fade again with every lag
            (self.remainder, self.known) = (stochastic, true);
        } else {
            (self.remainder, self.known) = (R::ZERO, false);
        }
        let predicted = self.offset + (self.p + stochastic * self.gain).times(self.scale);
        if !validity.intersects(Validity::NOT_FINITE | Validity::MISSING) {
            self.corrected = measured - predicted;
        }
        *correction = Correction { predicted, innovation: None, corrected: self.corrected, validity };
    }

    /// Counts a coasted sample; beyond the limit it fades the stochastic part and returns true.
    #[inline(always)]
    fn coasts_too_long(&mut self) -> bool {
        self.coasted = self.coasted.saturating_add(1);
        let is_too_long = self.coasted > self.coast_limit;
        if is_too_long {
            self.fade();
        }
        is_too_long
    }

    /// True if the history holds only measurements, so that a coast can begin.
    #[cfg(feature = "coasts")]
    pub(crate) fn is_steady(&self) -> bool {
        self.steady
    }

    /// One sample of parallel coasts that began the same number of ticks ago. Limits r̂ of each lane in place and returns
    /// the predicted errors.
    #[cfg(feature = "coasts")]
    #[inline(always)]
    pub(crate) fn coast_lanes<const LANES: usize>(
        &mut self,
        mut p: [R; LANES],
        stochastic: &mut [R; LANES],
    ) -> [R; LANES] {
        self.coasts_too_long();
        if !self.physical.is_empty {
            for p in &mut p {
                *p = self.physical_range.limit(*p);
            }
        }
        let mut predicted = p;
        for lane in 0..LANES {
            stochastic[lane] = self.range.limit(stochastic[lane]);
            predicted[lane] = self.offset + (p[lane] + stochastic[lane] * self.gain).times(self.scale);
        }
        predicted
    }

    /// Reduces the gain of the stochastic part by one step.
    fn fade(&mut self) {
        self.gain = self.gain.times(self.fade);
        if self.gain < R::from_f64(FADED) {
            self.gain = R::ZERO;
        }
    }
}
