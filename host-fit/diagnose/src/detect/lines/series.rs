//! Error without its slow part on the grid of ticks, and its Fourier transform at a single frequency.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use fos_data::recording::Recording;
use fos_fit::noise::Blocks;

/// Length of the means that define the slow part, in s and in sample periods. The search for lines begins at TURNS
/// cycles in it; below, block means are more sensitive.
const SLOW_S: f64 = 3.0;
const SLOW_PERIODS: f64 = 10.0;
const TURNS: f64 = 0.8;

/// Largest ratio of ticks to known samples; sparser logs are not searched for lines.
pub(super) const SPARSEST: u64 = 4;

/// Samples on the grid of ticks, 0 if unknown; empty for a log sparser than [`SPARSEST`].
pub(super) struct Series {
    pub(super) values: Vec<f64>,
    pub(super) known: usize,
    pub(super) period_s: f64,
}

impl Series {
    /// Returns `error` without its slow part.
    pub(super) fn new(recording: &Recording, slow: &Blocks, error: &[f64]) -> Self {
        let last = recording.segments.last().map_or(0, |last| last.tick + last.rows.len() as u64);
        // a pause of a year would need a grid larger than any memory
        let is_dense = last <= SPARSEST * recording.n_rows() as u64;
        // a length with a fast transform costs a fraction of a percent of the log
        let length = if is_dense { fast_length(last as usize) } else { 0 };
        let mut values = vec![0.0; length];
        let mut known = 0;
        let slow = Slow { blocks: slow, means: &slow.means(error) };
        for segment in &recording.segments {
            let mut near = 0;
            for row in segment.rows.clone().filter(|row| slow.blocks.known()[*row]) {
                let tick = segment.tick as usize + row - segment.rows.start;
                let residual = error[row] - slow.at(tick as f64 * slow.blocks.period_s, &mut near);
                if tick < length && residual != 0.0 && residual.is_finite() {
                    values[tick] = residual;
                    known += 1;
                }
            }
        }
        Self { values, known, period_s: slow.blocks.period_s }
    }

    /// Standard error of the frequency of a sine in white noise, Hz, for a relative standard error of the amplitude of
    /// 1: √3/(π·T) (Rife and Boorstyn 1974, eq. 44).
    pub(super) fn frequency_bound_hz(&self) -> f64 {
        3.0_f64.sqrt() / (TAU / 2.0 * self.values.len() as f64 * self.period_s)
    }

    /// Returns amplitude and phase of the best-fitting sine at a frequency.
    pub(super) fn phasor(&self, frequency_hz: f64) -> Complex<f64> {
        // Σ x·e^(−iωt) = (n/2)·A·e^(i(φ − π/2)) for x = A·sin(ωt + φ)
        self.transform(frequency_hz) * Complex::new(0.0, 2.0 / self.known.max(1) as f64)
    }

    /// Returns Σ x(n)·e^(−iωnT).
    pub(super) fn transform(&self, frequency_hz: f64) -> Complex<f64> {
        let step = Complex::from_polar(1.0, -TAU * frequency_hz * self.period_s);
        let mut sum = Complex::new(0.0, 0.0);
        for (chunk, values) in self.values.chunks(1024).enumerate() {
            // restarted every 1024 samples, so that rounding errors do not accumulate
            let mut phasor =
                Complex::from_polar(1.0, -TAU * frequency_hz * self.period_s * (chunk * 1024) as f64);
            for value in values {
                sum += phasor * *value;
                phasor *= step;
            }
        }
        sum
    }
}

/// Returns the blocks that define the slow part.
pub(super) fn slow_blocks(recording: &Recording, known: &[bool]) -> Blocks {
    let length_s = SLOW_S.max(SLOW_PERIODS * recording.rate.period_s);
    Blocks::new(recording, length_s, known.to_vec())
}

/// Lowest frequency of the search for lines, Hz.
pub(super) fn lowest_hz(period_s: f64) -> f64 {
    TURNS / SLOW_S.max(SLOW_PERIODS * period_s)
}

/// Slow part: block means interpolated linearly.
struct Slow<'a> {
    blocks: &'a Blocks,
    means: &'a [f64],
}

impl Slow<'_> {
    /// Returns the slow part at a time; `near` is the block of the previous call.
    fn at(&self, time_s: f64, near: &mut usize) -> f64 {
        // without a block the slow part is unknown
        let Some(last) = self.blocks.len().checked_sub(1) else { return 0.0 };
        while *near < last && self.blocks.middle_s(*near + 1) <= time_s {
            *near += 1;
        }
        let (begin, end) = (*near, (*near + 1).min(last));
        let (begin_s, end_s) = (self.blocks.middle_s(begin), self.blocks.middle_s(end));
        let adjacent = end_s - begin_s < 1.5 * self.blocks.length_s;
        let share = match end > begin && adjacent {
            true => ((time_s - begin_s) / (end_s - begin_s)).clamp(0.0, 1.0),
            // across motion each side keeps its own level
            false => f64::from(u8::from(end > begin && time_s > 0.5 * (begin_s + end_s))),
        };
        self.means[begin] + share * (self.means[end] - self.means[begin])
    }
}

/// Returns the largest length up to `n` without prime factors above 13.
fn fast_length(n: usize) -> usize {
    let is_fast = |mut n: usize| {
        for factor in [2, 3, 5, 7, 11, 13] {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
        }
        n == 1
    };
    (1..=n).rev().find(|n| is_fast(*n)).unwrap_or(n)
}
