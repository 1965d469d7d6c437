//! Statistics of a sampled series: its power by frequency, lag and averaging time, and the part that no predictor can
//! forecast.
//!
//! Every function takes `stretches: &[&[f64]]`, the gap-free pieces of one recording in the order they were
//! measured, all at the same rate. Nothing is ever computed across the end of a stretch: no lag product, no
//! difference of averages, no Fourier transform, no block. One unbroken recording is one stretch:
//! `welch(&[&series], …)`.
//!
//! Values must be finite. A NaN is not looked for and would spread into every result; splitting a recording
//! at its gaps is the caller's duty.
//!
//! | file | answers |
//! |---|---|
//! | `blocks` | slow error: variance of block means; envelopes for display |
//! | `spectrum` | power spectral density (Welch) |
//! | `autocorrelation` | memory of the series, with the bound for white noise |
//! | `allan` | Allan deviation with its confidence interval |
//! | `noise_floor` | lowest mean square error of a causal linear predictor |
//! | `transforms` | Fourier transforms, planned once |
//! | `wavelet` | de-noising: the series without the noise of single samples |
//! | `quantisation` | step of the converter, estimated from the data |

pub mod allan;
pub mod autocorrelation;
pub mod blocks;
pub mod noise_floor;
pub mod quantisation;
pub mod spectrum;
pub mod transforms;
pub mod wavelet;

pub use fos_data::statistics::{centred, is_constant, mean, sample_count, variance};
