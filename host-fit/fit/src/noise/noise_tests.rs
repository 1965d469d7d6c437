//! Whitening and simulated noise compared with the dense covariance of block means in closed form.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::blocks::{Blocks, length_for};
use super::gls::dot;
use super::levels::LevelPrior;
use super::model::{GaussMarkov, NoiseLevels};
use fos_data::recording::{LoadOptions, Recording, Source};

/// Rows per block, at 10 Hz.
const PER_BLOCK: usize = 8;

/// Length of a full block, s.
pub(super) const LENGTH_S: f64 = 0.8;

/// White noise of unit variance in a full block.
pub(super) const UNIT_WHITE: NoiseLevels =
    NoiseLevels { white: 0.894_427_190_999_915_9, flicker: 0.0, walk: 0.0, gauss_markov: None };

/// Rows at 10 Hz, and the flags of the used ones: the given number of each block.
fn recording_of(counts: &[usize]) -> (Recording, Vec<bool>) {
    let columns = vec![("gx_rads".to_owned(), vec![0.0; counts.len() * PER_BLOCK])];
    let options = LoadOptions { rate_hz: Some(10.0), ..LoadOptions::default() };
    let recording = Recording::from_columns(Source::made_by("test"), columns, &options).expect("a recording");
    let known = counts.iter().flat_map(|count| (0..PER_BLOCK).map(move |row| row < *count)).collect();
    (recording, known)
}

/// Blocks of [`LENGTH_S`] with these numbers of used rows and new levels at `starts`.
pub(super) fn in_levels(counts: &[usize], starts: &[usize]) -> Blocks {
    let (recording, known) = recording_of(counts);
    let turns: Vec<usize> = starts.iter().map(|block| block * PER_BLOCK).collect();
    Blocks::with_levels(&recording, LENGTH_S, known, &turns)
}

/// Blocks of [`LENGTH_S`] with these numbers of used rows; a block without any is a gap.
pub(super) fn blocks_of(counts: &[usize]) -> Blocks {
    let (recording, known) = recording_of(counts);
    Blocks::new(&recording, LENGTH_S, known)
}

/// Unequal counts, single gaps and a long one.
pub(super) fn awkward() -> Blocks {
    let mut counts: Vec<usize> =
        (0..70).map(|block| [8, 8, 5, 2, 0, 7, 8, 3][(3 * block + block / 8) % 8]).collect();
    counts[20..50].fill(0);
    counts.extend([8, 4].repeat(10));
    let blocks = blocks_of(&counts);
    assert!(blocks.len() > 40 && blocks.blocks.iter().any(|block| block.count == 2));
    blocks
}

/// Covariance of two means, `lag` blocks apart, of a Gauss-Markov process of unit variance: the double integral of
/// e^(−|t−s|/τ) over both blocks. `x` is block length over correlation time.
fn covariance_of_means(x: f64, lag: u64) -> f64 {
    match lag {
        // series where the difference would cancel
        0 if x < 0.01 => 1.0 - x / 3.0 + x.powi(2) / 12.0 - x.powi(3) / 60.0 + x.powi(4) / 360.0,
        0 => 2.0 * (x - 1.0 + (-x).exp()) / (x * x),
        apart => (-(-x).exp_m1() / x).powi(2) * (-x * (apart - 1) as f64).exp(),
    }
}

/// The ladder of flicker noise as documented: variance B²·ln 3/π, time constants triple from the shortest on.
fn ladder(flicker: f64, from_s: f64) -> impl Iterator<Item = GaussMarkov> {
    let deviation = flicker * (3.0_f64.ln() / std::f64::consts::PI).sqrt();
    (0..8).map(move |rung| GaussMarkov { deviation, tau_s: from_s * 3.0_f64.powi(rung) })
}

/// Covariance of block means.
pub(super) fn dense(levels: &NoiseLevels, blocks: &Blocks) -> DMatrix<f64> {
    let first = blocks.blocks[0].index;
    DMatrix::from_fn(blocks.len(), blocks.len(), |i, j| {
        let (a, b) = (&blocks.blocks[i], &blocks.blocks[j]);
        let processes = ladder(levels.flicker, blocks.flicker_from_s).chain(levels.gauss_markov);
        let coloured: f64 = processes
            .map(|p| {
                p.deviation.powi(2)
                    * covariance_of_means(blocks.length_s / p.tau_s, a.index.abs_diff(b.index))
            })
            .sum();
        // double integral of min(t, s) over both blocks, from the start of the first one
        let inside = if i == j { 1.0 / 3.0 } else { 0.5 };
        let walked_s = ((a.index.min(b.index) - first) as f64 + inside) * blocks.length_s;
        let white = if i == j { levels.white.powi(2) / (a.count as f64 * blocks.period_s) } else { 0.0 };
        white + coloured + levels.walk.powi(2) * walked_s
    })
}

pub(super) fn cholesky(matrix: DMatrix<f64>) -> Cholesky<f64, Dyn> {
    matrix.cholesky().expect("a covariance")
}

pub(super) fn log_determinant(cholesky: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * cholesky.l_dirty().diagonal().map(f64::ln).sum()
}

pub(super) fn white_columns(random: &mut ChaCha8Rng, columns: usize, rows: usize) -> Vec<Vec<f64>> {
    (0..columns).map(|_| (0..rows).map(|_| StandardNormal.sample(random)).collect()).collect()
}

/// Largest difference from the dense computation: of ln det, and of quadratic forms over the root of their squares.
fn difference(levels: &NoiseLevels, blocks: &Blocks, seed: u64) -> f64 {
    let columns = white_columns(&mut ChaCha8Rng::seed_from_u64(seed), 3, blocks.len());
    let whitened = levels.whiten(blocks, &columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let cholesky = cholesky(dense(levels, blocks));
    let vectors: Vec<DVector<f64>> = columns.iter().map(|c| DVector::from_column_slice(c)).collect();
    let form = |i: usize, j: usize| vectors[i].dot(&cholesky.solve(&vectors[j]));
    let mut most = (whitened.log_determinant - log_determinant(&cholesky)).abs();
    for i in 0..3 {
        for j in 0..3 {
            let off = dot(&whitened.columns[i], &whitened.columns[j]) - form(i, j);
            most = most.max(off.abs() / (form(i, i) * form(j, j)).sqrt());
        }
    }
    if most.is_nan() { f64::INFINITY } else { most }
}

/// Tolerance: rounding of some hundred operations on covariances with a condition below 1e5.
const EXACT: f64 = 1e-9;

/// A log of bursts of `rows` rows at 10 Hz, one every 100 s.
fn bursts(count: usize, rows: usize) -> Recording {
    let time: Vec<f64> =
        (0..count * rows).map(|row| (row / rows) as f64 * 100.0 + (row % rows) as f64 * 0.1).collect();
    let columns = vec![("gx_rads".to_owned(), vec![0.0; time.len()]), ("t_s".to_owned(), time)];
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a recording")
}

/// Such bursts filled a twentieth of a block of the whole time, and were excluded as hardly known.
#[test]
fn burst_blocks_are_equal_parts_at_true_distances() {
    // bursts, blocks of each, fewest rows of a block
    for (count, parts, rows) in [(150, 4, 11), (300, 2, 25), (600, 1, 50), (1100, 1, 50)] {
        let log = bursts(count, 50);
        let length_s = length_for(&log);
        assert!((length_s * 10.0 - 50.0 / parts as f64).abs() < 1e-9, "{length_s}");
        let blocks = Blocks::new(&log, length_s, vec![true; log.n_rows()]);
        let whole = blocks.blocks.iter().filter(|block| block.count >= rows).count();
        assert!(whole == count * parts && blocks.len() == whole, "{whole} of {}", blocks.len());
        for (at, block) in blocks.blocks.iter().enumerate() {
            let begins_s = (at / parts) as f64 * 100.0 + (at % parts) as f64 * blocks.length_s;
            let apart = (block.index - blocks.blocks[0].index) as f64 * blocks.length_s;
            assert!((apart - begins_s).abs() < 1.1 * blocks.length_s, "{at}: {apart} for {begins_s}");
        }
    }
    // with too many bursts several form one block
    let many = bursts(6000, 50);
    let blocks = Blocks::new(&many, length_for(&many), vec![true; many.n_rows()]);
    assert!((590..=601).contains(&blocks.len()), "{}", blocks.len());
    // the last block may hold too few
    assert!(blocks.samples() + 150 > many.n_rows(), "{}", blocks.samples());
}

/// The bursts of a noisy log are further apart than its blocks: slow changes between them are not white noise.
#[test]
fn estimates_white_noise_from_single_block_bursts() {
    let log = bursts(600, 50);
    let blocks = Blocks::new(&log, length_for(&log), vec![true; log.n_rows()]);
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let levels = NoiseLevels { white: 2.0, flicker: 0.0, walk: 0.0, gauss_markov: None };
    let slow = |at: usize| 5.0 * (0.02 * at as f64).sin();
    let noise = levels.simulate(&blocks, &mut random);
    let means: Vec<f64> = noise.iter().enumerate().map(|(at, value)| value + slow(at)).collect();
    let white = NoiseLevels::from_logs(&LevelPrior::of_log(&blocks, &means).mean).white;
    assert!((white / 2.0 - 1.0).abs() < 0.15, "{white}");
}

#[test]
fn whitening_matches_dense_covariance() {
    let blocks = awkward();
    let with = |flicker, walk, gauss_markov| NoiseLevels { flicker, walk, gauss_markov, ..UNIT_WHITE };
    let mut cases =
        vec![with(0.0, 0.0, None), with(1.0, 0.0, None), with(0.0, 0.3, None), with(1.0, 0.3, None)];
    for blocks_long in [0.3, 1.0, 2.7, 30.0, 3000.0] {
        let process = GaussMarkov { deviation: 0.5, tau_s: blocks_long * LENGTH_S };
        cases.push(with(0.0, 0.0, Some(process)));
        cases.push(with(0.8, 0.1, Some(process)));
    }
    for (seed, levels) in cases.iter().enumerate() {
        let off = difference(levels, &blocks, seed as u64);
        assert!(off < EXACT, "{levels:?}: {off:e}");
    }
}

#[test]
fn whitening_matches_dense_covariance_for_any_levels_and_gaps() {
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let counts: Vec<usize> =
            (0..random.random_range(1..90)).map(|_| [0, 2, 3, 8, 8, 8][random.random_range(0..6)]).collect();
        let mut blocks = blocks_of(&counts);
        blocks.flicker_from_s = [1.0, 3.0, 0.8][seed as usize % 3];
        if blocks.is_empty() {
            continue;
        }
        let process = GaussMarkov {
            deviation: random.random_range(0.01..0.5),
            tau_s: LENGTH_S * random.random_range(0.3_f64.ln()..3000.0_f64.ln()).exp(),
        };
        let levels = NoiseLevels {
            white: UNIT_WHITE.white,
            flicker: random.random_range(0.0..1.0),
            walk: random.random_range(0.0..0.5),
            gauss_markov: random.random_bool(0.7).then_some(process),
        };
        let off = difference(&levels, &blocks, seed);
        assert!(off < EXACT, "{levels:?} {counts:?}: {off:e}");
    }
}

#[test]
fn whitens_noise_of_any_strength() {
    let blocks = blocks_of(&[8; 40]);
    let short = GaussMarkov { deviation: 1.0, tau_s: 0.3 * LENGTH_S };
    let cases = [
        // a block of 36 s of a part whose flicker equals its white noise after 4 s
        NoiseLevels { flicker: 3.0, ..UNIT_WHITE },
        NoiseLevels { gauss_markov: Some(short), ..UNIT_WHITE },
        NoiseLevels { gauss_markov: Some(GaussMarkov { tau_s: 0.02 * LENGTH_S, ..short }), ..UNIT_WHITE },
    ];
    let off: Vec<f64> = cases.iter().map(|levels| difference(levels, &blocks, 1)).collect();
    // short processes are a small difference of two large numbers
    assert!(off.iter().all(|off| *off < 1e-6), "{off:?}");
}

#[test]
fn closed_form_matches_sampled_process() {
    const SAMPLES: usize = 600;
    for x in [1.0 / 3000.0, 0.009, 0.011, 0.3, 1.0, 1.0 / 0.3] {
        for lag in 0..4 {
            let step = x / SAMPLES as f64;
            let mut sum = 0.0;
            // pairs of samples by their distance, i − j + lag·SAMPLES
            for apart in -(SAMPLES as i64 - 1)..SAMPLES as i64 {
                let pairs = SAMPLES as i64 - apart.abs();
                let distance = (apart + (lag as usize * SAMPLES) as i64).abs();
                sum += pairs as f64 * (-step * distance as f64).exp();
            }
            let sampled = sum / (SAMPLES * SAMPLES) as f64;
            // the midpoint rule has an error of x²/24·n² per block, and of x/6n² at the kink
            let off = (covariance_of_means(x, lag) - sampled).abs();
            assert!(off < x / (SAMPLES * SAMPLES) as f64 + 1e-12, "x {x}, lag {lag}: {off:e}");
        }
    }
}

#[test]
fn simulated_noise_has_the_dense_covariance() {
    const DRAWS: usize = 4000;
    let blocks = blocks_of(&[8, 4, 8, 0, 2, 8, 0, 0, 0, 8, 8, 3, 8]);
    let process = GaussMarkov { deviation: 0.5, tau_s: 4.0 * LENGTH_S };
    let levels = NoiseLevels { flicker: 1.0, walk: 0.4, gauss_markov: Some(process), ..UNIT_WHITE };
    let covariance = dense(&levels, &blocks);
    let n = blocks.len();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let draws: Vec<DVector<f64>> =
        (0..DRAWS).map(|_| DVector::from_vec(levels.simulate(&blocks, &mut random))).collect();
    for i in 0..n {
        for j in 0..=i {
            let sampled = draws.iter().map(|draw| draw[i] * draw[j]).sum::<f64>() / DRAWS as f64;
            let variance = covariance[(i, i)] * covariance[(j, j)] + covariance[(i, j)].powi(2);
            // 4 standard errors: one of 55 entries exceeds them in one of 300 seeds
            let off = (sampled - covariance[(i, j)]).abs() / (variance / DRAWS as f64).sqrt();
            assert!(off < 4.0, "{i} {j}: {sampled} for {}, {off} standard errors", covariance[(i, j)]);
        }
    }
    let cholesky = cholesky(covariance);
    let squares: f64 = draws.iter().map(|draw| draw.dot(&cholesky.solve(draw))).sum();
    let freedom = (DRAWS * n) as f64;
    assert!((squares - freedom).abs() < 3.0 * (2.0 * freedom).sqrt(), "{squares} for {freedom}");
}

/// Allan variance of means over `m` blocks of the ladder of unit flicker.
fn allan_variance_of_ladder(m: usize) -> f64 {
    ladder(1.0, 1.0)
        .map(|p| {
            p.deviation.powi(2)
                * (covariance_of_means(m as f64 / p.tau_s, 0) - covariance_of_means(m as f64 / p.tau_s, 1))
        })
        .sum()
}

#[test]
fn the_ladder_is_flat_at_0_664_times_the_bias_instability_over_two_decades() {
    let flat = (2.0 * 2.0_f64.ln() / std::f64::consts::PI).sqrt();
    for m in [10, 14, 20, 50, 100, 200, 500, 1000] {
        let off = allan_variance_of_ladder(m).sqrt() / flat - 1.0;
        // the ladder is finite: it lacks rungs below 1 s and above 2187 s
        assert!(off.abs() < 0.06, "{m} blocks: {off}");
    }
}
