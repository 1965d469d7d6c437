//! Fourier transforms of real series, planned once for each length: the tables of a plan take as long as a transform.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// Lengths whose tables are kept: of an hour at 200 Hz each is some megabytes.
const KEPT: usize = 16;

/// A planner, which keeps what it has planned, and the lengths of that.
static PLANNER: LazyLock<Mutex<(RealFftPlanner<f64>, Vec<usize>)>> =
    LazyLock::new(|| Mutex::new((RealFftPlanner::new(), Vec::new())));

/// From `n` real samples to n/2 + 1 bins, not normalised.
pub fn forward(n: usize) -> Arc<dyn RealToComplex<f64>> {
    planned(n, |planner| planner.plan_fft_forward(n))
}

/// From n/2 + 1 bins to `n` real samples, not normalised.
pub fn inverse(n: usize) -> Arc<dyn ComplexToReal<f64>> {
    planned(n, |planner| planner.plan_fft_inverse(n))
}

fn planned<T>(n: usize, plan: impl FnOnce(&mut RealFftPlanner<f64>) -> T) -> T {
    let mut held = PLANNER.lock().unwrap_or_else(PoisonError::into_inner);
    let (planner, lengths) = &mut *held;
    if !lengths.contains(&n) {
        if lengths.len() == KEPT {
            (*planner, *lengths) = (RealFftPlanner::new(), Vec::new());
        }
        lengths.push(n);
    }
    plan(planner)
}
