//! When the search stops adding terms.

use crate::moments::Gram;

/// Smallest MSE/⟨y²⟩ that equation (7) of the search can tell from zero.
pub(super) const EXACT: f64 = 1e-13;

/// The rules under which a search goes on; it stops at the first one broken.
///
/// | field | default | stops when |
/// |---|---|---|
/// | `max_terms` | 30 | so many terms are chosen, the constant not counted |
/// | `mse_ratio` | `None` | MSE/var(y) is at or below it |
/// | `noise` | `ExtendedBic` | the best candidate does no more than noise would |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// Most terms to choose, the constant not counted.
    pub max_terms: usize,
    /// Mean square error, as a share of the variance of the target, that is good enough.
    pub mse_ratio: Option<f64>,
    /// What a term must do beyond fitting noise.
    pub noise: NoiseRule,
}

impl Default for StopRule {
    fn default() -> Self {
        Self { max_terms: 30, mse_ratio: None, noise: NoiseRule::ExtendedBic }
    }
}

/// What the best candidate's Q (drop in mean square error) is held against: Q must reach
/// [`threshold`](Self::threshold)·MSE, MSE being the error before the candidate is added.
///
/// If what is left were white, n·Q/MSE of *one* candidate would be chi-square with one degree of freedom. The
/// search takes the best of M, so a bound for one admits spurious terms almost surely when M is large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseRule {
    Off,
    /// Korenberg's rule as published, Q < 4/(n + 1)·MSE: the 95 % band of one correlation. On white noise it
    /// admits a spurious term from a pool of 65 in more than nine records of ten.
    Korenberg,
    /// Q < (ln n + 2 ln M)/n·MSE: the extended information criterion (Chen and Chen, Biometrika 95 (2008) 759,
    /// with γ = 1) for one more term, which allows for the M candidates tried.
    #[default]
    ExtendedBic,
}

impl NoiseRule {
    /// The smallest Q/MSE worth a term, from `rows` rows (n) and a pool of `candidates` (M).
    pub fn threshold(self, rows: usize, candidates: usize) -> f64 {
        let (n, m) = (rows as f64, candidates as f64);
        match self {
            Self::Off => 0.0,
            Self::Korenberg => 4.0 / (n + 1.0),
            Self::ExtendedBic => (n.ln() + 2.0 * m.ln()) / n,
        }
    }
}

/// What a rule asks of a term, on given data: one measure for adding, for taking out and for comparing.
///
/// A set of K terms costs ln MSE + K·ln(1/(1 − t)), t being the threshold of the noise rule and an MSE within rounding
/// of zero counting as [`EXACT`]. A term is worth having where it does not raise the cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worth {
    threshold: f64,
    /// What an MSE is held to be at least, unit of y².
    exact: f64,
}

impl StopRule {
    /// What it asks of a term.
    pub(super) fn worth(&self, gram: &Gram) -> Worth {
        // a threshold of 1 or more, from very few rows, admits no term; the next smaller number does as much: ln of it
        // exceeds all that ln MSE can fall by, ln(1/EXACT)
        let threshold = self.noise.threshold(gram.rows(), gram.size()).min(1.0 - f64::EPSILON / 2.0);
        Worth { threshold, exact: EXACT * gram.target_mean_square() }
    }
}

impl Worth {
    /// The least Q worth a term, beside an MSE before it.
    pub(super) fn needed(&self, mse: f64) -> f64 {
        self.threshold * mse
    }

    /// Whether so little is left that no term can be worth having: rounding error, or hardly more.
    pub(super) fn is_exact(&self, mse: f64) -> bool {
        mse - self.needed(mse) <= self.exact
    }

    /// Whether a term is worth having that takes `reduction` (Q) off `mse`. Not one whose Q is NaN: products of the
    /// signals overflow.
    pub(super) fn takes(&self, reduction: f64, mse: f64) -> bool {
        !self.is_exact(mse) && reduction >= self.needed(mse)
    }

    /// The cost of a set of terms.
    pub(super) fn cost(&self, mse: f64, terms: usize) -> f64 {
        mse.max(self.exact).ln() - terms as f64 * (-self.threshold).ln_1p()
    }
}

/// Why a search stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stopped {
    /// [`StopRule::max_terms`] reached.
    MaxTerms,
    /// [`StopRule::mse_ratio`] reached.
    MseRatio,
    /// The best candidate left does no more than noise would.
    Noise {
        /// Its index in the pool.
        candidate: usize,
        mse_reduction: f64,
        /// The Q it would have needed.
        needed: f64,
    },
    /// Every candidate is in the model or collinear with it.
    NothingLeft,
    /// What is left is rounding error: the target is an exact sum of the terms.
    Exact,
    /// What more terms, or others, would take off the MSE is within the rounding error of the MSE: the signal is so
    /// smooth that its lags are nearly sums of one another.
    Rounding,
    /// As many exchanges were made as are allowed; another might still lower the error.
    MostMoves,
}
