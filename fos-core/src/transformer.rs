//! A transform at work: its state, and where it starts.

#[cfg(feature = "coasts")]
use crate::running::LowPass;
use crate::running::Running;
use crate::{Scalar, Transform};

/// A [`Transform`] with its state: what an input of a model runs, and what a host that looks for inputs runs.
///
/// It starts at the first finite value as if that had been there for ever: until then nothing is known of the
/// quantity, and what comes out is the transform of 0.
///
/// ```
/// use fos_core::{Transform, Transformer};
///
/// let mut low_pass = Transformer::new(&Transform::LowPass { tau_s: 2.0 }, 0.005);
/// assert_eq!(low_pass.update(f64::NAN), 0.0); // a cell that is empty: not known yet
/// assert_eq!(low_pass.update(21.5), 21.5); // starts at the first value
/// assert_eq!(low_pass.update(f64::NAN), 21.5); // and stays where one is missing
/// ```
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "transforms"), allow(unreachable_pub, reason = "for inputs alone"))]
pub struct Transformer<R: Scalar> {
    running: Running<R>,
    /// The last finite x; none before the first.
    held: Option<R>,
}

#[cfg(feature = "transforms")]
impl<R: Scalar> Transformer<R> {
    /// The transform at power-on, for a sample period in seconds. The logged values are taken as they are: centre 0,
    /// scale 1.
    pub fn new(transform: &Transform<R::Stored>, period_s: f64) -> Self {
        Self::scaled(transform, period_s, R::Stored::ZERO, R::Stored::ONE)
    }

    /// One sample: u(n) from x(n). A value that is not finite stands for the last one before it.
    #[inline]
    pub fn update(&mut self, x: R) -> R {
        self.advance(x.is_finite().then_some(x))
    }

    /// `ticks` missing samples, x taken to have stayed; in bounded time.
    pub fn skip(&mut self, ticks: u32) {
        self.pass(None, ticks);
    }
}

impl<R: Scalar> Transformer<R> {
    /// The transform of x = (logged − centre)/scale, at power-on.
    pub(crate) fn scaled(
        transform: &Transform<R::Stored>,
        period_s: f64,
        centre: R::Stored,
        scale: R::Stored,
    ) -> Self {
        Self { running: Running::new(transform, period_s, centre, scale), held: None }
    }

    /// As at power-on.
    pub(crate) fn reset(&mut self) {
        self.held = None;
        self.running.reset();
    }

    /// Starts at `x`, whatever comes first.
    pub(crate) fn start_at(&mut self, x: R) {
        self.running.start_at(x);
        self.held = Some(x);
    }

    /// One sample with a finite x, or without one: it is taken to have stayed.
    #[inline]
    pub(crate) fn advance(&mut self, x: Option<R>) -> R {
        if let Some(x) = x {
            if self.held.is_none() {
                self.running.start_at(x);
            }
            self.held = Some(x);
        }
        self.running.update(self.held.unwrap_or(R::ZERO))
    }

    /// The low-pass that it runs, if it is one that has begun.
    #[cfg(feature = "coasts")]
    pub(crate) fn low_pass(&self) -> Option<&LowPass<R>> {
        match &self.running {
            Running::LowPass(low_pass) if self.held.is_some() => Some(low_pass),
            _ => None,
        }
    }

    /// `ticks` missing samples, x taken to have stayed, or with an `x` to have been that; in bounded time.
    pub(crate) fn pass(&mut self, x: Option<R>, ticks: u32) {
        self.running.skip(x.or(self.held).unwrap_or(R::ZERO), ticks);
    }
}

#[cfg(feature = "defmt")]
impl<R: Scalar + defmt::Format> defmt::Format for Transformer<R> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Transformer {{ held: {} }}", self.held);
    }
}
