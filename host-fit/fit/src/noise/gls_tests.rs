//! The regression compared with the explicit formula with the dense covariance.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::blocks::Blocks;
use super::gls::{Gls, dot};
use super::model::{GaussMarkov, NoiseLevels};
use super::noise_tests::{
    LENGTH_S, UNIT_WHITE, awkward, blocks_of, cholesky, dense, in_levels, log_determinant, white_columns,
};

const SEEDS: u64 = 20;

fn levels() -> NoiseLevels {
    let process = GaussMarkov { deviation: 0.4, tau_s: 5.0 * LENGTH_S };
    NoiseLevels { flicker: 0.8, walk: 0.2, gauss_markov: Some(process), ..UNIT_WHITE }
}

/// A constant, a ramp that is nearly constant over a short log, and random columns from `seed`; and an output.
fn problem(blocks: &Blocks, seed: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut columns = vec![vec![1.0; blocks.len()]];
    columns.push((0..blocks.len()).map(|block| 300.0 + blocks.middle_s(block)).collect());
    columns.extend(white_columns(&mut ChaCha8Rng::seed_from_u64(seed), 3, blocks.len()));
    let y = columns.pop().expect("five columns");
    (columns, y)
}

fn slices(columns: &[Vec<f64>]) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}

fn chi_squared(gls: &Gls) -> f64 {
    dot(&gls.residual, &gls.residual)
}

#[test]
fn matches_the_explicit_formula() {
    for seed in 0..SEEDS {
        let blocks = if seed % 2 == 0 { awkward() } else { blocks_of(&[8; 9]) };
        let (columns, y) = problem(&blocks, seed);
        let gls = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        assert_eq!(gls.kept, [0, 1, 2, 3]);

        let noise = cholesky(dense(&levels(), &blocks));
        let vectors: Vec<DVector<f64>> = columns.iter().map(|c| DVector::from_column_slice(c)).collect();
        let (x, y) = (DMatrix::from_columns(&vectors), DVector::from_vec(y));
        let covariance = (x.transpose() * noise.solve(&x)).try_inverse().expect("regular");
        let coefficients = &covariance * (x.transpose() * noise.solve(&y));
        let left = &y - &x * &coefficients;
        let deviance = log_determinant(&noise) + left.dot(&noise.solve(&left));

        // the inverse of the normal equations squares the condition, 1e4 between constant and ramp
        for (i, (found, wanted)) in gls.coefficients().iter().zip(coefficients.iter()).enumerate() {
            let error = covariance[(i, i)].sqrt();
            assert!((found - wanted).abs() < 1e-6 * error, "seed {seed}, {i}: {found} for {wanted}");
            for j in 0..4 {
                let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                let off = (gls.covariance()[(i, j)] - covariance[(i, j)]).abs();
                assert!(off < 1e-6 * scale, "seed {seed}, {i} {j}: {off:e}");
            }
        }
        assert!((gls.deviance() - deviance).abs() < 1e-8, "seed {seed}: {} for {deviance}", gls.deviance());
    }
}

#[test]
fn the_residual_is_orthogonal_to_every_regressor() {
    let blocks = awkward();
    for seed in 0..SEEDS {
        let (mut columns, y) = problem(&blocks, seed);
        // nearly the constant: 1e-3 of it is independent, a million times the squares that count as collinear
        columns.push(columns[2].iter().map(|value| 1.0 + 1e-3 * value * value).collect());
        let gls = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        assert_eq!(gls.kept.len(), columns.len());
        let whitened = levels().whiten(&blocks, &slices(&columns));
        for column in &whitened.columns {
            let cosine = dot(column, &gls.residual) / (dot(column, column) * chi_squared(&gls)).sqrt();
            assert!(cosine.abs() < 1e-12, "seed {seed}: {cosine:e}");
        }
    }
}

#[test]
fn collinear_regressors_are_excluded() {
    let blocks = awkward();
    for seed in 0..SEEDS {
        let (mut columns, y) = problem(&blocks, seed);
        let wanted = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        let combination = (0..blocks.len()).map(|row| 2.0 - 0.5 * columns[1][row]).collect();
        columns.insert(2, combination);
        columns.insert(3, vec![0.0; blocks.len()]);
        columns.push(columns[4].iter().map(|value| -7.0 * value).collect());
        let gls = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        assert_eq!(gls.kept, [0, 1, 4, 5], "seed {seed}");
        let (found, alone) = (gls.coefficients(), wanted.coefficients());
        assert_eq!([found[2], found[3], found[6]], [0.0; 3]);
        assert_eq!([found[0], found[1], found[4], found[5]], alone[..]);
        assert_eq!(gls.covariance().nrows(), 4);
    }
}

#[test]
fn gain_equals_decrease_of_chi_squared() {
    let blocks = awkward();
    for seed in 0..SEEDS {
        let (mut columns, y) = problem(&blocks, seed);
        let narrow = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        let mut more = white_columns(&mut ChaCha8Rng::seed_from_u64(1000 + seed), 2, blocks.len());
        // one is a combination of present columns, one of added columns
        more.insert(1, columns[1].iter().map(|value| 3.0 * value - 1.0).collect());
        more.push(more[0].iter().zip(&more[2]).map(|(a, b)| a - b).collect());
        let (gain, added) = narrow.gain(&slices(&more));
        columns.extend(more);
        let wide = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        let fall = chi_squared(&narrow) - chi_squared(&wide);
        assert!((gain - fall).abs() < 1e-9 * chi_squared(&narrow), "seed {seed}: {gain} for {fall}");
        assert_eq!((added, wide.kept.len()), (2, narrow.kept.len() + 2), "seed {seed}");
        assert!(fall > 0.0);
    }
}

/// Columns that are 1 from a block on.
fn level_columns(n: usize, starts: &[usize]) -> Vec<Vec<f64>> {
    let column = |start: &usize| (0..n).map(|block| f64::from(u8::from(block >= *start))).collect();
    starts.iter().map(column).collect()
}

#[test]
fn eliminated_levels_match_one_column_per_level() {
    for seed in 0..SEEDS {
        let mut counts = vec![8; 60];
        counts[10..14].fill(0);
        counts[33] = 3;
        // two adjacent blocks with their own levels, and one after a gap
        let starts = [7, 14, 30, 31, 32, 50];
        let blocks = in_levels(&counts, &starts);
        let plain = blocks_of(&counts);
        assert_eq!((blocks.len(), blocks.restarts().len()), (plain.len(), 6));
        let (mut columns, y) = problem(&plain, seed);
        // a combination of levels
        columns
            .push(level_columns(plain.len(), blocks.restarts())[2].iter().map(|v| 3.0 * v - 1.0).collect());
        let eliminated = Gls::new(&blocks, &levels(), &y, &slices(&columns));
        assert_eq!(eliminated.kept, [0, 1, 2, 3]);
        columns.truncate(4);
        columns.extend(level_columns(plain.len(), blocks.restarts()));
        let dense = Gls::new(&plain, &levels(), &y, &slices(&columns));
        assert_eq!(dense.kept.len(), 10);

        let chi = (chi_squared(&eliminated) - chi_squared(&dense)).abs();
        assert!(chi < 1e-8 * chi_squared(&dense), "seed {seed}: {chi:e}");
        // restricted likelihood
        let restricted = |gls: &Gls| gls.deviance() + gls.log_determinant_of_information();
        let off = restricted(&eliminated) - restricted(&dense);
        assert!(off.abs() < 1e-7, "seed {seed}: {off:e}");
        let (covariance, wanted) = (eliminated.covariance(), dense.covariance());
        for i in 0..4 {
            let error = wanted[(i, i)].sqrt();
            let off = (eliminated.coefficients()[i] - dense.coefficients()[i]).abs();
            assert!(off < 1e-6 * error, "seed {seed}, {i}: {off:e} of {error:e}");
            for j in 0..4 {
                let scale = error * wanted[(j, j)].sqrt();
                assert!((covariance[(i, j)] - wanted[(i, j)]).abs() < 1e-6 * scale, "seed {seed}, {i} {j}");
            }
        }
        let more = white_columns(&mut ChaCha8Rng::seed_from_u64(2000 + seed), 2, blocks.len());
        let (gain, wanted) = (eliminated.gain(&slices(&more)).0, dense.gain(&slices(&more)).0);
        assert!((gain - wanted).abs() < 1e-8 * chi_squared(&dense), "seed {seed}: {gain} for {wanted}");
    }
}

/// Number of products in a regression: each column is projected twice on all before it, block by block.
fn products(gls: &Gls) -> usize {
    let k = gls.kept.len();
    gls.residual.len() * (1 + k + 2 * k * k)
}

#[test]
fn regression_cost_is_linear_in_rests() {
    // four blocks per rest
    let rests = |count: usize| -> Vec<usize> { (1..count).map(|rest| 4 * rest).collect() };
    let work = |count: usize, as_columns: bool| {
        let counts = vec![8; 4 * count];
        let (starts, plain) = (rests(count), blocks_of(&counts));
        let (mut columns, y) = problem(&plain, 1);
        if as_columns {
            columns.extend(level_columns(plain.len(), &starts));
            return products(&Gls::new(&plain, &levels(), &y, &slices(&columns)));
        }
        products(&Gls::new(&in_levels(&counts, &starts), &levels(), &y, &slices(&columns)))
    };
    let ratio = |as_columns: bool| work(100, as_columns) as f64 / work(50, as_columns) as f64;
    assert_eq!(ratio(false), 2.0);
    // negative control: one column per rest
    assert!(ratio(true) > 6.0);
    println!(
        "attack: rests | a regression over 100 rests with a level each takes {:.1} times the multiplications of one over 50 rests, and gives the same result as a column per rest | negative control: with a column per rest it takes {:.1} times as many",
        ratio(false),
        ratio(true),
    );
}
