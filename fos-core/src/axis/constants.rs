//! Constants of an axis: computed when a model is loaded, only read by a step.

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

/// Terms, scaling and limits of an axis, for the hot path.
#[derive(Debug, Clone)]
pub(crate) struct AxisConstants<R: Scalar> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    /// Bit i is set if a term uses input i.
    pub(crate) inputs_used: u32,
    /// Longest lag: samples that the history must hold before the terms can be evaluated.
    pub(super) depth: u16,
    pub(crate) reference: R,
    pub(super) offset: R,
    pub(super) scale: R::Gain,
    per_scale: R::Gain,
    pub(super) range: Range<R>,
    pub(super) physical_range: Range<R>,
    /// Range of the remainder, against the model's own reference, in which the measured value is certainly below full
    /// scale and the remainder within its limits.
    pub(super) fast_path_range: Range<R>,
    pub(super) full_scale: R,
    /// Wider than the count, so that a disabled test never triggers.
    stuck_after_repeats: u32,
    pub(super) gap_limit_samples: u8,
    pub(super) coast_limit: u32,
    pub(super) fade: R::Gain,
}

/// The compiled terms of an axis.
pub(crate) struct AxisProgram<R> {
    pub(crate) physical: Part<R>,
    pub(crate) stochastic: Part<R>,
    pub(crate) uses: Uses,
}

impl<R: Scalar> AxisConstants<R> {
    /// The fast path is empty until [`update_fast_path_range`](Self::update_fast_path_range) is called.
    pub(super) fn new(
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
            range: parameters.range.widened(R::Stored::from_f64(RANGE_MARGIN)).convert(),
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
        }
    }

    pub(crate) fn limit_full_scale(&mut self, full_scale: R) {
        if full_scale > R::ZERO && full_scale < self.full_scale {
            self.full_scale = full_scale;
            self.update_fast_path_range();
        }
    }

    /// Sets the fast path to the whole range of the remainder if no value in it can be at full scale; otherwise to an
    /// empty range, so that every sample is compared with full scale.
    pub(crate) fn update_fast_path_range(&mut self) {
        let built = |value: R| -> R::Built { scalar(value) };
        let p = if self.physical.is_empty { R::ZERO } else { self.physical_range.magnitude() };
        let scale: R::Built = scalar(R::gain_to_f64(self.scale));
        let error = scale * (built(self.range.magnitude()) + built(p));
        let furthest = built(self.reference.abs()) + built(self.offset.abs()) + error;
        // allowance for rounding
        let below = furthest * R::Built::from_f64(1.000_01) < built(self.full_scale);
        self.fast_path_range = if below { self.range } else { Range::new(R::ONE, R::ZERO) };
    }

    /// The larger of gap limit and longest lag, ticks: in a gap, the axis reaches a steady state after them.
    pub(crate) fn settling_ticks(&self) -> u32 {
        u32::from(self.depth.max(u16::from(self.gap_limit_samples)))
    }

    /// y, the scaled error of a measured value.
    #[inline(always)]
    pub(super) fn scaled_error(&self, measured: R, reference: R) -> R {
        (measured - reference - self.offset).times(self.per_scale)
    }

    /// The remainder within its limits, and a flag if it was outside.
    #[inline(always)]
    pub(super) fn in_range(&self, remainder: R) -> (R, Validity) {
        if self.range.contains(remainder) {
            return (remainder, Validity::VALID);
        }
        cold_path();
        (self.range.limit(remainder), Validity::OUTPUT_OUT_OF_RANGE)
    }

    /// True if a value that was repeated so often counts as that of a stuck sensor.
    #[inline(always)]
    pub(super) fn is_stuck_after(&self, repeats: u16) -> bool {
        u32::from(repeats) >= self.stuck_after_repeats
    }
}
