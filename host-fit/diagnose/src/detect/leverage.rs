//! Extrapolation in combinations of inputs: each input alone may stay in its fitted range while their combination was
//! hardly excited.

use fos_fit::signal;
use nalgebra::{DMatrix, DVector};

/// Share of the blocks that may go further.
const TAIL: f64 = 0.05;

/// Returns the largest leverage xᵀ C⁻¹ x of the blocks of a log divided by the largest of the fitted blocks, with C
/// their covariance; 5 % of the blocks are ignored. `None` for a single column, which is bounded by its limits.
pub(super) fn beyond(learnt: &[&[f64]], evaluated: &[Vec<f64>]) -> Option<f64> {
    let (k, n) = (learnt.len(), learnt.first()?.len());
    if k < 2 || evaluated.len() != k {
        return None;
    }
    let means: Vec<f64> = learnt.iter().map(|column| signal::mean(&[column])).collect();
    let at = |columns: &dyn Fn(usize) -> f64| DVector::from_fn(k, |i, _| columns(i) - means[i]);
    let learnt_vectors: Vec<DVector<f64>> = (0..n).map(|block| at(&|i| learnt[i][block])).collect();
    let evaluated_vectors: Vec<DVector<f64>> =
        (0..evaluated[0].len()).map(|block| at(&|i| evaluated[i][block])).collect();
    let covariance = learnt_vectors.iter().fold(DMatrix::zeros(k, k), |sum, x| sum + x * x.transpose());
    let cholesky = covariance.cholesky()?;
    let leverage = |x: &DVector<f64>| x.dot(&cholesky.solve(x));
    let most = learnt_vectors.iter().map(leverage).fold(0.0, f64::max);
    let mut evaluated: Vec<f64> = evaluated_vectors.iter().map(leverage).collect();
    evaluated.sort_unstable_by(f64::total_cmp);
    let last = evaluated.len().checked_sub(1)?;
    Some(evaluated[((1.0 - TAIL) * last as f64) as usize] / most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_combinations_outside_the_fitted_range() {
        let along = |a: f64, b: f64| -> [Vec<f64>; 2] {
            let wave = |row: usize| (0.1 * row as f64).sin();
            let other = |row: usize| 0.01 * (1.7 * row as f64).cos();
            let column =
                |gain: f64| (0..600).map(|row| gain * wave(row) + other(row * gain as usize)).collect();
            [column(a), column(b)]
        };
        let learnt = along(1.0, 2.0);
        let learnt: Vec<&[f64]> = learnt.iter().map(Vec::as_slice).collect();
        assert!(beyond(&learnt, &along(1.0, 2.0)).unwrap() < 1.0);
        assert!(beyond(&learnt, &along(1.0, -2.0)).unwrap() > 100.0);
        assert_eq!(beyond(&learnt[..1], &along(1.0, 2.0)[..1]), None);
    }
}
