//! A transform at work on its own, as an input runs it: for a host that looks for inputs.

use crate::transform::Running;
use crate::{Real, Transform};

/// A [`Transform`] with its state. The logged values are taken as they are: centre 0, scale 1.
///
/// ```
/// use fos_core::{Transform, Transformer};
///
/// let mut low_pass = Transformer::new(&Transform::LowPass { tau_s: 2.0 }, 0.005);
/// assert_eq!(low_pass.update(21.5), 21.5); // starts at the first value
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Transformer<R> {
    running: Running<R>,
    held: Option<R>,
}

impl<R: Real> Transformer<R> {
    /// The transform at power-on, for a sample period in seconds.
    pub fn new(transform: &Transform<R>, period_s: f64) -> Self {
        Self { running: Running::new(transform, period_s, R::ZERO, R::ONE), held: None }
    }

    /// One sample: u(n) from x(n). A value that is not finite stands for the last one before it.
    #[inline]
    pub fn update(&mut self, x: R) -> R {
        let x = match (x.is_finite(), self.held) {
            (true, None) => {
                self.running.start_at(x);
                x
            }
            (true, Some(_)) => x,
            (false, held) => held.unwrap_or(R::ZERO),
        };
        self.held = Some(x);
        self.running.update(x)
    }

    /// `ticks` missing samples, x taken to have stayed.
    pub fn skip(&mut self, ticks: u32) {
        self.running.skip(self.held.unwrap_or(R::ZERO), ticks);
    }
}

#[cfg(feature = "defmt")]
impl<R: defmt::Format> defmt::Format for Transformer<R> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Transformer {{ held: {} }}", self.held);
    }
}
