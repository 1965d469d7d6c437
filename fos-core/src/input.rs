//! An input: one logged quantity through one causal transform, scaled, and kept inside its fitted range.

use core::hint::cold_path;

use serde::{Deserialize, Serialize};

use crate::real::scalar;
#[cfg(feature = "coasts")]
use crate::running::LowPass;
use crate::transformer::Transformer;
use crate::{Range, Real, Scalar, Transform, Validity};

/// By how much of its width a fitted range of an input is widened before a value counts as outside: the noise
/// and the steps of a thermometer, not an extrapolation.
const MARGIN: f64 = 0.05;

/// What an input is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// Time since power-on alone.
    Clock,
    /// The logged quantity of this index in [`Sample::quantities`](crate::Sample).
    Quantity(u8),
    /// The remainder r of the axis of this index, one sample late: a low-pass of it is the model's long memory.
    Remainder(u8),
}

/// An input u_i, shared by all axes and updated once per sample:
/// x = (logged − centre)/scale, u = transform(x).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Input<R> {
    /// What it is computed from.
    pub source: Source,
    /// What is made of the source before it is centred and scaled: causal, in constant memory.
    pub transform: Transform<R>,
    /// Taken off the logged quantity first, in its unit, so that f32 keeps its digits.
    pub centre: R,
    /// The logged quantity is divided by it, in its unit; positive.
    pub scale: R,
    /// x while fitting; below 10¹⁵. Values beyond it are limited, so that one wild sample cannot spoil a long low-pass.
    pub source_range: Range<R>,
    /// u while fitting. Values beyond it are limited, so that no term is evaluated where it was not fitted.
    pub range: Range<R>,
}

impl<R: Real> Input<R> {
    /// u is kept within these: the fitted range and what noise adds to it.
    pub fn limits(&self) -> Range<R> {
        self.range.widened(MARGIN)
    }

    /// The same of x.
    pub(crate) fn source_limits(&self) -> Range<R> {
        self.source_range.widened(MARGIN)
    }
}

/// The coefficients and the state of an input.
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

    /// A long memory of the remainder starts at its mean, 0: one noisy sample would stay in it for long.
    fn start(&mut self) {
        if self.is_of_remainder() {
            self.transformer.start_at(R::ZERO);
        }
    }

    fn is_of_remainder(&self) -> bool {
        matches!(self.source, Source::Remainder(_))
    }

    /// As at power-on.
    pub(crate) fn reset(&mut self) {
        self.transformer.reset();
        self.start();
    }

    /// The largest |u| that can come out.
    pub(crate) fn magnitude(&self) -> R {
        self.range.magnitude()
    }

    pub(crate) fn source(&self) -> Source {
        self.source
    }

    /// One sample: u(n) from the logged value, `None` where there is none.
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
            // gone to its mean, so that the long memory of it fades as it would have
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

    /// The low-pass of it, if it is one.
    #[cfg(feature = "coasts")]
    pub(crate) fn low_pass(&self) -> Option<&LowPass<R>> {
        self.transformer.low_pass()
    }

    /// As [`update`](Self::update) of a low-pass of what is known, with states side by side.
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

    /// `ticks` missing samples in bounded time.
    #[inline(never)]
    pub(crate) fn skip(&mut self, ticks: u32) {
        self.transformer.pass(self.is_of_remainder().then_some(R::ZERO), ticks);
    }
}
