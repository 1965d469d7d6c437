//! Cost of a fit on this machine.
//!
//! Times are the shortest of several runs on one thread. The reference is the peak rate of multiply-adds of the same machine, measured in
//! the same process.

pub mod evaluator;

use std::hint::black_box;

use pulp::{Arch, Simd, WithSimd};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::timing::least_time;
use fos_fit::candidates::{Candidates, CandidatesError, Monomial};
use fos_fit::fit::autoregression::{self, Method};
use fos_fit::fit::{AutoregressionError, FitError, Search, Stop, StopRule, fit, fos, refit, textbook};
use fos_fit::moments::{Moments, Rows};
use fos_fit::signal::wavelet::Denoising;

/// Settings of the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples of the record.
    pub samples: usize,
    /// Largest output lag, L.
    pub max_lag: u16,
    /// Cross-product degree, CP.
    pub degree: usize,
    /// Number of selected terms.
    pub terms: usize,
    /// Runs of the fast search; the shortest time counts.
    pub repeats: usize,
    /// Runs of the textbook implementation; 0 skips it.
    pub twin_repeats: usize,
}

impl Default for Settings {
    /// Three minutes at 200 Hz, the paper's record and largest pool; ten terms.
    fn default() -> Self {
        Self { samples: 36_000, max_lag: 10, degree: 2, terms: 10, repeats: 20, twin_repeats: 1 }
    }
}

/// Results; times in seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timings {
    /// Samples of the record.
    pub samples: usize,
    /// Candidates searched.
    pub candidates: usize,
    /// Number of selected terms.
    pub terms: usize,
    /// One pass over the data and the Gram matrix.
    pub moments_s: f64,
    /// The search on the Gram matrix.
    pub search_s: f64,
    /// Orthogonal refit and residuals.
    pub refit_s: f64,
    /// Sum of the three times.
    pub total_s: f64,
    /// The textbook search on the same data, without refit.
    pub twin_s: Option<f64>,
    /// `twin_s` over the time of moments and search.
    pub times_faster: Option<f64>,
    /// Sums that need a pass over the data.
    pub distinct_moments: usize,
    /// Peak rate of multiply-adds of this machine, one thread, per second.
    pub peak_multiply_adds_per_s: f64,
    /// `moments_s` over `distinct_moments`·`samples` at the peak rate.
    pub moments_over_limit: f64,
    /// Bytes in use besides the data: sums, buffers, Gram matrix and its factor. Computed from the sizes of allocations, not measured.
    pub working_bytes: usize,
    /// Name and time of a whole fit by each method, on the same record at order L, s.
    pub methods_s: Vec<(String, f64)>,
}

/// The measurement failed.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The candidates cannot be built.
    #[error(transparent)]
    Candidates(#[from] CandidatesError),
    /// FOS failed on the record.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// An autoregression failed on the record.
    #[error(transparent)]
    Autoregression(#[from] AutoregressionError),
    /// The evaluator refuses the model.
    #[error(transparent)]
    Model(#[from] fos_core::ModelError),
}

/// Times a fit of a simulated record, y(n) = 1.6 y(n−1) − 0.95 y(n−2) + 0.42 y(n−3) − 0.13 y(n−4) + e(n).
///
/// # Errors
/// The settings give no candidates, or the record is too short for them.
pub fn measure(settings: &Settings) -> Result<Timings, BenchError> {
    let Settings { samples, max_lag, degree, terms, repeats, twin_repeats } = *settings;
    let pool = Candidates::builder().output(1..=max_lag, degree).build()?;
    let signal = record(samples);
    let signals = [&signal[..]];
    let rule = StopRule { max_terms: terms, stop: Stop::Never };
    let rows = Rows::usable(&signals, std::slice::from_ref(&(0..samples)), pool.factors());

    let prepare = || -> Result<_, FitError> {
        let rows = Rows::usable(&signals, std::slice::from_ref(&(0..samples)), pool.factors());
        let moments = Moments::accumulate(&signals, &rows, &pool);
        let gram = moments.gram()?;
        Ok((moments, gram))
    };
    let (moments_s, prepared) = least_time(repeats, prepare);
    let (moments, gram) = prepared?;
    let (search_s, selection) = least_time(repeats, || fos::search(&gram, &rule));
    let chosen: Vec<Monomial> = selection.candidates().map(|i| pool.monomials()[i].clone()).collect();
    let (refit_s, refitted) = least_time(repeats, || refit::refit(&signals, &rows, &chosen));
    refitted.map_err(FitError::from)?;

    let twin_s = if twin_repeats > 0 {
        Some(least_time(twin_repeats, || textbook::search(&signals, &rows, &pool, &rule)).0)
    } else {
        None
    };
    let peak = peak_multiply_adds_per_second();
    let limit_s = (moments.distinct() * samples) as f64 / peak;
    let gram_bytes = (pool.len() * (pool.len() + terms + 4)) * size_of::<f64>();
    Ok(Timings {
        samples,
        candidates: pool.len(),
        terms: chosen.len(),
        moments_s,
        search_s,
        refit_s,
        total_s: moments_s + search_s + refit_s,
        twin_s,
        times_faster: twin_s.map(|twin| twin / (moments_s + search_s)),
        distinct_moments: moments.distinct(),
        peak_multiply_adds_per_s: peak,
        moments_over_limit: moments_s / limit_s,
        working_bytes: moments.bytes() + gram_bytes + refit::working_bytes(chosen.len()),
        methods_s: time_methods(&signal, settings)?,
    })
}

/// Computing times as compared in the paper: the classical methods with and without de-noising, and FOS of CP 1 and 2.
fn time_methods(signal: &[f64], settings: &Settings) -> Result<Vec<(String, f64)>, BenchError> {
    let Settings { samples, max_lag, terms, repeats, .. } = *settings;
    let order = usize::from(max_lag);
    let denoising = Denoising::of_the_paper();
    let mut times = Vec::new();
    let (denoise_s, denoised) = least_time(repeats, || denoising.denoise(signal));
    times.push((format!("de-noising, {denoising}"), denoise_s));
    for method in Method::ALL {
        let (raw_s, raw) = least_time(repeats, || autoregression::estimate(method, &[signal], order));
        raw?;
        let (after_s, after) = least_time(repeats, || autoregression::estimate(method, &[&denoised], order));
        after?;
        times.push((method.to_string(), raw_s));
        times.push((format!("de-noising and {method}"), denoise_s + after_s));
    }
    let rule = StopRule { max_terms: terms, stop: Stop::Never };
    for degree in [1, 2] {
        let pool = Candidates::builder().output(1..=max_lag, degree).build()?;
        let whole = 0..samples;
        let run = || fit(&[signal], std::slice::from_ref(&whole), &pool, &rule, Search::Greedy);
        let (time_s, fitted) = least_time(repeats, run);
        fitted?;
        times.push((format!("fos, CP {degree}"), time_s));
    }
    Ok(times)
}

/// Peak rate of multiply-adds per second of one thread, with operands in registers and independent results.
pub fn peak_multiply_adds_per_second() -> f64 {
    struct Peak;
    impl WithSimd for Peak {
        /// Sum, so that nothing is optimised away, and number of multiply-adds.
        type Output = (f64, usize);

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> (f64, usize) {
            /// Two execution units with a latency of four cycles need eight chains; twelve leave a margin and fit 16 registers.
            const CHAINS: usize = 12;
            const STEPS: usize = 200_000;
            let (factor, addend) = (simd.splat_f64s(black_box(0.999)), simd.splat_f64s(black_box(0.001)));
            let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
            for _ in 0..STEPS {
                for sum in &mut sums {
                    *sum = simd.mul_add_e_f64s(*sum, factor, addend);
                }
            }
            let total = sums.into_iter().map(|sum| simd.reduce_sum_f64s(sum)).sum();
            (total, STEPS * CHAINS * S::F64_LANES)
        }
    }
    let (time, (_, done)) = least_time(10, || Arch::new().dispatch(Peak));
    done as f64 / time
}

/// A seeded AR(4) record.
fn record(samples: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut signal: Vec<f64> = Vec::with_capacity(samples);
    for n in 0..samples {
        let past = |lag: usize| if n >= lag { signal[n - lag] } else { 0.0 };
        let noise: f64 = StandardNormal.sample(&mut random);
        signal.push(1.6 * past(1) - 0.95 * past(2) + 0.42 * past(3) - 0.13 * past(4) + 0.2 * noise);
    }
    signal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn benchmark_measures_every_part() {
        let settings = Settings { samples: 3000, max_lag: 3, repeats: 2, ..Settings::default() };
        let timings = measure(&settings).unwrap();
        assert_eq!((timings.candidates, timings.terms), (9, 9));
        let times = [timings.moments_s, timings.search_s, timings.refit_s, timings.twin_s.unwrap()];
        assert!(times.iter().all(|t| *t > 0.0));
        assert!(timings.peak_multiply_adds_per_s > 1e8);
        assert!(timings.working_bytes < 20_000_000);
    }
}
