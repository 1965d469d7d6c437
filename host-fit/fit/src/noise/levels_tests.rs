//! Fitted noise levels: the optimum is a minimum, its width is right, and the intervals cover the true levels.

use nalgebra::Matrix3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::levels::{LevelPrior, LogLevels, Regression, UnknownLevels};
use super::model::NoiseLevels;
use super::noise_tests::{awkward, blocks_of};

/// Tolerance of the deviance at an optimum: the search ends when a Newton step promises less than 0.005, and a
/// likelihood ratio of 2·ln below 0.05 is not significant.
const NEAR: f64 = 0.05;

/// Scatter of a device about its data sheet.
const DEVIATIONS: [f64; 3] = [0.3, 0.45, 0.8];

/// A phone-class part, in blocks of 0.8 s.
fn part() -> LogLevels {
    [1.0_f64.ln(), 0.4_f64.ln(), 0.02_f64.ln()]
}

fn prior() -> LevelPrior {
    LevelPrior::independent(part(), DEVIATIONS)
}

fn draw(prior: &LogLevels, random: &mut ChaCha8Rng) -> LogLevels {
    std::array::from_fn(|i| {
        let unit: f64 = StandardNormal.sample(random);
        prior[i] + DEVIATIONS[i] * unit
    })
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

#[test]
fn the_deviance_of_a_prior_is_its_quadratic_form() {
    let prior = LevelPrior {
        mean: [0.0, 1.0, 2.0],
        precision: [[2.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.0, -1.0, 1.0]],
        random_walk_likelihood: None,
    };
    // off (1, 2, −1): 2·1 + 3·4 + 1·1 + 2·(1·1·2) + 2·(−1·2·−1)
    assert!((prior.deviance(&[1.0, 3.0, 1.0]) - 23.0).abs() < 1e-12);
    let independent = LevelPrior::independent([0.0; 3], [0.5, 1.0, 2.0]);
    // (1/0.5)² + (2/1)² + (−4/2)²
    assert!((independent.deviance(&[1.0, 2.0, -4.0]) - 12.0).abs() < 1e-12);
}

#[test]
fn without_data_the_optimum_is_the_prior() {
    let blocks = blocks_of(&[0; 4]);
    assert!(blocks.is_empty());
    // correlation 0.9 of the first two: a narrow valley across the axes
    let covariance = Matrix3::new(0.09, 0.1215, 0.0, 0.1215, 0.2025, 0.1, 0.0, 0.1, 0.64);
    let inverse = covariance.try_inverse().expect("regular");
    let precision = std::array::from_fn(|i| std::array::from_fn(|j| inverse[(i, j)]));
    let prior = LevelPrior { mean: [0.3, -1.0, -4.0], precision, random_walk_likelihood: None };
    let regression = Regression { blocks: &blocks, y: &[], regressors: &[], prior: &prior };
    for start in [[0.3, -1.0, -4.0], [0.0, -1.3, -4.5], [0.8, -0.7, -3.3], [-1.5, 0.0, -6.0]] {
        let fitted = regression.fit(NoiseLevels::from_logs(&start));
        assert!(fitted.deviance < NEAR, "from {start:?}: {:?} {}", fitted.levels.logs(), fitted.deviance);
        let posterior = regression.posterior(&fitted);
        // second differences of a quadratic are exact
        let off = (matrix(&posterior.precision) - inverse).amax();
        assert!(off < 1e-9 * inverse.amax(), "{off:e}");
    }
}

/// Largest amount by which the deviance on a grid around the optimum is below that of the optimum, over some seeds; the
/// search starts `off` from the prior's mean in every level.
fn missed(off: f64) -> f64 {
    const GRID: [f64; 11] = [-0.8, -0.4, -0.2, -0.1, -0.05, 0.0, 0.05, 0.1, 0.2, 0.4, 0.8];
    let blocks = awkward();
    let ones = vec![1.0; blocks.len()];
    let prior = prior();
    let mut most = 0.0_f64;
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let truth = draw(&part(), &mut random);
        let y = NoiseLevels::from_logs(&truth).simulate(&blocks, &mut random);
        let regression = Regression { blocks: &blocks, y: &y, regressors: &[&ones], prior: &prior };
        let fitted = regression.fit(NoiseLevels::from_logs(&part().map(|level| level + off)));
        let centre = fitted.levels.logs();
        for place in 0..GRID.len().pow(3) {
            let moves = [GRID[place % 11], GRID[place / 11 % 11], GRID[place / 121]];
            let logs = std::array::from_fn(|i| centre[i] + moves[i]);
            most = most.max(fitted.deviance - regression.at(NoiseLevels::from_logs(&logs)).deviance);
        }
    }
    most
}

#[test]
fn optimum_is_the_most_probable_on_a_grid() {
    let missed = missed(0.0);
    assert!(missed < NEAR, "{missed}");
}

#[test]
fn finds_the_optimum_from_afar() {
    // a factor of 5: without a data sheet or a reference log the start is a guess
    let missed = [missed(-1.6), missed(1.6)];
    assert!(missed.iter().all(|missed| *missed < NEAR), "{missed:?}");
}

/// Half of the second derivatives of the deviance, by differences of fourth order.
fn curvature(regression: &Regression<'_>, centre: LogLevels) -> Matrix3<f64> {
    const STEP: f64 = 0.05;
    const WEIGHTS: [(f64, f64); 4] = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
    let at = |moves: [f64; 3]| {
        let logs = std::array::from_fn(|i| centre[i] + STEP * moves[i]);
        regression.at(NoiseLevels::from_logs(&logs)).deviance
    };
    let along = |i: usize, by: f64, j: usize, other: f64| {
        let mut moves = [0.0; 3];
        moves[i] += by;
        moves[j] += other;
        at(moves)
    };
    // the first difference of first differences; for i = j too
    Matrix3::from_fn(|i, j| {
        let pairs = WEIGHTS.iter().flat_map(|a| WEIGHTS.iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| a.1 * b.1 * along(i, a.0, j, b.0)).sum::<f64>() / (2.0 * (12.0 * STEP).powi(2))
    })
}

#[test]
fn the_posterior_has_the_curvature_of_the_deviance() {
    let blocks = awkward();
    let ones = vec![1.0; blocks.len()];
    let prior = prior();
    for seed in 0..5 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let y = NoiseLevels::from_logs(&draw(&part(), &mut random)).simulate(&blocks, &mut random);
        let regression = Regression { blocks: &blocks, y: &y, regressors: &[&ones], prior: &prior };
        let fitted = regression.fit(NoiseLevels::from_logs(&part()));
        let posterior = regression.posterior(&fitted);
        let wanted = curvature(&regression, fitted.levels.logs());
        assert_eq!(posterior.mean, fitted.levels.logs());
        for i in 0..3 {
            for j in 0..3 {
                // second differences at ±0.1: x⁴ terms leave 0.1²/12 of a fourth derivative some times the second
                let scale = (wanted[(i, i)] * wanted[(j, j)]).sqrt();
                let off = (posterior.precision[i][j] - wanted[(i, j)]).abs() / scale;
                assert!(off < 0.02, "seed {seed}, {i} {j}: {off}");
            }
        }
    }
}

#[test]
fn posterior_intervals_have_their_stated_coverage() {
    let blocks = blocks_of(&[8; 200]);
    let ones = vec![1.0; blocks.len()];
    let prior = prior();
    let mut inside = [0; 3];
    for seed in 0..100 {
        let mut random = ChaCha8Rng::seed_from_u64(100 + seed);
        let truth = draw(&part(), &mut random);
        let y = NoiseLevels::from_logs(&truth).simulate(&blocks, &mut random);
        let regression = Regression { blocks: &blocks, y: &y, regressors: &[&ones], prior: &prior };
        let fitted = regression.fit(NoiseLevels::from_logs(&prior.mean));
        let posterior = regression.posterior(&fitted);
        let covariance = matrix(&posterior.precision).try_inverse().expect("positive");
        for level in 0..3 {
            // 90 % of a normal distribution
            let reach = 1.645 * covariance[(level, level)].sqrt();
            inside[level] += usize::from((truth[level] - posterior.mean[level]).abs() < reach);
        }
    }
    // 90 ± 3 by the binomial distribution; the posterior is normal only near its optimum
    assert!(inside.iter().all(|count| (80..=98).contains(count)), "{inside:?} of 100");
}

#[test]
fn singular_precision_is_an_error() {
    let known = prior();
    let widened = known.widened([0.01, 0.02, 0.06]).unwrap();
    let covariance = matrix(&widened.precision).try_inverse().unwrap();
    let expected = [0.3 * 0.3 + 0.01, 0.45 * 0.45 + 0.02, 0.8 * 0.8 + 0.06];
    for (i, expected) in expected.into_iter().enumerate() {
        assert!((covariance[(i, i)] - expected).abs() < 1e-12, "{i}: {covariance}");
    }
    let indefinite = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for precision in [indefinite, [[f64::NAN; 3]; 3]] {
        let unknown = LevelPrior { precision, ..known };
        assert_eq!(unknown.widened([0.01; 3]), Err(UnknownLevels));
        assert_eq!(unknown.with_free_walk(3.0), Err(UnknownLevels));
    }
}
