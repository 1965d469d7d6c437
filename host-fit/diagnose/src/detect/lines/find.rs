//! Sequential search for lines: each coherent line is subtracted before the next search; and comparison with other
//! axes.

use realfft::num_complex::Complex;

use super::line::{Line, STEADY, duty};
use super::periodogram::{Periodogram, WIDEST_HZ};
use super::series::{Series, slow_blocks};
use super::sine::subtracted;
use crate::detect::error_in_blocks::ErrorInBlocks;
use fos_data::column::{AXES, Column};
use fos_data::recording::{Recording, RecordingError};

const MAX_LINES: usize = 6;

/// Largest share of a line's excess power that a sine of constant phase may leave if the line is coherent.
const COHERENT: f64 = 0.35;

/// Share of a line's power from which on another axis shares it.
const SHARED: f64 = 0.01;

/// Finds lines in the spectrum of a reduced log that are errors of the sensor. Motion is excluded: on a shaker or near a
/// machine, lines that another axis shows too; anywhere, intermittent or wandering lines that several axes show.
pub(crate) fn of(
    recording: &Recording,
    column: &str,
    reduced: &ErrorInBlocks,
    shaken: bool,
) -> Result<Vec<Line>, RecordingError> {
    let mut lines = find(recording, reduced.blocks.known(), &reduced.error);
    if shaken {
        lines.retain(|line| line.duty >= STEADY);
    }
    let may_be_motion = |line: &Line| shaken || !line.coherent || line.duty < STEADY;
    for other in AXES.into_iter().filter(|other| *other != column) {
        if !lines.iter().any(may_be_motion) {
            break;
        }
        if recording.channel(other).is_ok() {
            let same_unit = Column::named(other).unit() == Column::named(column).unit();
            let other = ErrorInBlocks::of(recording, other)?;
            let mut shared = shared(recording, &other, &lines, same_unit).into_iter();
            lines.retain(|line| !(shared.next().unwrap_or(false) && may_be_motion(line)));
        }
    }
    Ok(lines)
}

/// Returns the block means of a reduced log without the sines of its coherent lines.
pub(crate) fn means_without(lines: &[Line], reduced: &ErrorInBlocks, recording: &Recording) -> Vec<f64> {
    let coherent = || lines.iter().filter(|line| line.coherent);
    if coherent().next().is_none() {
        return reduced.means.clone();
    }
    let without = coherent().fold(reduced.error.clone(), |error, line| {
        let phasor = Complex::from_polar(line.amplitude, line.phase);
        subtracted(&error, recording, line.frequency_hz, phasor)
    });
    reduced.blocks.means(&without)
}

/// Finds lines in `error`, one value per row, in the rows that `known` marks.
pub(super) fn find(recording: &Recording, known: &[bool], error: &[f64]) -> Vec<Line> {
    let slow = slow_blocks(recording, known);
    // without slow blocks drift would be mistaken for lines
    if slow.is_empty() {
        return Vec::new();
    }
    let mut error = error.to_vec();
    let mut found: Vec<Line> = Vec::new();
    let mut taken: Vec<(f64, f64)> = Vec::new();
    // terminates: each iteration adds a line and excludes its band
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
            // noise floor after the line and its skirts are removed; white noise of variance s has σ_A² = 2s/n
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

/// Merges adjacent wandering lines: one that wanders further than the widest band shows in several.
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
        // the line is in one band while it is absent from the other
        other.duty = (other.duty + line.duty).min(1.0);
    }
    lines
}

/// Standard errors by which the power of a band must exceed that share: the band of a wandering line has a thousand
/// ordinates of noise, whose floor is known to a few per cent, and there are five other axes.
const SHARED_ERRORS: f64 = 4.0;

/// Returns for each line whether another axis shows it too, which means motion. On an axis of the same unit from a
/// tenth of the amplitude on, on one of another unit if it stands out of the noise.
pub(crate) fn shared(
    recording: &Recording,
    other: &ErrorInBlocks,
    lines: &[Line],
    same_unit: bool,
) -> Vec<bool> {
    let slow = slow_blocks(recording, other.blocks.known());
    let series = Series::new(recording, &slow, &other.error);
    let Some(periodogram) = Periodogram::of(&series) else { return vec![false; lines.len()] };
    let is_shared = |line: &Line| {
        let bin = |hz: f64| (hz / periodogram.resolution_hz) as usize;
        let band = bin(line.band_hz.0)..(bin(line.band_hz.1) + 1).min(periodogram.power.len());
        if same_unit {
            let certain =
                periodogram.power_over_floor(&band) - SHARED_ERRORS * periodogram.noise_deviation(&band);
            periodogram.square_of_amplitude(certain) > SHARED * line.amplitude * line.amplitude
        } else {
            periodogram.stands_out(&band)
        }
    };
    lines.iter().map(is_shared).collect()
}
