//! Settings of the comparison.

use serde::Serialize;

use fos_fit::fit::Search;
use fos_fit::signal::wavelet::Denoising;

/// Settings of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Length of the training part, s at rest.
    pub train_s: f64,
    /// Length of the evaluation part, s at rest.
    pub evaluate_s: f64,
    /// Largest model order; all from 1 are compared.
    pub max_order: u16,
    /// Largest cross-product degree; all from 1 are compared.
    pub max_degree: usize,
    /// De-noising of the training data for the autoregressive methods.
    pub denoising: Denoising,
    /// Number of fits over which each time is the median.
    pub repeats: usize,
    /// Search method of FOS; greedy in the paper.
    pub search: Search,
}
