//! A transform with its state and its start value.

#[cfg(feature = "coasts")]
use crate::running::LowPass;
use crate::running::Running;
use crate::{Scalar, Transform};

/// A [`Transform`] with its state. The inputs of a model use it, and the host uses it to search for inputs.
///
/// It starts in the steady state of the first finite value. Before that it returns the transform of 0.
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
    /// Last finite x; `None` before the first.
    held: Option<R>,
}

#[cfg(feature = "transforms")]
impl<R: Scalar> Transformer<R> {
    /// The transform at power-on, for a sample period in seconds. Logged values are not scaled (centre 0, scale 1).
    pub fn new(transform: &Transform<R::Stored>, period_s: f64) -> Self {
        Self::scaled(transform, period_s, R::Stored::ZERO, R::Stored::ONE)
    }

    /// Computes u(n) from x(n). A value that is not finite is replaced by the last finite one.
    #[inline]
    pub fn update(&mut self, x: R) -> R {
        self.advance(x.is_finite().then_some(x))
    }

    /// Advances over `ticks` missing samples with x constant, in bounded time.
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

    /// Returns to the state at power-on.
    pub(crate) fn reset(&mut self) {
        self.held = None;
        self.running.reset();
    }

    /// Starts in the steady state of `x`, independent of the first value.
    pub(crate) fn start_at(&mut self, x: R) {
        self.running.start_at(x);
        self.held = Some(x);
    }

    /// Computes u(n) from a finite x, or from the last one if there is none.
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

    /// The low-pass, if that is the transform and it has started.
    #[cfg(feature = "coasts")]
    pub(crate) fn low_pass(&self) -> Option<&LowPass<R>> {
        match &self.running {
            Running::LowPass(low_pass) if self.held.is_some() => Some(low_pass),
            _ => None,
        }
    }

    /// Advances over `ticks` missing samples, in bounded time. x is constant: the given one or the last.
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
