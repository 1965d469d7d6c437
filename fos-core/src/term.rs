//! Terms, the summands of a model: a coefficient times a product of delayed samples.

use serde::{Deserialize, Serialize};

/// Highest degree of a term. The degree is the paper's cross-product degree (CP).
pub const MAX_DEGREE: usize = 3;

/// Series that a [`Factor`] delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// The axis' own remainder r = y − p, the model's output fed back (paper eq. 14: y).
    Output,
    /// Input `u_i` (paper eq. 14: x).
    Input(u8),
}

/// One delayed sample: r(n − lag) or u_i(n − lag), paper eq. 14.
///
/// An output needs `lag ≥ 1`, because its present value is being predicted. An input may have lag 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Factor {
    /// Output of the axis, or an input.
    pub channel: Channel,
    /// Delay, samples.
    pub lag: u16,
}

/// The factor r(n − lag).
pub const fn y(lag: u16) -> Factor {
    Factor { channel: Channel::Output, lag }
}

/// The factor u_input(n − lag).
pub const fn u(input: u8, lag: u16) -> Factor {
    Factor { channel: Channel::Input(input), lag }
}

/// A coefficient times a product of one to [`MAX_DEGREE`] factors, all in scaled units.
///
/// ```
/// use fos_core::{Term, u, y};
/// const LINEAR: Term<f32> = Term::new(0.82, &[y(1)]);
/// const CROSS: Term<f32> = Term::new(0.004, &[y(1), u(0, 0)]); // y(n−1) · u0(n)
/// assert_eq!((LINEAR.factors().len(), CROSS.factors().len()), (1, 2));
/// ```
///
/// An invalid term does not compile:
///
/// ```compile_fail
/// use fos_core::{Term, y};
/// const PRESENT: Term<f32> = Term::new(0.82, &[y(0)]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term<R> {
    /// Coefficient, in scaled units.
    pub coefficient: R,
    factors: [Factor; MAX_DEGREE],
    degree: u8,
}

impl<R: Copy> Term<R> {
    /// A term that is known at compile time.
    ///
    /// # Panics
    ///
    /// At compile time, in a constant: on no factor, more than [`MAX_DEGREE`], or an output at lag 0.
    pub const fn new(coefficient: R, factors: &[Factor]) -> Self {
        match Self::try_new(coefficient, factors) {
            Some(term) => term,
            None => panic!("a term has 1 to 3 factors, and no output at lag 0"),
        }
    }

    /// A term from external data; `None` on no factor, more than [`MAX_DEGREE`], or an output at lag 0.
    pub const fn try_new(coefficient: R, factors: &[Factor]) -> Option<Self> {
        let (first, second, third, degree) = match *factors {
            [a] => (a, y(0), y(0), 1),
            [a, b] => (a, b, y(0), 2),
            [a, b, c] => (a, b, c, 3),
            _ => return None,
        };
        let term = Self { coefficient, factors: [first, second, third], degree };
        if is_present_output(first)
            || (degree > 1 && is_present_output(second))
            || (degree > 2 && is_present_output(third))
        {
            return None;
        }
        Some(term)
    }

    /// The same factors with another coefficient.
    pub const fn with_coefficient<S: Copy>(&self, coefficient: S) -> Term<S> {
        Term { coefficient, factors: self.factors, degree: self.degree }
    }

    /// Number of factors.
    pub(crate) const fn degree(&self) -> usize {
        self.degree as usize
    }

    /// A factor by its index below [`MAX_DEGREE`].
    pub(crate) const fn factor(&self, index: usize) -> Factor {
        self.factors[index]
    }

    /// Factors, in the order of multiplication.
    pub fn factors(&self) -> &[Factor] {
        self.factors.get(..usize::from(self.degree)).unwrap_or(&[])
    }
}

const fn is_present_output(factor: Factor) -> bool {
    matches!(factor.channel, Channel::Output) && factor.lag == 0
}

/// Omits the unused places for factors.
#[cfg(feature = "defmt")]
impl<R: Copy + defmt::Format> defmt::Format for Term<R> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Term {{ coefficient: {}, factors: {} }}", self.coefficient, self.factors());
    }
}
