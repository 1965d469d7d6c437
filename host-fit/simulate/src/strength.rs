//! Size of an effect relative to the true noise, and its remaining part after fitting the other effects.
//!
//! **Slow effects.** The usable stretches of the log are cut into about 400 blocks; s are the block means of the planted
//! error, C the exact covariance of the block means of the noise. A matched filter detects s at d standard errors, d² =
//! sᵀ C⁻¹ s, after the constant is projected out of s in the whitened space (the offset of a log is unknown). The
//! generalised least squares estimate of the effect's coefficient has the relative standard error 1/d.
//!
//! **Lines.** The noise is flat about f, so C⁻¹ is 1/S there, S the two-sided spectral density per sample: d² = Σ s²/S =
//! A² n / (2 S) for amplitude A over n samples. (|DFT|² of the line over that of the noise is half as much, A² n / (4
//! S).)
//!
//! **Noise.** For C₁ = C + a² G, the expected 2 log likelihood ratio of the true against the reference log's noise:
//! d² = tr(C⁻¹C₁) − N − ln det(C⁻¹C₁), with a flat prior on the constant in both. For white noise of rising level and
//! for a coarser step, the same sample by sample with r = added variance over the white variance: d² = Σ (r − ln(1 +
//! r)).
//!
//! **Two levels.** Only a matched filter knows the moments of the transitions of telegraph noise; a Gauss-Markov
//! process of the same spectrum explains much of it. d² is the expected 2 log likelihood ratio of the course against
//! that process, C₁ = C + a² G, less −2 ln P of the transitions, block by block: a² sᵀ C₁⁻¹ s + tr(C₁⁻¹ C) − N + ln
//! det(C₁ C⁻¹) + 2 ln P.
//!
//! **Lost and clipped samples.** d² is their number.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::coloured::AxisNoise;

/// Number of blocks of a log.
const BLOCKS: f64 = 400.0;

/// Contiguous blocks, of equal length within a stretch.
#[derive(Debug, Clone)]
pub(super) struct Blocks(pub(super) Vec<Range<usize>>);

impl Blocks {
    /// Blocks of stretches of samples, with ends at multiples of `cell`.
    pub(super) fn of(stretches: &[Range<usize>], cell: usize) -> Self {
        let cells: Vec<Range<usize>> = stretches
            .iter()
            .map(|rows| rows.start.div_ceil(cell)..rows.end / cell)
            .filter(|cells| !cells.is_empty())
            .collect();
        let length = (cells.iter().map(Range::len).sum::<usize>() as f64 / BLOCKS).max(1.0);
        let mut blocks = Vec::new();
        for cells in cells {
            let count = ((cells.len() as f64 / length).round() as usize).max(1);
            let edge = |i: usize| (cells.start + i * cells.len() / count) * cell;
            blocks.extend((0..count).map(|i| edge(i)..edge(i + 1)));
        }
        Self(blocks)
    }

    /// The same blocks of a series decimated by `by`.
    pub(super) fn decimated(&self, by: usize) -> Self {
        Self(self.0.iter().map(|rows| rows.start / by..rows.end / by).collect())
    }

    pub(super) fn means(&self, series: &[f64]) -> Vec<f64> {
        let mean = |rows: &Range<usize>| series[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        self.0.iter().map(mean).collect()
    }

    /// Start and duration of each block, s.
    fn times(&self, period_s: f64) -> Vec<[f64; 2]> {
        self.0.iter().map(|rows| [rows.start as f64 * period_s, rows.len() as f64 * period_s]).collect()
    }

    /// Covariance of the block means of a Gauss-Markov process of variance one, in closed form:
    ///
    /// var = 2 (τ/D) (1 − (τ/D)(1 − e^(−D/τ))), cov = (τ/D₁)(τ/D₂)(1 − e^(−D₁/τ))(1 − e^(−D₂/τ)) e^(−gap/τ)
    pub(super) fn add_gauss_markov(&self, c: &mut DMatrix<f64>, variance: f64, tau_s: f64, period_s: f64) {
        let times = self.times(period_s);
        let faded: Vec<f64> = times.iter().map(|[_, d]| (tau_s / d) * (1.0 - (-d / tau_s).exp())).collect();
        for i in 0..times.len() {
            let [start, d] = times[i];
            c[(i, i)] += variance * 2.0 * (tau_s / d) * (1.0 - faded[i]);
            for j in i + 1..times.len() {
                let gap = times[j][0] - start - d;
                if gap > 30.0 * tau_s {
                    break;
                }
                let value = variance * faded[i] * faded[j] * (-gap / tau_s).exp();
                c[(i, j)] += value;
                c[(j, i)] += value;
            }
        }
    }

    /// The same of a random walk from zero at power-on: var = K² (start + D/3), cov = K² (start + D/2) of the earlier.
    pub(super) fn add_random_walk(&self, c: &mut DMatrix<f64>, per_root_s: f64, period_s: f64) {
        let times = self.times(period_s);
        let square = per_root_s * per_root_s;
        for i in 0..times.len() {
            let [start, d] = times[i];
            c[(i, i)] += square * (start + d / 3.0);
            for j in i + 1..times.len() {
                let value = square * (start + d / 2.0);
                c[(i, j)] += value;
                c[(j, i)] += value;
            }
        }
    }

    /// Covariance of the block means of the noise of an axis that is rounded to `lsb`.
    pub(super) fn covariance(&self, noise: &AxisNoise, lsb: f64) -> DMatrix<f64> {
        let mut c = DMatrix::zeros(self.0.len(), self.0.len());
        for (i, rows) in self.0.iter().enumerate() {
            c[(i, i)] = noise.fast_density(0.0, lsb) / rows.len() as f64;
        }
        for process in &noise.flicker {
            let variance = process.sigma * process.sigma;
            self.add_gauss_markov(&mut c, variance, process.tau_s, noise.period_s);
        }
        self.add_random_walk(&mut c, noise.random_walk, noise.period_s);
        c
    }
}

/// Whitening of block means.
pub(super) struct Whitener {
    factor: Cholesky<f64, Dyn>,
    constant: DVector<f64>,
}

impl Whitener {
    pub(super) fn new(covariance: DMatrix<f64>) -> Option<Self> {
        let n = covariance.nrows();
        let factor = Cholesky::new(covariance)?;
        let mut constant = DVector::from_element(n, 1.0);
        factor.l_dirty().solve_lower_triangular_mut(&mut constant);
        constant.normalize_mut();
        Some(Self { factor, constant })
    }

    /// Whitened block means, with the constant projected out.
    pub(super) fn whiten(&self, means: &[f64]) -> DVector<f64> {
        let mut white = DVector::from_column_slice(means);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut white);
        white.axpy(-white.dot(&self.constant), &self.constant, 1.0);
        white
    }

    /// Norm of a whitened series after others are projected out.
    pub(super) fn left(series: &DVector<f64>, others: &[DVector<f64>]) -> f64 {
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for other in others {
            let mut direction = other.clone();
            // twice, since rounding leaves a remainder of nearly equal columns
            for _ in 0..2 {
                for known in &basis {
                    direction.axpy(-direction.dot(known), known, 1.0);
                }
            }
            if direction.norm() > 1e-7 * other.norm() && other.norm() > 0.0 {
                basis.push(direction.normalize());
            }
        }
        let mut left = series.clone();
        for known in &basis {
            left.axpy(-left.dot(known), known, 1.0);
        }
        left.norm()
    }
}

/// Amplitude of added noise of size `wanted`, given its covariance `g` at amplitude one; see the module.
pub(super) fn noise_amplitude(c: &DMatrix<f64>, g: &DMatrix<f64>, wanted: f64) -> Option<f64> {
    let n = c.nrows();
    let flat = 1e4 * c.trace() / n as f64;
    let c = c.add_scalar(flat);
    let factor = Cholesky::new(c.clone())?;
    let log_det = |f: &Cholesky<f64, Dyn>| 2.0 * f.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let base = log_det(&factor);
    let trace = factor.solve(g).trace();
    let size = |log_a: f64| -> Option<f64> {
        let square = (2.0 * log_a).exp();
        let changed = Cholesky::new(&c + g * square)?;
        Some((square * trace - log_det(&changed) + base).max(0.0).sqrt())
    };
    // d grows as a² while small and as a when large: a secant in the logarithms
    let mut a = 0.5 * (wanted * n as f64 / trace / 20.0).ln();
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..25 {
        let found = size(a)?.max(1e-9).ln() - wanted.ln();
        if found.abs() < 1e-4 {
            break;
        }
        let slope = match last {
            Some((x, y)) if (a - x).abs() > 1e-9 => ((found - y) / (a - x)).clamp(0.5, 3.0),
            _ => 1.5,
        };
        last = Some((a, found));
        a -= (found / slope).clamp(-3.0, 3.0);
    }
    Some(a.exp())
}

/// Amplitude of a course of two levels of size `wanted`, `s` at amplitude one: `g` is the covariance of a process with
/// its spectrum, `code` the description length of its transitions; see the module.
pub(super) fn telegraph_amplitude(
    c: &DMatrix<f64>,
    g: &DMatrix<f64>,
    (s, code): (&DVector<f64>, f64),
    wanted: f64,
) -> Option<f64> {
    let n = c.nrows() as f64;
    let about = (c.trace() / n).sqrt();
    let c = c.add_scalar(1e4 * about * about);
    let log_det = |f: &Cholesky<f64, Dyn>| 2.0 * f.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let base = log_det(&Cholesky::new(c.clone())?);
    let square = |a: f64| -> Option<f64> {
        let process = Cholesky::new(&c + g * (a * a))?;
        let fit = a * a * s.dot(&process.solve(s)) + process.solve(&c).trace() - n;
        Some(fit + log_det(&process) - base - code)
    };
    let (mut low, mut high) = (0.01 * about, 100.0 * about);
    // terminates: it halves, of 16
    for _ in 0..16 {
        let middle = (low * high).sqrt();
        if square(middle)? < wanted * wanted { low = middle } else { high = middle }
    }
    Some(high)
}

/// Size of a change of the noise level: square root of Σ (r − ln(1 + r)) over samples whose variance is raised by r.
pub(super) fn level_size(ratios: impl Iterator<Item = f64>) -> f64 {
    ratios.map(|r| r - r.ln_1p()).sum::<f64>().sqrt()
}

/// Positive x at which an increasing function is `wanted`, by bisection of its logarithm within e^±20 of `about`.
pub(super) fn solve(about: f64, wanted: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (about.ln() - 20.0, about.ln() + 20.0);
    // terminates: it halves, of 40, and logarithms of numbers are apart by far less than 1e-5
    while high - low > 1e-5 {
        let middle = 0.5 * (low + high);
        if f(middle.exp()) < wanted { low = middle } else { high = middle }
    }
    (0.5 * (low + high)).exp()
}
