//! What the comparison is made with.

use serde::Serialize;

use fos_fit::fit::Search;
use fos_fit::signal::wavelet::Denoising;

/// How the comparison is made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Length of the training part, s at rest.
    pub train_s: f64,
    /// Length of the evaluation part, s at rest.
    pub evaluate_s: f64,
    /// Model orders 1 … this.
    pub max_order: u16,
    /// Cross-product degrees 1 … this.
    pub max_degree: usize,
    /// What is done to the training data of the methods of the autoregression.
    pub denoising: Denoising,
    /// Fits that each time is the median of.
    pub repeats: usize,
    /// How FOS searches; the paper's is greedy.
    pub search: Search,
}
