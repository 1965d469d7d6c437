//! Residual by time and frequency: power in octave bands in each twentieth of the log.
//!
//! The power of a cell is the mean of the periodogram over its band (Hann taper, each gap-free piece separately). For
//! noise it is distributed as χ²_ν/ν, where ν follows from the number of ordinates, their correlation under the taper
//! (4/9 and 1/36 in power) and the slope of the spectrum. The usual power is the median over the stretches, corrected
//! for the median of χ²_ν. A median of normal values has 2/π of the information of a mean, so a cell divided by the
//! usual has the F distribution with ν and (2/π)·Σν degrees of freedom.

use std::f64::consts::PI;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use fos_data::recording::{Recording, runs};
use fos_data::statistics::midpoint_median;
use fos_fit::signal::spectrum::hann;
use fos_fit::signal::transforms;

/// Number of stretches that the log is divided into.
const STRETCHES: u64 = 20;

/// Lowest frequency, in reciprocals of a stretch; also the number of ordinates in the lowest octave.
const LOWEST: f64 = 8.0;

/// Ordinates between zero and the lowest usable band of a piece: the taper spreads the mean over two.
const CLEAR_OF_MEAN: f64 = 3.0;

/// Correlation in power of ordinates 0, 1 and 2 apart under a Hann taper: (1, 2/3, 1/6)².
const CORRELATION: [f64; 3] = [1.0, 4.0 / 9.0, 1.0 / 36.0];

/// Least number of stretches for a usual power.
const MIN_STRETCHES: usize = 8;

/// Least degrees of freedom of a cell.
const MIN_FREEDOM: f64 = 4.0;

/// Steepest spectral slope of noise; a steeper one is a line in the band.
const STEEPEST: f64 = 4.0;

/// Largest p, over all cells, at which a cell is reported.
const REPORTED_P: f64 = 0.05;

/// One stretch of the log in one band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Cell {
    /// Begin as timestamp, s.
    pub begin_s: f64,
    /// End as timestamp, s.
    pub end_s: f64,
    /// Lower end of the band, Hz.
    pub low_hz: f64,
    /// Upper end of the band, Hz.
    pub high_hz: f64,
    /// Power divided by the usual power in this band.
    pub times: f64,
    /// Degrees of freedom of the power of noise.
    pub freedom: f64,
    /// Probability of such power in any cell under noise alone (Bonferroni over all cells).
    pub p: f64,
}

/// Power over time and frequency.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct PowerMap {
    /// Cells with enough data, band by band, ascending in time.
    pub cells: Vec<Cell>,
}

impl PowerMap {
    /// Returns the cells with more power than chance explains, lowest p first.
    pub fn worst(&self) -> Vec<&Cell> {
        let mut worst: Vec<&Cell> = self.cells.iter().filter(|cell| cell.p < REPORTED_P).collect();
        worst.sort_by(|a, b| a.p.total_cmp(&b.p).then(b.times.total_cmp(&a.times)));
        worst
    }
}

/// Spectrum of one gap-free piece.
struct Piece {
    power: Vec<f64>,
    resolution_hz: f64,
}

/// A stretch of the log.
struct Stretch {
    begin_s: f64,
    end_s: f64,
    pieces: Vec<Piece>,
}

/// Computes the map of `residual`, one value per row, NaN if unknown, over `rows`.
pub(super) fn power_map(recording: &Recording, rows: Range<usize>, residual: &[f64]) -> PowerMap {
    let (stretches, stretch_ticks) = stretches(recording, rows, residual);
    let rate_hz = 1.0 / recording.rate.period_s;
    let mut low_hz = LOWEST * rate_hz / stretch_ticks as f64;
    let mut cells = Vec::new();
    // terminates: it doubles, from above 0, for a stretch has a length
    while low_hz < rate_hz / 2.0 {
        let band = (low_hz, (2.0 * low_hz).min(rate_hz / 2.0));
        cells.extend(cells_of(&stretches, band));
        low_hz *= 2.0;
    }
    let tried = cells.len() as f64;
    cells.iter_mut().for_each(|cell| cell.p = (cell.p * tried).min(1.0));
    PowerMap { cells }
}

/// Returns the stretches, and their length in ticks.
fn stretches(recording: &Recording, rows: Range<usize>, residual: &[f64]) -> (Vec<Stretch>, u64) {
    let inside = |segment: &fos_data::recording::Segment| {
        let part = segment.rows.start.max(rows.start)..segment.rows.end.min(rows.end);
        (!part.is_empty()).then(|| (segment.tick + (part.start - segment.rows.start) as u64, part))
    };
    let segments: Vec<(u64, Range<usize>)> = recording.segments.iter().filter_map(inside).collect();
    let (Some((begin, _)), Some((last, part))) = (segments.first(), segments.last()) else {
        return (Vec::new(), 1);
    };
    let (begin, end) = (*begin, last + part.len() as u64);
    let ticks = ((end - begin) / STRETCHES).max(1);
    let mut made = Vec::new();
    for stretch in 0..STRETCHES {
        let (from, to) = (begin + stretch * ticks, begin + (stretch + 1) * ticks);
        let parts = segments.iter().filter_map(|(tick, part)| {
            let at = |limit: u64| part.start + (limit.saturating_sub(*tick) as usize).min(part.len());
            let part = at(from)..at(to);
            (!part.is_empty()).then_some(part)
        });
        let parts: Vec<Range<usize>> = parts.collect();
        let (Some(first), Some(last)) = (parts.first(), parts.last()) else { continue };
        let pieces = parts
            .iter()
            .flat_map(|part| runs(part.clone(), |row| residual[row].is_finite()))
            .filter(|piece| piece.len() as f64 > 4.0 * CLEAR_OF_MEAN)
            .map(|piece| Piece::new(&residual[piece], recording.rate.period_s))
            .collect();
        made.push(Stretch {
            begin_s: recording.time_s[first.start],
            end_s: recording.time_s[last.end - 1],
            pieces,
        });
    }
    (made, ticks)
}

impl Piece {
    fn new(values: &[f64], period_s: f64) -> Self {
        let transform = transforms::forward(values.len());
        let mean = fos_fit::signal::mean(&[values]);
        let window = hann(values.len());
        let scale = window.iter().map(|weight| weight * weight).sum::<f64>();
        let mut tapered: Vec<f64> =
            values.iter().zip(&window).map(|(v, weight)| (v - mean) * weight).collect();
        let mut bins = transform.make_output_vec();
        transform.process(&mut tapered, &mut bins).expect("buffers made by this transform fit it");
        let power = bins.iter().map(|bin| bin.norm_sqr() / scale).collect();
        Self { power, resolution_hz: 1.0 / (values.len() as f64 * period_s) }
    }

    /// Returns the ordinates in a band. The last one, at half the sampling rate, has another distribution and is
    /// excluded.
    fn ordinates(&self, (low_hz, high_hz): (f64, f64)) -> Range<usize> {
        if low_hz < CLEAR_OF_MEAN * self.resolution_hz {
            return 0..0;
        }
        let at = |hz: f64| ((hz / self.resolution_hz).ceil() as usize).min(self.power.len() - 1);
        at(low_hz)..at(high_hz)
    }
}

/// Returns the cells of one band; p is not yet corrected for the number of cells.
fn cells_of(stretches: &[Stretch], band: (f64, f64)) -> Vec<Cell> {
    let slope = slope(stretches, band);
    let middle_hz = (band.0 * band.1).sqrt();
    // (stretch, power, degrees of freedom)
    let known: Vec<(&Stretch, f64, f64)> = stretches
        .iter()
        .filter_map(|stretch| {
            let (mut power, mut expected, mut variance) = (0.0, 0.0, 0.0);
            for piece in &stretch.pieces {
                let ordinates = piece.ordinates(band);
                power += piece.power[ordinates.clone()].iter().sum::<f64>();
                let shape: Vec<f64> =
                    ordinates.map(|bin| (bin as f64 * piece.resolution_hz / middle_hz).powf(slope)).collect();
                expected += shape.iter().sum::<f64>();
                for (apart, correlation) in CORRELATION.into_iter().enumerate() {
                    let pairs: f64 = shape.iter().zip(shape.iter().skip(apart)).map(|(a, b)| a * b).sum();
                    variance += if apart == 0 { pairs } else { 2.0 * pairs * correlation };
                }
            }
            let freedom = 2.0 * expected * expected / variance;
            (freedom >= MIN_FREEDOM && power > 0.0).then_some((stretch, power / expected, freedom))
        })
        .collect();
    if known.len() < MIN_STRETCHES {
        return Vec::new();
    }
    let mut levels: Vec<f64> =
        known.iter().map(|(_, power, freedom)| power / median_of_noise(*freedom)).collect();
    let usual = midpoint_median(&mut levels);
    let together = 2.0 / PI * known.iter().map(|(.., freedom)| freedom).sum::<f64>();
    known
        .into_iter()
        .map(|(stretch, power, freedom)| {
            let times = power / usual;
            let p = FisherSnedecor::new(freedom, together).map_or(1.0, |noise| noise.sf(times));
            Cell {
                begin_s: stretch.begin_s,
                end_s: stretch.end_s,
                low_hz: band.0,
                high_hz: band.1,
                times,
                freedom,
                p,
            }
        })
        .collect()
}

/// Median of χ²_ν/ν.
fn median_of_noise(freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |noise| noise.inverse_cdf(0.5) / freedom)
}

/// Exponent of the spectrum across a band, from its two halves in all stretches together.
fn slope(stretches: &[Stretch], (low_hz, high_hz): (f64, f64)) -> f64 {
    let middle_hz = (low_hz * high_hz).sqrt();
    let (mut power, mut log_hz, mut count) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    for piece in stretches.iter().flat_map(|stretch| &stretch.pieces) {
        for bin in piece.ordinates((low_hz, high_hz)) {
            let hz = bin as f64 * piece.resolution_hz;
            let half = usize::from(hz > middle_hz);
            power[half] += piece.power[bin];
            log_hz[half] += hz.ln();
            count[half] += 1.0;
        }
    }
    let mean = |sums: [f64; 2]| [sums[0] / count[0], sums[1] / count[1]];
    let (power, log_hz) = (mean(power), mean(log_hz));
    let slope = (power[1] / power[0]).ln() / (log_hz[1] - log_hz[0]);
    if slope.is_finite() { slope.clamp(-STEEPEST, STEEPEST) } else { 0.0 }
}
