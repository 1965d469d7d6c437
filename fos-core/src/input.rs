//! An input: one logged quantity, scaled, passed through one causal transform and limited to its fitted range.

use core::hint::cold_path;

use serde::{Deserialize, Serialize};

use crate::real::scalar;
#[cfg(feature = "coasts")]
use crate::running::LowPass;
use crate::transformer::Transformer;
use crate::{Range, Real, Scalar, Transform, Validity};

/// Widening of the fitted range of an input on either side, as a share of its width, before a value counts as
/// outside. It covers the noise and quantisation of a thermometer; it is not meant for extrapolation.
pub(crate) const INPUT_MARGIN: f64 = 0.05;

/// Source of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// Time since power-on alone.
    Clock,
    /// The logged quantity with this index in [`Sample::quantities`](crate::Sample).
    Quantity(u8),
    /// The remainder r of the axis with this index, delayed by one sample: its low-pass is the model's long memory.
    Remainder(u8),
}

/// An input u_i, shared by all axes and updated once per sample:
/// x = (logged − centre)/scale, u = transform(x).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Input<R> {
    /// Quantity, clock or remainder that the input is computed from.
    pub source: Source,
    /// Causal transform of x.
    pub transform: Transform<R>,
    /// Centre, in the unit of the logged quantity. Subtracted first, so that f32 keeps its digits.
    pub centre: R,
    /// Size of one scaled unit, in the unit of the logged quantity; positive.
    pub scale: R,
    /// Range of x in the data of the fit; magnitude below 10¹⁵. Values outside are limited, so that one outlier cannot
    /// spoil a long low-pass.
    pub source_range: Range<R>,
    /// Range of u in the data of the fit. Values outside are limited, so that no term is extrapolated.
    pub range: Range<R>,
}

impl<R: Real> Input<R> {
    /// Limits of u on the device: the fitted range, widened by 5 % of its width on either side.
    pub fn limits(&self) -> Range<R> {
        self.range.widened(R::from_f64(INPUT_MARGIN))
    }

    /// Limits of x, widened in the same way.
    pub(crate) fn source_limits(&self) -> Range<R> {
        self.source_range.widened(R::from_f64(INPUT_MARGIN))
    }
}

/// Coefficients and state of an input.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunningInput<R: Scalar> {
    source: Source,
    centre: R,
    per_scale: R::Gain,
    source_range: Range<R>,
    range: Range<R>,
    transformer: Transformer<R>,
}

impl<R: Scalar> RunningInput<R> {
    pub(crate) fn new(input: &Input<R::Stored>, period_s: f64) -> Self {
        let transformer = Transformer::scaled(&input.transform, period_s, input.centre, input.scale);
        let mut running = Self {
            source: input.source,
            centre: R::of(input.centre),
            per_scale: R::gain((R::Built::ONE / scalar(input.scale)).to_f64()),
            source_range: input.source_limits().convert(),
            range: input.limits().convert(),
            transformer,
        };
        running.start();
        running
    }

    /// A low-pass of the remainder starts at the mean of the remainder, 0: a noisy first sample would stay in it for
    /// long.
    fn start(&mut self) {
        if self.is_of_remainder() {
            self.transformer.start_at(R::ZERO);
        }
    }

    pub(crate) fn is_of_remainder(&self) -> bool {
        matches!(self.source, Source::Remainder(_))
    }

    /// Returns to the state at power-on.
    pub(crate) fn reset(&mut self) {
        self.transformer.reset();
        self.start();
    }

    /// Largest |u| that [`update`](Self::update) can return.
    pub(crate) fn magnitude(&self) -> R {
        self.range.magnitude()
    }

    pub(crate) fn source(&self) -> Source {
        self.source
    }

    /// Computes u(n) from the logged value, or without it (`None`).
    #[inline]
    pub(crate) fn update(&mut self, logged: Option<R>) -> (R, Validity) {
        let mut validity = Validity::VALID;
        let x = match logged {
            Some(value) if value.is_finite() => {
                let mut x = (value - self.centre).times(self.per_scale);
                if !self.source_range.contains(x) {
                    cold_path();
                    x = self.source_range.limit(x);
                    validity |= Validity::INPUT_OUT_OF_RANGE;
                }
                Some(x)
            }
            // the remainder is replaced by its mean, 0, so that its low-pass decays as it would have
            _ if self.is_of_remainder() => Some(R::ZERO),
            _ => {
                let logged_quantity = matches!(self.source, Source::Quantity(_));
                validity |= Validity::when(logged_quantity, Validity::INPUT_NOT_FINITE);
                None
            }
        };
        let mut u = self.transformer.advance(x);
        if !self.range.contains(u) {
            cold_path();
            u = self.range.limit(u);
            validity |= Validity::INPUT_OUT_OF_RANGE;
        }
        (u, validity)
    }

    /// The low-pass, if that is the transform.
    #[cfg(feature = "coasts")]
    pub(crate) fn low_pass(&self) -> Option<&LowPass<R>> {
        self.transformer.low_pass()
    }

    /// Same as [`update`](Self::update) for a low-pass of finite values, with one state per lane.
    #[cfg(feature = "coasts")]
    #[inline(always)]
    pub(crate) fn update_lanes<const LANES: usize>(
        &self,
        low_pass: &LowPass<R>,
        slow: &mut [R::Slow; LANES],
        logged: &[R; LANES],
    ) -> [R; LANES] {
        let mut x = *logged;
        for x in &mut x {
            *x = self.source_range.limit((*x - self.centre).times(self.per_scale));
        }
        let mut values = low_pass.update_lanes(slow, &x);
        for value in &mut values {
            *value = self.range.limit(*value);
        }
        values
    }

    /// Advances over `ticks` missing samples in bounded time.
    #[inline(never)]
    pub(crate) fn skip(&mut self, ticks: u32) {
        self.transformer.pass(self.is_of_remainder().then_some(R::ZERO), ticks);
    }
}
