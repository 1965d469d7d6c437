//! Periodogram divided by the local noise floor, and the band that exceeds it most.

use std::ops::Range;

use fos_fit::signal::transforms;

use super::line::Line;
use super::series::{SPARSEST, Series, lowest_hz};
use fos_data::statistics::median;

/// Least score of a line: 2·log-likelihood ratio minus 2·ln(number of bands tried).
const ACCEPT: f64 = 15.0;

/// Width of the local median: this share of the frequency, with a least number of ordinates and a largest width in Hz,
/// over which the noise spectrum of a sensor changes little.
const MEDIAN_SHARE: f64 = 0.5;
const MIN_ORDINATES: usize = 60;
const MEDIAN_OVER_HZ: f64 = 3.0;

/// Widest band, Hz.
pub(super) const WIDEST_HZ: f64 = 0.7;

/// Largest width of a band as a share of the stretch of its noise floor: the error of the median must not add up.
const BAND_SHARE: f64 = 1.0 / 3.0;

/// Number of ordinates on either side that a band is compared with.
const SIDE_ORDINATES: usize = 32;

/// Periodogram with its local noise floor.
pub(super) struct Periodogram {
    /// |X|²/n per ordinate.
    pub(super) power: Vec<f64>,
    /// Mean of the local noise.
    pub(super) floor: Vec<f64>,
    pub(super) resolution_hz: f64,
    pub(super) samples: usize,
    /// Independent ordinates per ordinate: the known share of the log. Where samples are missing, neighbours resemble each
    /// other.
    independent: f64,
    /// First ordinate of the search.
    first: usize,
}

impl Periodogram {
    pub(super) fn of(series: &Series) -> Option<Self> {
        let n = series.values.len();
        if n < 2000 || series.known < n / SPARSEST as usize {
            return None;
        }
        let transform = transforms::forward(n);
        let mut buffer = series.values.clone();
        let mut bins = transform.make_output_vec();
        transform.process(&mut buffer, &mut bins).ok()?;
        let power: Vec<f64> = bins.iter().map(|bin| bin.norm_sqr() / series.known as f64).collect();
        let resolution_hz = 1.0 / (n as f64 * series.period_s);
        let first = ((lowest_hz(series.period_s) / resolution_hz).ceil() as usize).max(1);
        let floor = floor(&power, first, (MEDIAN_OVER_HZ / resolution_hz) as usize);
        let independent = series.known as f64 / n as f64;
        Some(Self { power, floor, resolution_hz, samples: series.known, independent, first })
    }

    /// Returns the ordinates of the best band with a sufficient score.
    pub(super) fn best_band(&self, taken: &[(f64, f64)]) -> Option<Range<usize>> {
        let ratio = |bin: usize| self.power[bin] / self.floor[bin];
        let first = self.first;
        let last = self.power.len() - 1;
        let widest = ((WIDEST_HZ / self.resolution_hz) as usize).max(1);
        let mut sums = vec![0.0; self.power.len() + 1];
        for bin in 0..self.power.len() {
            let hz = bin as f64 * self.resolution_hz;
            let free = bin >= first && !taken.iter().any(|(low, high)| (*low..=*high).contains(&hz));
            sums[bin + 1] = sums[bin] + if free { ratio(bin) } else { 1.0 };
        }
        let mut best: Option<(f64, Range<usize>)> = None;
        let mut width = 1;
        while width <= widest {
            for start in (first..last.saturating_sub(width)).step_by((width / 2).max(1)) {
                if width > 1 && width as f64 > BAND_SHARE * stretch(start, self.most_ordinates()) as f64 {
                    continue;
                }
                let gain = self.gain(sums[start + width] - sums[start], width);
                if gain - self.price() < ACCEPT || !self.is_above_both_sides(start..start + width) {
                    continue;
                }
                if best.as_ref().is_none_or(|(other, _)| gain > *other) {
                    best = Some((gain, start..start + width));
                }
            }
            width *= 2;
        }
        best.map(|(_, band)| band)
    }

    /// Returns true if a band also exceeds the ordinates on either side of it. Filtered noise has slopes and edges that
    /// no floor follows exactly, but they rise on one side only.
    fn is_above_both_sides(&self, band: Range<usize>) -> bool {
        let margin = band.len().max(4);
        let side = SIDE_ORDINATES.max(2 * band.len());
        let below =
            band.start.saturating_sub(margin + side).max(self.first)..band.start.saturating_sub(margin);
        let above = band.end + margin..(band.end + margin + side).min(self.power.len());
        let level = |side: Range<usize>| match side.len() >= SIDE_ORDINATES / 2 {
            true => median(&mut self.power[side].to_vec()) / std::f64::consts::LN_2,
            // at the end of the spectrum there is one side only
            false => 0.0,
        };
        let level = level(below).max(level(above));
        let sum: f64 = self.power[band.clone()].iter().sum();
        self.gain(sum / level, band.len()) - self.price() >= ACCEPT
    }

    fn most_ordinates(&self) -> usize {
        (MEDIAN_OVER_HZ / self.resolution_hz) as usize
    }

    /// Penalty 2·ln(number of bands tried): over all widths, two for each ordinate of the narrowest.
    fn price(&self) -> f64 {
        2.0 * (4.0 * self.power.len() as f64).ln()
    }

    /// Returns the power in excess of `floor` in a band, in units of it.
    pub(super) fn excess(&self, band: &Range<usize>, floor: &[f64]) -> f64 {
        let margin = band.len().max(4);
        let wide = band.start.saturating_sub(margin)..(band.end + margin).min(self.power.len());
        wide.map(|bin| self.power[bin] / floor[bin] - 1.0).sum::<f64>().max(0.0)
    }

    pub(super) fn describe(&self, band: &Range<usize>) -> Line {
        let over = |bin: usize| (self.power[bin] - self.floor[bin]).max(0.0);
        let total: f64 = band.clone().map(over).sum();
        let centre: f64 = band.clone().map(|bin| over(bin) * bin as f64).sum::<f64>() / total;
        let margin = (band.len() / 2).max(2) as f64;
        Line {
            frequency_hz: centre * self.resolution_hz,
            frequency_error: band.len() as f64 * self.resolution_hz / 12.0_f64.sqrt(),
            coherent: false,
            // white noise of variance s has σ_A² = 2s/n
            amplitude_error: (2.0 * self.floor[band.start] / self.samples as f64).sqrt(),
            phase: 0.0,
            amplitude: self.square_of_amplitude(self.power_over_floor(band)).max(0.0).sqrt(),
            band_hz: (
                (band.start as f64 - margin) * self.resolution_hz,
                (band.end as f64 + margin) * self.resolution_hz,
            ),
            score: self.gain_over_floor(band) - self.price(),
            duty: 1.0,
        }
    }

    /// Returns true if a given band has more power than noise reaches once in a thousand times.
    pub(super) fn stands_out(&self, band: &Range<usize>) -> bool {
        !band.is_empty() && self.gain_over_floor(band) > STANDS_OUT
    }

    /// Returns the power of a band minus that of its noise.
    pub(super) fn power_over_floor(&self, band: &Range<usize>) -> f64 {
        band.clone().map(|bin| self.power[bin] - self.floor[bin]).sum()
    }

    /// Returns A² of a line A·sin(ωt + φ) with this power: Σ|X|²/n over its band is n·A²/4.
    pub(super) fn square_of_amplitude(&self, power: f64) -> f64 {
        4.0 * power / self.samples as f64
    }

    fn gain_over_floor(&self, band: &Range<usize>) -> f64 {
        self.gain(band.clone().map(|bin| self.power[bin] / self.floor[bin]).sum(), band.len())
    }

    /// Returns the standard deviation of the power of the noise in a band; that of an ordinate is its mean.
    pub(super) fn noise_deviation(&self, band: &Range<usize>) -> f64 {
        (self.floor[band.clone()].iter().map(|floor| floor.powi(2)).sum::<f64>() / self.independent).sqrt()
    }

    /// Returns 2·log-likelihood ratio of a band of `width` unit exponentials that sum to `sum` against a mean of 1.
    fn gain(&self, sum: f64, width: usize) -> f64 {
        let mean = sum / width as f64;
        let count = (width as f64 * self.independent).max(1.0);
        if mean > 1.0 { 2.0 * count * (mean - 1.0 - mean.ln()) } else { 0.0 }
    }
}

/// Twice the logarithm of odds of a thousand to one.
const STANDS_OUT: f64 = 13.8;

/// Number of ordinates for the noise floor around `start`, at most `most`.
fn stretch(start: usize, most: usize) -> usize {
    let wanted = (MEDIAN_SHARE * start as f64) as usize;
    wanted.clamp(MIN_ORDINATES, most.max(MIN_ORDINATES))
}

/// Noise floor at each ordinate from `first` on: medians over stretches of at most `most` ordinates, divided by ln 2,
/// interpolated linearly in logarithms of level and frequency.
fn floor(power: &[f64], first: usize, most: usize) -> Vec<f64> {
    let mut knots: Vec<(f64, f64)> = Vec::new();
    let mut start = first;
    // terminates: a stretch has at least MIN_ORDINATES
    while start < power.len() {
        let mut end = (start + stretch(start, most)).min(power.len());
        if power.len() - end < MIN_ORDINATES {
            end = power.len();
        }
        let level = (median(&mut power[start..end].to_vec()) / std::f64::consts::LN_2).max(f64::MIN_POSITIVE);
        knots.push(((0.5 * (start + end) as f64).ln(), level.ln()));
        start = end;
    }
    let mut near = 0;
    let at = |bin: usize| {
        let log = (bin.max(first) as f64).ln();
        while near + 2 < knots.len() && knots[near + 1].0 <= log {
            near += 1;
        }
        let (begin, end) = (knots[near], knots[(near + 1).min(knots.len() - 1)]);
        // below the first knot it extrapolates the first two
        let share = if end.0 > begin.0 { ((log - begin.0) / (end.0 - begin.0)).min(1.0) } else { 0.0 };
        (begin.1 + share * (end.1 - begin.1)).exp()
    };
    (0..power.len()).map(at).collect()
}
