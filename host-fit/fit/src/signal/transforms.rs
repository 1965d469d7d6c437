//! Fourier transforms of real series with cached plans: the tables of a plan take as long as a transform.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// Number of cached lengths: the tables for an hour at 200 Hz take some megabytes.
const CACHED_LENGTHS: usize = 16;

/// Planner, which caches its plans, and the cached lengths.
static PLANNER: LazyLock<Mutex<(RealFftPlanner<f64>, Vec<usize>)>> =
    LazyLock::new(|| Mutex::new((RealFftPlanner::new(), Vec::new())));

/// Returns the transform from `n` real samples to n/2 + 1 bins, not normalised.
pub fn forward(n: usize) -> Arc<dyn RealToComplex<f64>> {
    planned(n, |planner| planner.plan_fft_forward(n))
}

/// Returns the transform from n/2 + 1 bins to `n` real samples, not normalised.
pub fn inverse(n: usize) -> Arc<dyn ComplexToReal<f64>> {
    planned(n, |planner| planner.plan_fft_inverse(n))
}

fn planned<T>(n: usize, plan: impl FnOnce(&mut RealFftPlanner<f64>) -> T) -> T {
    let mut held = PLANNER.lock().unwrap_or_else(PoisonError::into_inner);
    let (planner, lengths) = &mut *held;
    if !lengths.contains(&n) {
        if lengths.len() == CACHED_LENGTHS {
            (*planner, *lengths) = (RealFftPlanner::new(), Vec::new());
        }
        lengths.push(n);
    }
    plan(planner)
}
