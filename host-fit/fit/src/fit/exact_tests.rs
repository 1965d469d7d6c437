//! Near-singular records compared with a reference in exact rational arithmetic: every f64 is a fraction, so the
//! coefficients of the reference have no rounding error at all.

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::autoregression::{AutoregressionError, Method, TRUSTED, estimate};
use super::*;

const ORDER: usize = 4;

fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap()
}

/// Solves A x = b by elimination; pivots of a positive definite matrix are never zero.
fn solve(mut rows: Vec<Vec<BigRational>>) -> Vec<f64> {
    let n = rows.len();
    for pivot in 0..n {
        for row in pivot + 1..n {
            let (above, below) = rows.split_at_mut(row);
            let factor = &below[0][pivot] / &above[pivot][pivot];
            for (entry, pivots) in below[0].iter_mut().zip(&above[pivot]).skip(pivot) {
                *entry -= &factor * pivots;
            }
        }
    }
    let mut x = vec![BigRational::zero(); n];
    for row in (0..n).rev() {
        let known: BigRational = (row + 1..n).map(|column| &rows[row][column] * &x[column]).sum();
        x[row] = (&rows[row][n] - known) / &rows[row][row];
    }
    x.iter().map(|x| x.to_f64().unwrap()).collect()
}

fn dot(a: &[BigRational], b: &[BigRational]) -> BigRational {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Least squares of the target on the regressors, both given row by row.
fn least_squares(rows: &[(Vec<BigRational>, BigRational)]) -> Vec<f64> {
    let n = rows[0].0.len();
    let entry = |i: usize, j: usize| -> BigRational {
        rows.iter().map(|(x, y)| &x[i] * if j < n { &x[j] } else { y }).sum()
    };
    solve((0..n).map(|i| (0..=n).map(|j| entry(i, j)).collect()).collect())
}

/// Regressors and target of every row, newest lag first.
fn forward(series: &[BigRational], constant: bool) -> Vec<(Vec<BigRational>, BigRational)> {
    let row = |n: usize| {
        let lags = (1..=ORDER).map(|k| series[n - k].clone());
        let one = constant.then(|| exact(1.0));
        (one.into_iter().chain(lags).collect(), series[n].clone())
    };
    (ORDER..series.len()).map(row).collect()
}

fn exact_coefficients(method: Method, series: &[f64]) -> Vec<f64> {
    let series: Vec<BigRational> = series.iter().map(|x| exact(*x)).collect();
    match method {
        Method::Covariance => least_squares(&forward(&series, false)),
        Method::ModifiedCovariance => {
            let reversed: Vec<BigRational> = series.iter().rev().cloned().collect();
            let mut rows = forward(&series, false);
            rows.extend(forward(&reversed, false));
            least_squares(&rows)
        }
        Method::YuleWalker => {
            let lagged: Vec<BigRational> =
                (0..=ORDER).map(|lag| dot(&series[lag..], &series[..series.len() - lag])).collect();
            let row = |i: usize| {
                let left = (0..ORDER).map(|j| lagged[i.abs_diff(j)].clone());
                left.chain([lagged[i + 1].clone()]).collect()
            };
            solve((0..ORDER).map(row).collect())
        }
        Method::Burg => {
            let (mut forward, mut backward) = (series.clone(), series);
            let mut coefficients: Vec<BigRational> = Vec::new();
            for _ in 0..ORDER {
                let f = forward[1..].to_vec();
                let b = backward[..backward.len() - 1].to_vec();
                let gamma = -(exact(2.0) * dot(&f, &b)) / (dot(&f, &f) + dot(&b, &b));
                let lower = coefficients.clone();
                for (a, mirrored) in coefficients.iter_mut().zip(lower.iter().rev()) {
                    *a += &gamma * mirrored;
                }
                coefficients.push(-gamma.clone());
                forward = f.iter().zip(&b).map(|(f, b)| f + &gamma * b).collect();
                backward = f.iter().zip(&b).map(|(f, b)| b + &gamma * f).collect();
            }
            coefficients.iter().map(|a| a.to_f64().unwrap()).collect()
        }
    }
}

/// Two undamped lines with very little noise: the MSE of an AR(4) is about `noise`² of the variance.
fn lines(noise: f64) -> Vec<f64> {
    two_lines([0.7, 1.9], noise)
}

/// Two lines at these frequencies, radians per sample.
fn two_lines(frequencies: [f64; 2], noise: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    (0..60)
        .map(|n| {
            let n = f64::from(n);
            let random: f64 = StandardNormal.sample(&mut random);
            (frequencies[0] * n).sin() + 0.5 * (frequencies[1] * n + 0.3).cos() + noise * random
        })
        .collect()
}

/// Coloured noise of 10⁻⁴ on top of gravity.
fn on_gravity() -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let mut r = 0.0;
    (0..60)
        .map(|_| {
            let noise: f64 = StandardNormal.sample(&mut random);
            r = 0.8 * r + noise;
            9.81 + 1e-4 * r
        })
        .collect()
}

/// Largest error of the coefficients, relative to the largest of them; `None` if the method rejects the series.
fn error(method: Method, series: &[f64]) -> Option<f64> {
    match estimate(method, &[series], ORDER) {
        Ok(fit) => {
            let expected = exact_coefficients(method, series);
            let size = expected.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
            let off = fit.coefficients.iter().zip(&expected).map(|(a, b)| (a - b).abs());
            Some(off.fold(0.0, f64::max) / size)
        }
        Err(AutoregressionError::IllConditioned { .. }) => None,
        Err(other) => panic!("{method}: {other}"),
    }
}

#[test]
fn near_singular_records_are_solved_exactly_or_rejected() {
    for (what, series) in [
        ("plain", lines(0.1)),
        ("MSE 1e-8 of the variance", lines(1e-4)),
        ("MSE 1e-12 of the variance", lines(1e-6)),
        ("MSE 1e-20 of the variance", lines(1e-10)),
        ("no noise", lines(0.0)),
        ("slow lines, lags nearly the same", two_lines([0.02, 0.05], 1e-6)),
        ("slow lines without noise", two_lines([0.02, 0.05], 0.0)),
        ("gravity and a noise of 1e-4", on_gravity()),
    ] {
        for method in Method::ALL {
            let error = error(method, &series);
            println!("{what}, {method}: {error:?}");
            // bound that the rejections guarantee
            assert!(error.is_none_or(|error| error < TRUSTED), "{what}, {method}: {error:?}");
        }
    }
}

#[test]
fn accepts_well_conditioned_records() {
    // least squares and the lattice depend on the noise itself, 10⁻⁶ of the signal: 16 digits minus 6, and some for the
    // sums
    for method in [Method::Covariance, Method::ModifiedCovariance, Method::Burg] {
        assert!(error(method, &lines(1e-6)).is_some_and(|error| error < 1e-8), "{method}");
    }
    // the autocorrelation is a square; windowing leaves it well conditioned here
    assert!(error(Method::YuleWalker, &lines(1e-6)).is_some_and(|error| error < 1e-10));
    // centring removes gravity
    let centred: Vec<f64> = on_gravity().iter().map(|a| a - 9.81).collect();
    for method in Method::ALL {
        assert!(error(method, &centred).is_some_and(|error| error < 1e-10), "{method}");
    }
}

#[test]
fn terms_fitted_with_a_constant_are_exact_too() {
    for (series, tolerance) in [(lines(1e-6), 1e-8), (on_gravity(), 1e-9)] {
        let terms: Vec<Monomial> = (1..=ORDER as u16).map(|lag| vec![fos_core::y(lag)]).collect();
        let whole = 0..series.len();
        let rows = Rows::usable(&[&series], std::slice::from_ref(&whole), terms.iter().flatten());
        let fit = refit::refit(&[&series], &rows, &terms).unwrap();
        let rational: Vec<BigRational> = series.iter().map(|x| exact(*x)).collect();
        let expected = least_squares(&forward(&rational, true));
        let size = expected[1..].iter().fold(0.0_f64, |size, a| size.max(a.abs()));
        for (a, b) in fit.coefficients.iter().zip(&expected[1..]) {
            // condition 10⁵ to 10⁶ on 16 digits, residual small
            assert!((a - b).abs() < tolerance * size, "{a} for {b}");
        }
    }
}

#[test]
fn search_finds_terms_on_top_of_gravity() {
    let pool = Candidates::builder().output(1..=4, 1).build().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(13);
    let mut r = 0.0;
    let series: Vec<f64> = (0..5000)
        .map(|_| {
            let noise: f64 = StandardNormal.sample(&mut random);
            r = 0.8 * r + noise;
            9.81 + 1e-4 * r
        })
        .collect();
    let whole = 0..series.len();
    let fit = fit(&[&series], std::slice::from_ref(&whole), &pool, &StopRule::default(), Search::Exchange);
    let fit = fit.unwrap();
    assert_eq!(fit.terms, [vec![fos_core::y(1)]]);
    assert!((fit.refit.coefficients[0] - 0.8).abs() < 5.0 * fit.refit.coefficient_errors[0]);
}
