//! One axis: turns the measured and predicted value of a sample into a correction and the next history entry.

mod constants;
mod state;

use core::hint::cold_path;

use crate::model::AxisParameters;
use crate::{Range, Scalar, Validity};

pub(crate) use constants::{AxisConstants, AxisProgram, RANGE_MARGIN};
pub(crate) use state::AxisState;

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

/// An axis of a loaded model: its constants and its state.
#[derive(Debug, Clone)]
pub(crate) struct RunningAxis<R: Scalar> {
    pub(crate) constants: AxisConstants<R>,
    pub(crate) state: AxisState<R>,
}

impl<R: Scalar> RunningAxis<R> {
    #[inline(always)]
    pub(crate) fn new(
        parameters: &AxisParameters<R::Stored>,
        program: AxisProgram<R>,
        period_s: f64,
    ) -> Self {
        let constants = AxisConstants::new(parameters, program, period_s);
        let state = AxisState::new(&constants);
        Self { constants, state }
    }

    /// Limits p; returns true if p was outside. p is finite, because the inputs are within their limits.
    #[inline(always)]
    pub(crate) fn limit_physical(&mut self) -> bool {
        let Self { constants, state } = self;
        let Range { low, high } = constants.physical_range;
        state.p = if state.p > high {
            high
        } else if state.p < low {
            low
        } else {
            return false;
        };
        state.limited = true;
        true
    }

    /// Returns to the state before the first sample.
    #[inline(never)]
    pub(crate) fn reset(&mut self) {
        self.state = AxisState::new(&self.constants);
    }

    /// Discards the history after too many missing samples, `ticks` of which were skipped; the axis warms up again. A
    /// stochastic part that had begun to fade is set to 0.
    #[cold]
    pub(crate) fn restart(&mut self, ticks: u32) {
        let Self { constants, state } = self;
        (state.measured_run, state.missing) = (0, constants.gap_limit_samples);
        state.ready = constants.depth == 0;
        (state.remainder, state.known, state.steady) = (R::ZERO, false, false);
        state.coasted = state.coasted.saturating_add(ticks);
        if state.coasted > constants.coast_limit {
            state.gain = R::ZERO;
        }
    }

    /// Processes a sample whose true value is the model's own reference.
    ///
    /// A sample without fault takes the fast path: the measurement enters the history.
    #[inline(always)]
    pub(crate) fn track(&mut self, measured: R, correction: &mut Correction<R>) {
        let remainder = self.remainder_of(measured, self.constants.reference);
        if !(self.is_fresh(measured)
            && !measured.is_absent()
            && self.constants.fast_path_range.contains(remainder)
            && self.state.steady)
        {
            return self.track_slow_path(measured, remainder, correction);
        }
        let (stochastic, validity) = self.constants.in_range(self.state.predicted_remainder);
        self.compare(measured, remainder, stochastic, correction);
        (self.state.remainder, correction.validity) = (remainder, validity);
    }

    /// Processes a sample whose true value is `reference`.
    pub(crate) fn track_against(&mut self, measured: R, reference: R, correction: &mut Correction<R>) {
        self.is_fresh(measured);
        self.track_slow_path(measured, self.remainder_of(measured, reference), correction);
    }

    /// Processes a sample that needs checks, because of its value or the history before it.
    #[inline(never)]
    fn track_slow_path(&mut self, measured: R, remainder: R, correction: &mut Correction<R>) {
        let constants = &self.constants;
        // false for NaN
        let below_full_scale = !measured.is_absent() && measured.abs() < constants.full_scale;
        if constants.is_stuck_after(self.state.repeats) || !below_full_scale {
            return self.track_faulty(measured, remainder, correction);
        }
        let (limited, out_of_range) = constants.in_range(remainder);
        if !out_of_range.is_valid() {
            // twice the remainder in the axis' unit: if that is finite, so is the innovation
            let error = (remainder + remainder).times(constants.scale);
            if !error.is_finite() {
                return self.track_faulty(measured, error, correction);
            }
        }
        let (stochastic, validity) = self.limited();
        self.compare(measured, remainder, stochastic, correction);
        (self.state.remainder, correction.validity) = (limited, validity | out_of_range);
        if !self.state.steady {
            self.settle(correction);
        }
    }

    /// Fills in prediction, innovation and corrected value.
    #[inline(always)]
    fn compare(&mut self, measured: R, remainder: R, stochastic: R, correction: &mut Correction<R>) {
        let Self { constants, state } = self;
        correction.predicted = constants.offset + (state.p + stochastic).times(constants.scale);
        correction.innovation = Some((remainder - stochastic).times(constants.scale));
        state.corrected = measured - correction.predicted;
        correction.corrected = state.corrected;
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
        if !(self.is_fresh(measured) && !measured.is_absent() && measured.abs() < self.constants.full_scale) {
            return self.coast_faulty(measured, correction);
        }
        self.state.missing = 0;
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
        let measured = self.state.last_measured;
        let fault = self.fault(measured, measured);
        self.extrapolate(stochastic, measured, validity | fault, correction);
    }

    /// Processes a missing sample.
    #[cold]
    pub(crate) fn miss(&mut self, correction: &mut Correction<R>) {
        self.coast_over(self.state.last_measured, Validity::MISSING, true, correction);
    }

    /// Coasts over a faulty sample; if it is lost, restarts beyond the gap limit.
    // not inlined: one copy for all samples that are not on the hot path
    #[inline(never)]
    fn coast_over(&mut self, measured: R, reason: Validity, is_lost: bool, correction: &mut Correction<R>) {
        let (stochastic, validity) = self.limited();
        let coasts = !is_lost || self.state.missing < self.constants.gap_limit_samples;
        if !coasts {
            self.restart(0);
        } else if is_lost {
            self.state.missing += 1;
        } else {
            self.state.missing = 0;
        }
        self.extrapolate(stochastic, measured, validity | reason, correction);
        // also for a model without lagged outputs: inputs computed from the remainder must not run on predictions
        self.state.known = self.state.known && coasts;
    }

    /// r = y − p, scaled.
    #[inline(always)]
    fn remainder_of(&self, measured: R, reference: R) -> R {
        self.constants.scaled_error(measured, reference) - self.state.p
    }

    /// r̂ within its limits, 0 until the history is full; with the reasons not to trust it.
    #[inline(always)]
    fn limited(&self) -> (R, Validity) {
        if !self.state.ready {
            cold_path();
            return (R::ZERO, Validity::WARMING_UP);
        }
        self.constants.in_range(self.state.predicted_remainder)
    }

    /// Counts repetitions of the measured value; returns false if the sensor counts as stuck.
    #[inline(always)]
    fn is_fresh(&mut self, measured: R) -> bool {
        let Self { constants, state } = self;
        if measured == state.last_measured && !measured.is_absent() {
            state.repeats = state.repeats.saturating_add(1);
            return !constants.is_stuck_after(state.repeats);
        }
        (state.last_measured, state.repeats) = (measured, 0);
        true
    }

    /// Faults of a measured value: not finite, saturated or stuck.
    fn fault(&self, measured: R, remainder: R) -> Validity {
        let Self { constants, state } = self;
        Validity::when(!(measured.is_finite() && remainder.is_finite()), Validity::NOT_FINITE)
            | Validity::when(measured.abs() >= constants.full_scale, Validity::SATURATED)
            | Validity::when(constants.is_stuck_after(state.repeats), Validity::STUCK)
    }

    /// Counts a measured sample until the history holds only measurements.
    #[inline(never)]
    fn settle(&mut self, correction: &mut Correction<R>) {
        let Self { constants: AxisConstants { depth, .. }, state } = self;
        if !state.ready {
            correction.innovation = None;
        } else if state.measured_run < *depth {
            correction.validity |= Validity::OWN_HISTORY;
        }
        if state.measured_run < *depth {
            state.measured_run += 1;
            state.ready = state.ready || state.measured_run == *depth;
        }
        (state.missing, state.coasted, state.gain, state.known) = (0, 0, R::ONE, true);
        state.steady = state.measured_run == *depth;
    }

    /// Fills in the prediction; the model's own output enters the history.
    #[inline(always)]
    fn extrapolate(&mut self, stochastic: R, measured: R, reasons: Validity, correction: &mut Correction<R>) {
        let Self { constants, state } = self;
        let mut validity = reasons;
        (state.measured_run, state.steady) = (0, false);
        if state.coasts_too_long(constants) {
            validity |= Validity::COASTING_TOO_LONG;
        }
        if state.ready {
            validity |= Validity::when(constants.depth > 0, Validity::OWN_HISTORY);
            // not faded: fed back, it would fade again with every lag
            (state.remainder, state.known) = (stochastic, true);
        } else {
            (state.remainder, state.known) = (R::ZERO, false);
        }
        let predicted = constants.offset + (state.p + stochastic * state.gain).times(constants.scale);
        if !validity.intersects(Validity::NOT_FINITE | Validity::MISSING) {
            state.corrected = measured - predicted;
        }
        *correction = Correction { predicted, innovation: None, corrected: state.corrected, validity };
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
        let Self { constants, state } = self;
        state.coasts_too_long(constants);
        if !constants.physical.is_empty {
            for p in &mut p {
                *p = constants.physical_range.limit(*p);
            }
        }
        let mut predicted = p;
        for lane in 0..LANES {
            stochastic[lane] = constants.range.limit(stochastic[lane]);
            predicted[lane] =
                constants.offset + (p[lane] + stochastic[lane] * state.gain).times(constants.scale);
        }
        predicted
    }
}
