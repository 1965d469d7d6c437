//! One axis, one sample: from what is measured and predicted to what is corrected and remembered.

use crate::model::AxisParameters;
use crate::program::Degrees;
use crate::{Range, Real, Validity};

/// By how much of its width the fitted range of the remainder is widened before a value is limited: half the
/// width on either side doubles it. The extreme of a normal record of 10⁴ samples is 3.9 σ, of 10¹⁰ samples
/// 6.5 σ: less than twice as far out, so noise alone is never limited.
const MARGIN: f64 = 0.5;

/// Below this the fading stochastic part is taken as gone, before the gain reaches subnormal numbers.
const FADED: f64 = 1e-6;

/// What is known of an axis in one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Reading<R> {
    /// The true value is known: the model's reference, or the one given.
    Still { measured: R, reference: Option<R> },
    /// The true value is not known.
    Moving { measured: R },
    /// There is no sample.
    Missing,
}

/// What a [`Predictor`](crate::Predictor) says of one axis and one sample.
#[must_use = "carries whether the corrected value can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// The constants of an axis, as the hot path needs them, and its state.
#[derive(Debug, Clone)]
pub(crate) struct RunningAxis<R> {
    pub(crate) physical: Degrees,
    pub(crate) stochastic: Degrees,
    pub(crate) constant: R,
    /// Bit i is set if a term uses input i.
    pub(crate) inputs_used: u32,
    /// Samples that the history must hold before the terms mean anything: the longest lag.
    depth: u16,
    reference: R,
    offset: R,
    scale: R,
    per_scale: R,
    range: Range<R>,
    full_scale: R,
    /// Wider than the count, so that a test switched off is never reached.
    stuck_after: u32,
    gap_limit: u8,
    coast_limit: u32,
    fade: R,

    /// r(n − 1), limited; none where it is not known: before the first sample, after a restart until the next
    /// measured one.
    pub(crate) remainder: Option<R>,
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
pub(crate) struct AxisProgram {
    pub(crate) physical: Degrees,
    pub(crate) stochastic: Degrees,
    pub(crate) inputs_used: u32,
    pub(crate) depth: u16,
}

impl<R: Real> RunningAxis<R> {
    pub(crate) fn new(parameters: &AxisParameters<R>, program: AxisProgram, period_s: f64) -> Self {
        let coast_limit_s = parameters.coast_limit_s.to_f64();
        let full_scale = if parameters.full_scale > R::ZERO { parameters.full_scale } else { R::MAX };
        let mut axis = Self {
            physical: program.physical,
            stochastic: program.stochastic,
            constant: parameters.constant,
            inputs_used: program.inputs_used,
            depth: program.depth,
            reference: parameters.reference,
            offset: parameters.offset,
            scale: parameters.scale,
            per_scale: R::from_f64(1.0 / parameters.scale.to_f64()),
            range: Self::limits(parameters),
            full_scale,
            stuck_after: if parameters.stuck_after == 0 {
                u32::MAX
            } else {
                u32::from(parameters.stuck_after)
            },
            gap_limit: parameters.gap_limit,
            // the conversion saturates
            coast_limit: (coast_limit_s / period_s) as u32,
            fade: R::from_f64(libm::exp(-period_s / coast_limit_s)),
            remainder: None,
            last_measured: R::ZERO,
            repeats: 0,
            measured_run: 0,
            ready: false,
            missing: 0,
            coasted: 0,
            gain: R::ONE,
            corrected: R::ZERO,
        };
        axis.reset();
        axis
    }

    /// Within these the remainder is kept, whatever happens.
    pub(crate) fn limits(parameters: &AxisParameters<R>) -> Range<R> {
        parameters.range.widened(MARGIN)
    }

    /// As before the first sample.
    pub(crate) fn reset(&mut self) {
        self.restart();
        (self.repeats, self.missing, self.coasted, self.gain) = (0, 0, 0, R::ONE);
        self.corrected = self.reference;
        // equals nothing, so that the first sample is no repetition
        self.last_measured = R::from_f64(f64::NAN);
    }

    /// Forgets the history: the axis warms up again.
    pub(crate) fn restart(&mut self) {
        self.measured_run = 0;
        self.ready = self.depth == 0;
        self.remainder = None;
        (self.coasted, self.gain) = (0, R::ONE);
    }

    /// One sample. `physical` is p(n) and `stochastic` r̂(n) as the terms give them.
    #[inline]
    pub(crate) fn step(&mut self, reading: Reading<R>, physical: R, stochastic: R) -> Correction<R> {
        let mut validity = Validity::VALID;
        let mut stochastic = stochastic;
        if self.ready {
            let (limited, inside) = self.range.limit(stochastic);
            validity |= Validity::when(!inside, Validity::OUTPUT_OUT_OF_RANGE);
            stochastic = limited;
        } else {
            validity |= Validity::WARMING_UP;
            stochastic = R::ZERO;
        }

        if let Reading::Still { measured, reference } = reading {
            let reference = match reference {
                Some(reference) => reference,
                None => self.reference,
            };
            let remainder = (measured - reference - self.offset) * self.per_scale - physical;
            let fault = self.fault(measured, remainder);
            if fault.is_valid() {
                return self.track(measured, physical, stochastic, remainder, validity);
            }
            validity |= fault;
            self.note_missing();
        } else if let Reading::Moving { measured } = reading {
            let fault = self.fault(measured, measured);
            validity |= fault;
            if fault.intersects(Validity::NOT_FINITE) { self.note_missing() } else { self.missing = 0 }
        } else {
            validity |= Validity::MISSING;
            self.note_missing();
        }
        let measured = match reading {
            Reading::Still { measured, .. } | Reading::Moving { measured } => measured,
            Reading::Missing => self.last_measured,
        };
        self.coast(measured, physical, stochastic, validity)
    }

    /// What is wrong with a measured value: it is not finite, saturated or stuck.
    #[inline]
    fn fault(&mut self, measured: R, remainder: R) -> Validity {
        let repeated = measured == self.last_measured;
        self.repeats = if repeated { self.repeats.saturating_add(1) } else { 0 };
        self.last_measured = measured;
        let magnitude = measured.abs();
        let stuck = u32::from(self.repeats) >= self.stuck_after;
        if remainder.is_finite() && magnitude < self.full_scale && !stuck {
            return Validity::VALID;
        }
        Validity::when(!remainder.is_finite(), Validity::NOT_FINITE)
            | Validity::when(magnitude >= self.full_scale, Validity::SATURATED)
            | Validity::when(stuck, Validity::STUCK)
    }

    /// The true value is known and the sample is sound: the history gets the measurement.
    #[inline]
    fn track(
        &mut self,
        measured: R,
        physical: R,
        stochastic: R,
        remainder: R,
        reasons: Validity,
    ) -> Correction<R> {
        let mut validity = reasons;
        let innovation = if self.ready {
            let history = Validity::when(self.measured_run < self.depth, Validity::OWN_HISTORY);
            validity |= history;
            Some(self.scale * (remainder - stochastic))
        } else {
            None
        };
        let (kept, inside) = self.range.limit(remainder);
        validity |= Validity::when(!inside, Validity::OUTPUT_OUT_OF_RANGE);
        if self.measured_run < self.depth {
            self.measured_run += 1;
            self.ready = self.ready || self.measured_run == self.depth;
        }
        self.remainder = Some(kept);
        (self.missing, self.coasted, self.gain) = (0, 0, R::ONE);
        let predicted = self.offset + self.scale * (physical + stochastic);
        self.corrected = measured - predicted;
        Correction { predicted, innovation, corrected: self.corrected, validity }
    }

    /// The true value is not known: the history gets the model's own output.
    fn coast(&mut self, measured: R, physical: R, stochastic: R, reasons: Validity) -> Correction<R> {
        let mut validity = reasons;
        self.measured_run = 0;
        self.coasted = self.coasted.saturating_add(1);
        if self.coasted > self.coast_limit {
            validity |= Validity::COASTING_TOO_LONG;
            self.gain = self.gain * self.fade;
            if self.gain < R::from_f64(FADED) {
                self.gain = R::ZERO;
            }
        }
        let stochastic = stochastic * self.gain;
        if self.ready {
            validity |= Validity::when(self.depth > 0, Validity::OWN_HISTORY);
            self.remainder = Some(stochastic);
        } else {
            self.remainder = None;
        }
        let predicted = self.offset + self.scale * (physical + stochastic);
        if !validity.intersects(Validity::NOT_FINITE | Validity::MISSING) {
            self.corrected = measured - predicted;
        }
        Correction { predicted, innovation: None, corrected: self.corrected, validity }
    }

    fn note_missing(&mut self) {
        if self.missing < self.gap_limit {
            self.missing += 1;
        } else {
            self.restart();
        }
    }
}
