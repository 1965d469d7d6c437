//! Weighted nonlinear least squares by Levenberg–Marquardt with orthogonal factorisations.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};

/// Most iterations; ellipsoid fits need 5 to 15.
pub(crate) const MAX_ITERATIONS: usize = 100;

/// Relative decrease of the sum of squares at which the iteration ends: a step of 1e-5 standard errors.
pub(crate) const CONVERGED: f64 = 1e-10;

/// The same for weights that change afterwards.
pub(crate) const NEARLY: f64 = 1e-4;

/// Residuals and Jacobian at a point: `n`, `n × p`, both whitened (divided by the standard deviation of each residual).
pub(crate) struct Linearised {
    pub(crate) residuals: DVector<f64>,
    pub(crate) jacobian: DMatrix<f64>,
}

/// More degrees of freedom than this use the normal quantile, which is within 1e-4 of Student's. The inverse of Student's
/// distribution does not end for absurdly many.
const NORMAL_DEGREES: f64 = 1e5;

/// A minimum.
pub(crate) struct Minimum {
    pub(crate) parameters: DVector<f64>,
    pub(crate) at: Linearised,
    pub(crate) iterations: usize,
}

/// Minimises the sum of squares of the residuals that `linearise` returns.
///
/// Each step solves min ‖[J; √λ·diag(‖Jᵢ‖)]·δ + [r; 0]‖ by QR (Moré 1978, equation 3.1). Returns `None` if no finite residual or
/// factorisation is found; a rank-deficient problem still converges, to a point near the start.
pub(crate) fn minimise(
    start: DVector<f64>,
    converged: f64,
    linearise: impl Fn(&DVector<f64>) -> Linearised,
) -> Option<Minimum> {
    let mut parameters = start;
    let mut at = linearise(&parameters);
    let mut cost = at.residuals.norm_squared();
    let mut lambda = 1e-3;
    let mut iterations = 0;
    if !cost.is_finite() {
        return None;
    }
    while iterations < MAX_ITERATIONS {
        iterations += 1;
        let step = damped_step(&at, lambda)?;
        let tried = &parameters + &step;
        let next = linearise(&tried);
        let next_cost = next.residuals.norm_squared();
        if next_cost.is_finite() && next_cost <= cost {
            let is_done = cost - next_cost <= converged * cost;
            (parameters, at, cost) = (tried, next, next_cost);
            lambda = (lambda * 0.1_f64).max(1e-12);
            if is_done {
                break;
            }
        } else {
            lambda *= 10.0;
            if lambda > 1e12 {
                break;
            }
        }
    }
    Some(Minimum { parameters, at, iterations })
}

fn damped_step(at: &Linearised, lambda: f64) -> Option<DVector<f64>> {
    let (rows, columns) = at.jacobian.shape();
    let mut augmented = DMatrix::zeros(rows + columns, columns);
    augmented.view_mut((0, 0), (rows, columns)).copy_from(&at.jacobian);
    for column in 0..columns {
        let norm = at.jacobian.column(column).norm();
        augmented[(rows + column, column)] = lambda.sqrt() * if norm > 0.0 { norm } else { 1.0 };
    }
    let mut right = DVector::zeros(rows + columns);
    right.rows_mut(0, rows).copy_from(&-&at.residuals);
    solve(augmented, right)
}

/// The least-squares solution of a tall system by QR; `None` if a column is dependent.
pub(crate) fn solve(matrix: DMatrix<f64>, mut right: DVector<f64>) -> Option<DVector<f64>> {
    let columns = matrix.ncols();
    let qr = matrix.qr();
    qr.q_tr_mul(&mut right);
    let solution = qr.r().solve_upper_triangular(&right.rows(0, columns).into_owned())?;
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

/// Covariance of the parameters for residuals of unit variance, (JᵀJ)⁻¹ = R⁻¹R⁻ᵀ; `None` if J has dependent columns.
pub(crate) fn covariance(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let columns = jacobian.ncols();
    if jacobian.nrows() < columns {
        return None;
    }
    let r = jacobian.clone().qr().r();
    let inverse = r.solve_upper_triangular(&DMatrix::identity(columns, columns))?;
    let covariance = &inverse * inverse.transpose();
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

/// Chance to exclude a rest, a turn or a plateau of a log without outliers.
pub(crate) const OUTLIER_CHANCE: f64 = 1e-3;

/// Leverages: the diagonal of J(JᵀJ)⁻¹Jᵀ. Rounding of a rank-deficient J gives values outside 0 … 1, which are clamped.
pub(crate) fn leverages(jacobian: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let of_row = |sum: f64| if sum.is_nan() { 1.0 } else { sum.clamp(0.0, 1.0) };
    (jacobian * covariance).component_mul(jacobian).row_iter().map(|row| of_row(row.sum())).collect()
}

/// Two-sided quantile of Student's t that holds a share `level` of it; of the normal distribution in the limit.
pub(crate) fn student(level: f64, degrees_of_freedom: f64) -> f64 {
    let tail = 0.5 + 0.5 * level;
    if degrees_of_freedom > NORMAL_DEGREES {
        return Normal::standard().inverse_cdf(tail);
    }
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(tail))
}

/// Root mean square; `None` without values.
pub(crate) fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// The variance, common to all residuals, that brings the weighted sum of squares to its expectation (Paule and Mandel
/// 1982, with the degrees of freedom of the fit): the root of Σ rₖ²/(vₖ + τ²) = n − p, or 0 where the known variances vₖ
/// suffice.
pub(crate) fn excess_variance(residuals: &[f64], known: &[f64], degrees_of_freedom: f64) -> f64 {
    let sum = |excess: f64| -> f64 {
        residuals.iter().zip(known).map(|(r, v)| r * r / (v + excess).max(f64::MIN_POSITIVE)).sum()
    };
    if degrees_of_freedom <= 0.0 || sum(0.0) <= degrees_of_freedom {
        return 0.0;
    }
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let (mut low, mut high) = (0.0, squares / degrees_of_freedom);
    // 60 halvings reach the last bit of the ratio of the two ends
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if sum(middle) > degrees_of_freedom { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's function as a sum of squares (Moré, Garbow and Hillstrom 1981, problem 1).
    #[test]
    fn finds_the_minimum_of_a_published_problem() {
        let linearise = |x: &DVector<f64>| Linearised {
            residuals: DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
            jacobian: DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]),
        };
        let found = minimise(DVector::from_vec(vec![-1.2, 1.0]), 1e-14, linearise).expect("a minimum");
        assert!((found.parameters - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-9);
        assert!(found.iterations < MAX_ITERATIONS);
    }

    #[test]
    fn covariance_matches_normal_equations() {
        let jacobian = DMatrix::from_fn(7, 3, |i, j| ((i * 3 + j * 5 + 1) % 7) as f64 - 2.5);
        let direct = (jacobian.transpose() * &jacobian).try_inverse().expect("regular");
        let found = covariance(&jacobian).expect("regular");
        assert!((&found - direct).norm() < 1e-12 * found.norm());
        let trace: f64 = leverages(&jacobian, &found).iter().sum();
        assert!((trace - 3.0).abs() < 1e-12, "the leverages add up to the number of parameters: {trace}");
        let dependent = DMatrix::from_fn(7, 2, |i, _| i as f64);
        assert!(covariance(&dependent).is_none_or(|c| c.norm() > 1e12));
    }

    #[test]
    fn quantiles_match_tables() {
        for (degrees, quantile) in [(1.0, 12.706), (3.0, 3.182), (10.0, 2.228), (30.0, 2.042)] {
            assert!((student(0.95, degrees) - quantile).abs() < 6e-4, "{degrees}");
        }
        for degrees in [1.1e5, 1e15, 1e300, f64::INFINITY] {
            assert!((student(0.95, degrees) - 1.960).abs() < 1e-3, "{degrees}");
        }
    }

    #[test]
    fn leverages_of_a_rank_deficient_problem_stay_between_0_and_1() {
        let jacobian = DMatrix::from_fn(9, 3, |i, j| if j < 2 { 0.1 * (i as f64 + 1.0) } else { 1e-9 });
        let garbage = DMatrix::from_element(3, 3, 1e30);
        assert!(leverages(&jacobian, &garbage).iter().all(|h| (0.0..=1.0).contains(h)));
        let garbage = DMatrix::from_element(3, 3, f64::NAN);
        assert!(leverages(&jacobian, &garbage).iter().all(|h| *h == 1.0));
    }

    #[test]
    fn excess_variance_brings_the_sum_to_its_expectation() {
        let (residuals, known) = ([1.0, -2.0, 3.0, -1.5], [0.1, 0.2, 0.1, 0.4]);
        let excess = excess_variance(&residuals, &known, 3.0);
        let sum: f64 = residuals.iter().zip(known).map(|(r, v)| r * r / (v + excess)).sum();
        assert!((sum - 3.0).abs() < 1e-9);
        assert_eq!(excess_variance(&residuals, &[100.0; 4], 3.0), 0.0);
    }
}
