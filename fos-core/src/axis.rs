//! One axis, one sample: from what is measured and predicted to what is corrected and remembered.

use core::hint::cold_path;

use crate::exponential::exp_m1;
use crate::model::AxisParameters;
use crate::program::Part;
use crate::real::scalar;
use crate::{Range, Real, Scalar, Validity};

/// By how much of its width the fitted range of the remainder is widened before a value is limited: half the
/// width on either side doubles it. The extreme of a normal record of 10⁴ samples is 3.9 σ, of 10¹⁰ samples
/// 6.5 σ: less than twice as far out, so noise alone is never limited.
const MARGIN: f64 = 0.5;

/// Below this the fading stochastic part is taken as gone, before the gain reaches subnormal numbers.
const FADED: f64 = 1e-6;

/// What a [`Predictor`](crate::Predictor) says of one axis and one sample.
#[must_use = "carries whether the corrected value can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Correction<R> {
    /// Predicted error, offset included, in the axis' unit: what was subtracted.
    pub predicted: R,
    /// Measured error minus predicted error, in the axis' unit: only while the true value is known and the
    /// history is full.
    pub innovation: Option<R>,
    /// Measured minus predicted, in the axis' unit; the last such value where there was no finite sample.
    pub corrected: R,
    /// What speaks against trusting the above.
    pub validity: Validity,
}

impl<R: Scalar> Correction<R> {
    /// Before the first sample.
    pub const NONE: Self =
        Self { predicted: R::ZERO, innovation: None, corrected: R::ZERO, validity: Validity::WARMING_UP };

    /// The same in the scalar of the model.
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

/// The constants of an axis, as the hot path needs them, and its state.
#[derive(Debug, Clone)]
pub(crate) struct RunningAxis<R: Scalar> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    /// Bit i is set if a term uses input i.
    pub(crate) inputs_used: u32,
    /// Samples that the history must hold before the terms mean anything: the longest lag.
    depth: u16,
    pub(crate) reference: R,
    offset: R,
    scale: R::Gain,
    per_scale: R::Gain,
    range: Range<R>,
    physical_range: Range<R>,
    /// A remainder in it, against the model's own reference, is one of a measured value below full scale and in range.
    sound: Range<R>,
    full_scale: R,
    /// Wider than the count, so that a test switched off is never reached.
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
    /// There has been a remainder since the start or restart.
    known: bool,
    /// The history holds nothing but measurements, and no counter below has to be set back: so it is while a
    /// sensor is still, sample after sample.
    steady: bool,
    last_measured: R,
    repeats: u16,
    /// Measured samples since the last one that was not.
    measured_run: u16,
    ready: bool,
    missing: u8,
    coasted: u32,
    gain: R,
    corrected: R,
}

/// What decides how a model's axis is run, beside its parameters.
pub(crate) struct AxisProgram<R> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    pub(crate) inputs_used: u32,
    pub(crate) depth: u16,
}

impl<R: Scalar> RunningAxis<R> {
    /// It has to be [begun](Self::begin) where it is to stay.
    #[inline(never)]
    pub(crate) fn new(
        parameters: &AxisParameters<R::Stored>,
        program: AxisProgram<R>,
        period_s: f64,
    ) -> Self {
        // −0 is a limit of 0: to divide by it must not turn the sign of the fading
        let coast_limit_s: R::Built = scalar(parameters.coast_limit_s.abs());
        let (scale, period_s): (R::Built, R::Built) = (scalar(parameters.scale), scalar(period_s));
        let full_scale = R::of(parameters.full_scale);
        Self {
            physical: program.physical,
            stochastic: program.stochastic,
            inputs_used: program.inputs_used,
            depth: program.depth,
            reference: R::of(parameters.reference),
            offset: R::of(parameters.offset),
            scale: R::gain(scale.to_f64()),
            per_scale: R::gain((R::Built::ONE / scale).to_f64()),
            range: Self::limits(parameters).convert(),
            physical_range: parameters.physical_limits().convert(),
            sound: Range::new(R::ONE, R::ZERO),
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

    /// Within these the remainder is kept, whatever happens.
    pub(crate) fn limits(parameters: &AxisParameters<R::Stored>) -> Range<R::Stored> {
        parameters.range.widened(MARGIN)
    }

    /// Keeps p within its limits; whether it was beyond them. It is finite: the inputs are within theirs.
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

    /// What speaks against trusting p, told once.
    pub(crate) fn take_limited(&mut self) -> Validity {
        Validity::when(core::mem::take(&mut self.limited), Validity::INPUT_OUT_OF_RANGE)
    }

    pub(crate) fn limit_full_scale(&mut self, full_scale: R) {
        if full_scale > R::ZERO && full_scale < self.full_scale {
            self.full_scale = full_scale;
            self.find_sound();
        }
    }

    /// The whole range of the remainder if nothing in it is at full scale, else nothing: full scale is then looked at.
    fn find_sound(&mut self) {
        let built = |value: R| -> R::Built { scalar(value) };
        let p = if self.physical.is_empty { R::ZERO } else { self.physical_range.magnitude() };
        let scale: R::Built = scalar(R::gain_to_f64(self.scale));
        let error = scale * (built(self.range.magnitude()) + built(p));
        let furthest = built(self.reference.abs()) + built(self.offset.abs()) + error;
        // for what rounding adds
        let below = furthest * R::Built::from_f64(1.000_01) < built(self.full_scale);
        self.sound = if below { self.range } else { Range::new(R::ONE, R::ZERO) };
    }

    /// Before the first sample, where it stays: two copies of an axis are much stack.
    pub(crate) fn begin(&mut self) {
        self.find_sound();
        self.reset();
    }

    /// As before the first sample.
    pub(crate) fn reset(&mut self) {
        self.restart(0);
        (self.repeats, self.missing, self.coasted, self.gain) = (0, 0, 0, R::ONE);
        self.corrected = self.reference;
        // equals nothing, so that the first sample is no repetition
        self.last_measured = R::NAN;
    }

    /// Too many samples are missing, `ticks` of them unseen. Forgets the history: the axis warms up again. What had
    /// begun to fade is gone: nothing is known that could bring it back.
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

    /// Ticks that the axis coasts over when samples are missing, or remembers: the more of the two.
    pub(crate) fn reach(&self) -> u32 {
        u32::from(self.depth.max(u16::from(self.gap_limit_samples)))
    }

    /// r(n − 1), limited; none where it is not known: before the first sample, while more are missing than may be, and
    /// after that until the history is full again.
    pub(crate) fn remainder(&self) -> Option<R> {
        self.known.then_some(self.remainder)
    }

    /// One sample of which the true value is the model's own reference.
    ///
    /// A sound sample takes the straight way through: the history gets the measurement.
    #[inline(always)]
    pub(crate) fn track(&mut self, measured: R, correction: &mut Correction<R>) {
        let remainder = self.remainder_of(measured, self.reference);
        if !(self.is_fresh(measured)
            && !measured.is_absent()
            && self.sound.contains(remainder)
            && self.steady)
        {
            return self.track_unsound(measured, remainder, correction);
        }
        let (stochastic, validity) = self.in_range(self.predicted_remainder);
        self.compare(measured, remainder, stochastic, correction);
        (self.remainder, correction.validity) = (remainder, validity);
    }

    /// One sample of which the true value is `reference`.
    pub(crate) fn track_against(&mut self, measured: R, reference: R, correction: &mut Correction<R>) {
        self.is_fresh(measured);
        self.track_unsound(measured, self.remainder_of(measured, reference), correction);
    }

    /// A sample with something to look at: itself, or the history before it.
    #[inline(never)]
    fn track_unsound(&mut self, measured: R, remainder: R, correction: &mut Correction<R>) {
        let stuck = u32::from(self.repeats) >= self.stuck_after_repeats;
        // NaN is not below
        let below_full_scale = !measured.is_absent() && measured.abs() < self.full_scale;
        if stuck || !below_full_scale {
            return self.track_faulty(measured, remainder, correction);
        }
        let (kept, out_of_range) = self.in_range(remainder);
        if !out_of_range.is_valid() {
            // in the axis' unit, and twice that: what is finite then, stays so in the innovation
            let error = (remainder + remainder).times(self.scale);
            if !error.is_finite() {
                return self.track_faulty(measured, error, correction);
            }
        }
        let (stochastic, validity) = self.limited();
        self.compare(measured, remainder, stochastic, correction);
        (self.remainder, correction.validity) = (kept, validity | out_of_range);
        if !self.steady {
            self.settle(correction);
        }
    }

    /// What was measured against what is predicted.
    #[inline(always)]
    fn compare(&mut self, measured: R, remainder: R, stochastic: R, correction: &mut Correction<R>) {
        correction.predicted = self.offset + (self.p + stochastic).times(self.scale);
        correction.innovation = Some((remainder - stochastic).times(self.scale));
        self.corrected = measured - correction.predicted;
        correction.corrected = self.corrected;
    }

    /// The true value is known but the sample is not to be trusted: it does not enter the history.
    #[cold]
    #[inline(never)]
    fn track_faulty(&mut self, measured: R, remainder: R, correction: &mut Correction<R>) {
        let fault = self.fault(measured, remainder);
        self.lose(measured, fault, correction);
    }

    /// One sample of which the true value is not known.
    #[inline(never)]
    pub(crate) fn coast(&mut self, measured: R, correction: &mut Correction<R>) {
        // what is below full scale is finite
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
        if fault.intersects(Validity::NOT_FINITE) {
            return self.lose(measured, fault, correction);
        }
        self.missing = 0;
        let (stochastic, validity) = self.limited();
        self.extrapolate(stochastic, measured, validity | fault, correction);
    }

    /// No sample is meant to be there: the model goes on by itself, however long.
    #[cold]
    pub(crate) fn forecast(&mut self, correction: &mut Correction<R>) {
        let (stochastic, validity) = self.limited();
        self.extrapolate(stochastic, self.last_measured, validity, correction);
    }

    /// There is no sample.
    #[cold]
    pub(crate) fn miss(&mut self, correction: &mut Correction<R>) {
        self.lose(self.last_measured, Validity::MISSING, correction);
    }

    /// There is no sample that could be used, for the given reason.
    fn lose(&mut self, measured: R, reason: Validity, correction: &mut Correction<R>) {
        let (stochastic, validity) = self.limited();
        let coasts = self.missing < self.gap_limit_samples;
        if coasts {
            self.missing += 1;
        } else {
            self.restart(0);
        }
        self.extrapolate(stochastic, measured, validity | reason, correction);
        // also where the model looks back at no output: what remembers the remainder must not live on predictions
        self.known = self.known && coasts;
    }

    /// y − p, scaled.
    #[inline(always)]
    fn remainder_of(&self, measured: R, reference: R) -> R {
        (measured - reference - self.offset).times(self.per_scale) - self.p
    }

    /// r̂ as it is used, and what speaks against it: 0 until the history is full, and never beyond the limits.
    #[inline(always)]
    fn limited(&self) -> (R, Validity) {
        if !self.ready {
            cold_path();
            return (R::ZERO, Validity::WARMING_UP);
        }
        self.in_range(self.predicted_remainder)
    }

    /// A remainder within its limits, and whether it was beyond them.
    #[inline(always)]
    fn in_range(&self, remainder: R) -> (R, Validity) {
        if self.range.contains(remainder) {
            return (remainder, Validity::VALID);
        }
        cold_path();
        (self.range.limit(remainder), Validity::OUTPUT_OUT_OF_RANGE)
    }

    /// Counts how often a measured value has repeated; whether that is still in order.
    #[inline(always)]
    fn is_fresh(&mut self, measured: R) -> bool {
        if measured == self.last_measured && !measured.is_absent() {
            self.repeats = self.repeats.saturating_add(1);
            return u32::from(self.repeats) < self.stuck_after_repeats;
        }
        (self.last_measured, self.repeats) = (measured, 0);
        true
    }

    /// What is wrong with a measured value: it is not finite, saturated or stuck.
    fn fault(&self, measured: R, remainder: R) -> Validity {
        Validity::when(!(measured.is_finite() && remainder.is_finite()), Validity::NOT_FINITE)
            | Validity::when(measured.abs() >= self.full_scale, Validity::SATURATED)
            | Validity::when(u32::from(self.repeats) >= self.stuck_after_repeats, Validity::STUCK)
    }

    /// One more measured sample on the way to a history of nothing else.
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

    /// The history gets the model's own output.
    #[inline(always)]
    fn extrapolate(&mut self, stochastic: R, measured: R, reasons: Validity, correction: &mut Correction<R>) {
        let mut validity = reasons;
        (self.measured_run, self.steady) = (0, false);
        if self.coasts_too_long() {
            validity |= Validity::COASTING_TOO_LONG;
        }
        if self.ready {
            validity |= Validity::when(self.depth > 0, Validity::OWN_HISTORY);
            // not faded: fed back, it would fade again at every lag
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

    /// One more coasted sample; whether there are too many, and what is subtracted fades.
    #[inline(always)]
    fn coasts_too_long(&mut self) -> bool {
        self.coasted = self.coasted.saturating_add(1);
        let is_too_long = self.coasted > self.coast_limit;
        if is_too_long {
            self.fade();
        }
        is_too_long
    }

    /// Whether a coast that begins now begins from measurements alone.
    #[cfg(feature = "coasts")]
    pub(crate) fn is_steady(&self) -> bool {
        self.steady
    }

    /// One sample of coasts side by side, all of which began as long ago: the predicted errors, and r̂ of each limited in
    /// place.
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

    /// Lets what is subtracted of the stochastic part die away.
    fn fade(&mut self) {
        self.gain = self.gain.times(self.fade);
        if self.gain < R::from_f64(FADED) {
            self.gain = R::ZERO;
        }
    }
}
