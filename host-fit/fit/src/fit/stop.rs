//! Stop rules of the search.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::moments::Gram;

/// Smallest MSE/⟨y²⟩ that equation (7) of the search distinguishes from zero.
pub(super) const EXACT: f64 = 1e-13;

/// Conditions under which a search continues; it stops at the first one violated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// Largest number of terms, the constant not counted. Default 30.
    pub max_terms: usize,
    /// Threshold that separates a term from noise.
    pub stop: Stop,
}

impl Default for StopRule {
    fn default() -> Self {
        Self { max_terms: 30, stop: Stop::Multiplicity }
    }
}

/// Stop rule of the search before the largest number of terms: Q of the best candidate (reduction of the mean square
/// error) must reach [`threshold`](Self::threshold)·MSE, with the MSE before the candidate is added.
///
/// For a white residual, n·Q/MSE of *one* candidate is chi-square with one degree of freedom. The search takes the best
/// of M, so a bound for one admits spurious terms almost surely when M is large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// Q < (ln n + 2 ln M)/n·MSE: the extended information criterion (Chen and Chen, Biometrika 95 (2008) 759,
    /// with γ = 1) for one more term, which allows for the M candidates tried (the default).
    Multiplicity,
    /// Korenberg's rule as published, Q < 4/(n + 1)·MSE: the 95 % band of one correlation. On white noise it admits a
    /// spurious term from a pool of 65 in more than nine records of ten.
    Korenberg,
    Never,
}

impl Stop {
    /// Returns the smallest significant Q/MSE, for `rows` rows (n) and a pool of `candidates` (M).
    pub fn threshold(self, rows: usize, candidates: usize) -> f64 {
        let (n, m) = (rows as f64, candidates as f64);
        match self {
            Self::Multiplicity => (n.ln() + 2.0 * m.ln()) / n,
            Self::Korenberg => 4.0 / (n + 1.0),
            Self::Never => 0.0,
        }
    }
}

impl FromStr for Stop {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "multiplicity" => Ok(Self::Multiplicity),
            "korenberg" => Ok(Self::Korenberg),
            "never" => Ok(Self::Never),
            other => Err(format!("{other:?} is not one of multiplicity, korenberg, never")),
        }
    }
}

/// Cost of a set of terms on given data: one measure for adding, removing and comparing.
///
/// A set of K terms costs ln MSE + K·ln(1/(1 − t)), with t the threshold of the stop rule; an MSE within rounding of
/// zero counts as [`EXACT`]. A term is worth having if it does not increase the cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worth {
    threshold: f64,
    /// Lower bound of an MSE, unit of y².
    exact: f64,
}

impl StopRule {
    /// Returns the cost measure of this rule.
    pub(super) fn worth(&self, gram: &Gram) -> Worth {
        // a threshold of 1 or more, from very few rows, admits no term; nor does the next smaller number: its logarithm
        // exceeds the largest decrease of ln MSE, ln(1/EXACT)
        let threshold = self.stop.threshold(gram.rows(), gram.size()).min(1.0 - f64::EPSILON / 2.0);
        Worth { threshold, exact: EXACT * gram.target_mean_square() }
    }
}

impl Worth {
    /// Returns the least significant Q at an MSE before the term.
    pub(super) fn needed(&self, mse: f64) -> f64 {
        self.threshold * mse
    }

    /// Returns true if the MSE is so near rounding error that no term can be significant.
    pub(super) fn is_exact(&self, mse: f64) -> bool {
        mse - self.needed(mse) <= self.exact
    }

    /// Returns true if a term that reduces `mse` by `reduction` (Q) is worth having; false if Q is NaN because products
    /// of the signals overflow.
    pub(super) fn takes(&self, reduction: f64, mse: f64) -> bool {
        !self.is_exact(mse) && reduction >= self.needed(mse)
    }

    /// Returns the cost of a set of terms.
    pub(super) fn cost(&self, mse: f64, terms: usize) -> f64 {
        mse.max(self.exact).ln() - terms as f64 * (-self.threshold).ln_1p()
    }
}

/// Reason why a search stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stopped {
    /// The limit [`StopRule::max_terms`] is reached.
    MaxTerms,
    /// The best remaining candidate is not significant.
    Noise {
        /// Index of the candidate in the pool.
        candidate: usize,
        mse_reduction: f64,
        /// Least significant Q.
        needed: f64,
    },
    /// Every candidate is in the model or collinear with it.
    NothingLeft,
    /// The residual is rounding error: the target is an exact sum of the terms.
    Exact,
    /// Further reductions of the MSE are within its rounding error: the signal is so smooth that its lags are nearly
    /// sums of one another.
    Rounding,
    /// The largest number of exchanges was made; another one might still reduce the error.
    MostMoves,
}
