//! Lines: narrow bands of the spectrum of a whole log that hold more than the noise around them.
//!
//! The log's noise is smooth in frequency; over its local median, ordinates of the periodogram are unit exponentials. A band
//! of w ordinates with mean m has log-likelihood ratio w·(m − 1 − ln m) against noise; bands of doubling width find a line
//! that keeps its phase (w = 1) and one that wanders with the same test.

use std::f64::consts::TAU;
use std::ops::Range;

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::error_in_blocks::ErrorInBlocks;
use fos_data::recording::Recording;
use fos_fit::noise::Blocks;

/// Least score of a line: 2·log-likelihood ratio minus 2·ln(bands looked at).
pub(crate) const ACCEPT: f64 = 15.0;

/// Length of the means that stand for the slow part, s, and in sample periods: lines are looked for from eight tenths of a
/// turn in it; below, block means see more.
const SLOW_S: f64 = 3.0;
const SLOW_PERIODS: f64 = 10.0;
const TURNS: f64 = 0.8;

/// Most lines named.
const MAX_LINES: usize = 6;

/// Widest band, Hz.
const WIDEST_HZ: f64 = 0.7;

/// Ordinates over which the local median is taken: half of the frequency, at least so many, at most so many Hz, over which
/// the colour of a sensor's noise changes little.
const MEDIAN_SHARE: f64 = 0.5;
const FEWEST_ORDINATES: usize = 60;
const MEDIAN_OVER_HZ: f64 = 3.0;

/// A band is no wider than this share of the stretch that its noise is known from: the median's own error must not add up.
const BAND_SHARE: f64 = 1.0 / 3.0;

/// A line of which a sine of constant phase leaves less than this share keeps its phase.
const COHERENT: f64 = 0.35;

/// A line that is there for less than this share of the time comes and goes.
pub(crate) const STEADY: f64 = 0.45;

/// A line that was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Frequency, Hz; of one that wanders the centre of its power.
    pub(crate) frequency_hz: f64,
    /// It keeps its phase over the whole log.
    pub(crate) coherent: bool,
    /// Its standard error, Hz.
    pub(crate) frequency_error: f64,
    /// Amplitude, unit of the axis; of one that wanders √(2·power).
    pub(crate) amplitude: f64,
    /// Its standard error.
    pub(crate) amplitude_error: f64,
    /// Phase of the sine at the first sample.
    pub(crate) phase: f64,
    /// Its band, Hz.
    pub(crate) band_hz: (f64, f64),
    /// 2·log-likelihood ratio minus 2·ln(bands looked at).
    pub(crate) score: f64,
    /// Share of the log's length in which it is there, from its power over time.
    pub(crate) duty: f64,
}

/// Samples on the grid of ticks, 0 where not known.
struct Series {
    values: Vec<f64>,
    known: usize,
    period_s: f64,
}

/// Lines in the spectrum of what a log was reduced to.
pub(super) fn of(reduced: &ErrorInBlocks, recording: &Recording) -> Vec<Line> {
    find(recording, reduced.blocks.known(), &reduced.error)
}

/// Looks for lines in `error`, one value per row, among the rows that `known` marks.
pub(crate) fn find(recording: &Recording, known: &[bool], error: &[f64]) -> Vec<Line> {
    let slow = Slow::blocks(recording, known);
    let mut error = error.to_vec();
    let mut found: Vec<Line> = Vec::new();
    let mut taken: Vec<(f64, f64)> = Vec::new();
    // ends: a line more each time; its band is not looked at again
    while found.len() < MAX_LINES {
        fos_data::interrupt::check();
        let series = Series::new(recording, &slow, &error);
        let Some(periodogram) = Periodogram::of(&series) else { break };
        let Some(band) = periodogram.best_band(&taken) else { break };
        let mut line = periodogram.describe(&band);
        line.duty = duty(&series, &line);
        let (sine, without) = series.sine(&periodogram, &band, recording, &slow, &error);
        let rest = Series::new(recording, &slow, &without);
        let after = Periodogram::of(&rest);
        let left = after.as_ref().map_or(0.0, |after| after.excess(&band, &periodogram.floor));
        line.coherent = left < COHERENT * periodogram.excess(&band, &periodogram.floor);
        if line.coherent {
            (line.frequency_hz, line.amplitude, line.phase) = (sine.frequency_hz, sine.amplitude, sine.phase);
            // the noise once the line and its skirts are gone; white noise of variance s has σ_A² = 2s/n
            if let Some(after) = after {
                line.amplitude_error = (2.0 * after.floor[band.start] / rest.known as f64).sqrt();
            }
            line.frequency_error = line.amplitude_error / line.amplitude * rest.frequency_bound_hz();
            error = without;
        }
        taken.push(line.band_hz);
        found.push(line);
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    merged(found)
}

/// A line that wanders further than the widest band shows in several next to one another: one line.
fn merged(found: Vec<Line>) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for line in found {
        let near = |other: &&mut Line| {
            !other.coherent
                && !line.coherent
                && line.band_hz.0 < other.band_hz.1 + WIDEST_HZ
                && line.band_hz.1 > other.band_hz.0 - WIDEST_HZ
        };
        let Some(other) = lines.iter_mut().find(near) else {
            lines.push(line);
            continue;
        };
        let (own, more) = (other.amplitude.powi(2), line.amplitude.powi(2));
        other.frequency_hz = (own * other.frequency_hz + more * line.frequency_hz) / (own + more);
        other.amplitude = (own + more).sqrt();
        other.band_hz = (other.band_hz.0.min(line.band_hz.0), other.band_hz.1.max(line.band_hz.1));
        other.frequency_error = (other.band_hz.1 - other.band_hz.0) / 12.0_f64.sqrt();
        // in one band while it is not in the other
        other.duty = (other.duty + line.duty).min(1.0);
    }
    lines
}

/// Whether another axis has the same line, at least a tenth as strong: then it is motion.
pub(crate) fn is_shared(recording: &Recording, other: &ErrorInBlocks, line: &Line) -> bool {
    let slow = Slow::blocks(recording, other.blocks.known());
    let series = Series::new(recording, &slow, &other.error);
    Periodogram::of(&series).is_some_and(|periodogram| {
        let bin = |hz: f64| (hz / periodogram.resolution_hz) as usize;
        let band = bin(line.band_hz.0)..(bin(line.band_hz.1) + 1).min(periodogram.power.len());
        let excess: f64 = band.map(|bin| periodogram.power[bin] - periodogram.floor[bin]).sum();
        excess * 4.0 / periodogram.samples as f64 > SHARED * line.amplitude * line.amplitude
    })
}

/// Share of a line's power that another axis must have to share it.
const SHARED: f64 = 0.01;

/// A sine.
#[derive(Debug, Clone, Copy)]
struct Sine {
    frequency_hz: f64,
    amplitude: f64,
    /// At the first sample.
    phase: f64,
}

impl Series {
    /// Of `error` without its slow part.
    fn new(recording: &Recording, slow: &Blocks, error: &[f64]) -> Self {
        let last = recording.segments.last().map_or(0, |last| last.tick + last.rows.len() as u64);
        // lengths whose transform is fast lose a fraction of a percent of the log
        let length = fast_length(last as usize);
        let mut values = vec![0.0; length];
        let mut known = 0;
        let slow = Slow { blocks: slow, means: &slow.means(error) };
        for segment in &recording.segments {
            let mut near = 0;
            for row in segment.rows.clone().filter(|row| slow.blocks.known()[*row]) {
                let tick = segment.tick as usize + row - segment.rows.start;
                let left = error[row] - slow.at(tick as f64 * slow.blocks.period_s, &mut near);
                if tick < length && left != 0.0 && left.is_finite() {
                    values[tick] = left;
                    known += 1;
                }
            }
        }
        Self { values, known, period_s: slow.blocks.period_s }
    }

    /// Standard error of the frequency of a sine in white noise for one of 1 of amplitude and phase, Hz: √3/(π·T) (Rife and
    /// Boorstyn 1974, eq. 44).
    fn frequency_bound_hz(&self) -> f64 {
        3.0_f64.sqrt() / (TAU / 2.0 * self.values.len() as f64 * self.period_s)
    }

    /// The sine that explains most near the largest ordinate of a band, and `error` without it.
    ///
    /// The slow part holds a share of a slow sine, and takes it off: what of the sine is left once it and its slow part are
    /// gone is added to it.
    fn sine(
        &self,
        periodogram: &Periodogram,
        band: &Range<usize>,
        recording: &Recording,
        slow: &Blocks,
        error: &[f64],
    ) -> (Sine, Vec<f64>) {
        let peak = band.clone().max_by(|a, b| periodogram.power[*a].total_cmp(&periodogram.power[*b]));
        let peak = peak.unwrap_or(band.start);
        let relative_error =
            (periodogram.floor[peak] / periodogram.power[peak].max(periodogram.floor[peak])).sqrt();
        let within_hz = WELL_WITHIN * relative_error * self.frequency_bound_hz();
        let frequency_hz = self.peak_hz(peak as f64 * periodogram.resolution_hz, periodogram, within_hz);
        let mut phasor = self.phasor(frequency_hz);
        let mut without = subtracted(error, recording, frequency_hz, phasor);
        for _ in 0..SLOW_PASSES {
            let more = Self::new(recording, slow, &without).phasor(frequency_hz);
            without = subtracted(&without, recording, frequency_hz, more);
            phasor += more;
        }
        (Sine { frequency_hz, amplitude: phasor.norm(), phase: phasor.arg() }, without)
    }

    /// The frequency of the most power within an ordinate of `peak_hz`, by golden section: the main lobe has one maximum.
    fn peak_hz(&self, peak_hz: f64, periodogram: &Periodogram, within_hz: f64) -> f64 {
        let (mut low, mut high) = (peak_hz - periodogram.resolution_hz, peak_hz + periodogram.resolution_hz);
        let golden = 0.381_966_011_250_105;
        let (mut a, mut b) = (low + golden * (high - low), high - golden * (high - low));
        let (mut at_a, mut at_b) = (self.transform(a).norm_sqr(), self.transform(b).norm_sqr());
        for _ in 0..MOST_SECTIONS {
            if high - low < within_hz {
                break;
            }
            if at_a > at_b {
                (high, b, at_b) = (b, a, at_a);
                a = low + golden * (high - low);
                at_a = self.transform(a).norm_sqr();
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = high - golden * (high - low);
                at_b = self.transform(b).norm_sqr();
            }
        }
        0.5 * (low + high)
    }

    /// Amplitude and phase of the sine of a frequency that explains most.
    fn phasor(&self, frequency_hz: f64) -> Complex<f64> {
        // Σ x·e^(−iωt) = (n/2)·A·e^(i(φ − π/2)) for x = A·sin(ωt + φ)
        self.transform(frequency_hz) * Complex::new(0.0, 2.0 / self.known.max(1) as f64)
    }

    /// Σ x(n)·e^(−iωnT).
    fn transform(&self, frequency_hz: f64) -> Complex<f64> {
        let step = Complex::from_polar(1.0, -TAU * frequency_hz * self.period_s);
        let mut sum = Complex::new(0.0, 0.0);
        for (chunk, values) in self.values.chunks(1024).enumerate() {
            // anew every 1024 samples, so that rounding does not add up
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

/// A frequency is looked for to this share of its standard error, in at most so many steps.
const WELL_WITHIN: f64 = 0.2;
const MOST_SECTIONS: usize = 40;

/// What the slow part holds of a sine falls to less than a tenth with each pass.
const SLOW_PASSES: usize = 2;

/// `error` without a sine of this phasor, one value per row.
fn subtracted(error: &[f64], recording: &Recording, frequency_hz: f64, phasor: Complex<f64>) -> Vec<f64> {
    let mut without = error.to_vec();
    for segment in &recording.segments {
        for row in segment.rows.clone() {
            let tick = segment.tick as f64 + (row - segment.rows.start) as f64;
            let angle = TAU * frequency_hz * tick * recording.rate.period_s + phasor.arg();
            without[row] -= phasor.norm() * angle.sin();
        }
    }
    without
}

/// The slow part: block means joined by straight lines.
struct Slow<'a> {
    blocks: &'a Blocks,
    means: &'a [f64],
}

impl Slow<'_> {
    /// The blocks that it is known from.
    fn blocks(recording: &Recording, known: &[bool]) -> Blocks {
        let length_s = SLOW_S.max(SLOW_PERIODS * recording.rate.period_s);
        Blocks::new(recording, length_s, known.to_vec())
    }

    /// At a time; `near` is the block that was near the last time asked for.
    fn at(&self, time_s: f64, near: &mut usize) -> f64 {
        let last = self.blocks.len() - 1;
        while *near < last && self.blocks.middle_s(*near + 1) <= time_s {
            *near += 1;
        }
        let (begin, end) = (*near, (*near + 1).min(last));
        let (begin_s, end_s) = (self.blocks.middle_s(begin), self.blocks.middle_s(end));
        let adjacent = end_s - begin_s < 1.5 * self.blocks.length_s;
        let share = match end > begin && adjacent {
            true => ((time_s - begin_s) / (end_s - begin_s)).clamp(0.0, 1.0),
            // across a motion each side keeps its own
            false => f64::from(u8::from(end > begin && time_s > 0.5 * (begin_s + end_s))),
        };
        self.means[begin] + share * (self.means[end] - self.means[begin])
    }
}

/// Power over the local noise floor.
struct Periodogram {
    /// |X|²/n per ordinate.
    power: Vec<f64>,
    /// Mean of the noise around it.
    floor: Vec<f64>,
    resolution_hz: f64,
    samples: usize,
    /// The first ordinate looked at.
    first: usize,
}

impl Periodogram {
    fn of(series: &Series) -> Option<Self> {
        let n = series.values.len();
        if n < 2000 || series.known < n / 4 {
            return None;
        }
        let transform = RealFftPlanner::new().plan_fft_forward(n);
        let mut buffer = series.values.clone();
        let mut bins = transform.make_output_vec();
        transform.process(&mut buffer, &mut bins).ok()?;
        let power: Vec<f64> = bins.iter().map(|bin| bin.norm_sqr() / series.known as f64).collect();
        let resolution_hz = 1.0 / (n as f64 * series.period_s);
        let lowest_hz = TURNS / SLOW_S.max(SLOW_PERIODS * series.period_s);
        let first = ((lowest_hz / resolution_hz).ceil() as usize).max(1);
        let floor = floor(&power, first, (MEDIAN_OVER_HZ / resolution_hz) as usize);
        Some(Self { power, floor, resolution_hz, samples: series.known, first })
    }

    /// The ordinates of the best band, if it is good enough.
    fn best_band(&self, taken: &[(f64, f64)]) -> Option<Range<usize>> {
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
                let gain = gain(sums[start + width] - sums[start], width);
                if best.as_ref().is_none_or(|(other, _)| gain > *other) {
                    best = Some((gain, start..start + width));
                }
            }
            width *= 2;
        }
        best.filter(|(gain, _)| gain - self.price() >= ACCEPT).map(|(_, band)| band)
    }

    fn most_ordinates(&self) -> usize {
        (MEDIAN_OVER_HZ / self.resolution_hz) as usize
    }

    /// 2·ln(bands looked at): over all widths, two for each ordinate of the narrowest.
    fn price(&self) -> f64 {
        2.0 * (4.0 * self.power.len() as f64).ln()
    }

    /// Power in excess of `floor` in a band, in units of it.
    fn excess(&self, band: &Range<usize>, floor: &[f64]) -> f64 {
        let margin = band.len().max(4);
        let wide = band.start.saturating_sub(margin)..(band.end + margin).min(self.power.len());
        wide.map(|bin| self.power[bin] / floor[bin] - 1.0).sum::<f64>().max(0.0)
    }

    fn describe(&self, band: &Range<usize>) -> Line {
        let over = |bin: usize| (self.power[bin] - self.floor[bin]).max(0.0);
        let total: f64 = band.clone().map(over).sum();
        let centre: f64 = band.clone().map(|bin| over(bin) * bin as f64).sum::<f64>() / total;
        let margin = (band.len() / 2).max(2) as f64;
        let sum: f64 = band.clone().map(|bin| self.power[bin] / self.floor[bin]).sum();
        // Σ|X|²/n over the band is n·A²/4
        let excess: f64 = band.clone().map(|bin| self.power[bin] - self.floor[bin]).sum();
        Line {
            frequency_hz: centre * self.resolution_hz,
            frequency_error: band.len() as f64 * self.resolution_hz / 12.0_f64.sqrt(),
            coherent: false,
            // white noise of variance s has σ_A² = 2s/n
            amplitude_error: (2.0 * self.floor[band.start] / self.samples as f64).sqrt(),
            phase: 0.0,
            amplitude: 2.0 * (excess.max(0.0) / self.samples as f64).sqrt(),
            band_hz: (
                (band.start as f64 - margin) * self.resolution_hz,
                (band.end as f64 + margin) * self.resolution_hz,
            ),
            score: gain(sum, band.len()) - self.price(),
            duty: 1.0,
        }
    }
}

/// 2·log-likelihood ratio of a band of `width` unit exponentials that sum to `sum` against their mean being 1.
fn gain(sum: f64, width: usize) -> f64 {
    let width = width as f64;
    let mean = sum / width;
    if mean > 1.0 { 2.0 * width * (mean - 1.0 - mean.ln()) } else { 0.0 }
}

/// Ordinates that the noise around the one at `start` is known from, at most `most`.
fn stretch(start: usize, most: usize) -> usize {
    let wanted = (MEDIAN_SHARE * start as f64) as usize;
    wanted.clamp(FEWEST_ORDINATES, most.max(FEWEST_ORDINATES))
}

/// The noise around each ordinate from `first` on: medians over stretches of at most `most`, over ln 2, joined by straight
/// lines in logarithms of level and frequency.
fn floor(power: &[f64], first: usize, most: usize) -> Vec<f64> {
    let mut knots: Vec<(f64, f64)> = Vec::new();
    let mut start = first;
    // ends: a stretch is FEWEST_ORDINATES at least
    while start < power.len() {
        let mut end = (start + stretch(start, most)).min(power.len());
        if power.len() - end < FEWEST_ORDINATES {
            end = power.len();
        }
        let mut values = power[start..end].to_vec();
        let middle = values.len() / 2;
        let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let level = (*median / std::f64::consts::LN_2).max(f64::MIN_POSITIVE);
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
        // goes on below the first as between the first two
        let share = if end.0 > begin.0 { ((log - begin.0) / (end.0 - begin.0)).min(1.0) } else { 0.0 };
        (begin.1 + share * (end.1 - begin.1)).exp()
    };
    (0..power.len()).map(at).collect()
}

/// Share of the log in which a line is there: (Σ p)²/(m·Σ p²) of its power p over m stretches, above the noise; 1 for a
/// constant amplitude.
fn duty(series: &Series, line: &Line) -> f64 {
    let stretch = (DUTY_STRETCH_S / series.period_s) as usize;
    let width_hz = (line.band_hz.1 - line.band_hz.0).max(1.0 / DUTY_STRETCH_S);
    let centre = 0.5 * (line.band_hz.0 + line.band_hz.1);
    // a few frequencies across the band, each as wide as a stretch is long
    let steps = (width_hz * DUTY_STRETCH_S).ceil().max(1.0) as i32;
    let frequencies: Vec<f64> =
        (-steps / 2..=steps / 2).map(|i| centre + f64::from(i) / DUTY_STRETCH_S).collect();
    let around: Vec<f64> =
        [-3.0, -2.0, 2.0, 3.0].into_iter().map(|i| centre + i * (width_hz + 2.0 / DUTY_STRETCH_S)).collect();
    let power = |values: &[f64], frequencies: &[f64]| {
        let part = Series { values: values.to_vec(), known: values.len(), period_s: series.period_s };
        frequencies.iter().map(|hz| part.transform(*hz).norm_sqr()).sum::<f64>() / frequencies.len() as f64
    };
    let powers: Vec<(f64, f64)> = series
        .values
        .chunks_exact(stretch)
        .map(|values| (power(values, &frequencies), power(values, &around)))
        .collect();
    let noise = powers.iter().map(|(_, noise)| noise).sum::<f64>() / powers.len().max(1) as f64;
    let n = frequencies.len() as f64;
    // E (s + e)² = s² + 2s·noise/n + noise²(1 + 1/n) with noise of n ordinates' mean
    let first: f64 = powers.iter().map(|(p, _)| p - noise).sum::<f64>() / powers.len().max(1) as f64;
    let second: f64 = powers
        .iter()
        .map(|(p, _)| (p - noise).powi(2) - noise * noise / n - 2.0 * noise * (p - noise) / n)
        .sum::<f64>()
        / powers.len().max(1) as f64;
    if second > 0.0 { (first * first / second).min(1.0) } else { 1.0 }
}

/// Length of the stretches whose power is compared, s.
const DUTY_STRETCH_S: f64 = 5.0;

/// The largest length up to `n` without prime factors above 13.
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
