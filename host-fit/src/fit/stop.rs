//! When the search stops adding terms.

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
    /// No test.
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
        /// Its Q.
        mse_reduction: f64,
        /// The Q it would have needed.
        needed: f64,
    },
    /// Every candidate is in the model or collinear with it.
    NothingLeft,
    /// What is left is rounding error: the target is an exact sum of the terms.
    Exact,
}
