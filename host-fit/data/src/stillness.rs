//! Detects stretches of a recording at rest, for logs that do not state them.

use crate::column::ACCELEROMETERS;
use crate::column::GYROS;
use std::ops::Range;

use fos_core::{StillnessDetector, StillnessLimits};

use crate::disturbance;
use crate::pose;
pub use crate::recording::{KnownBy, Stillness};
use crate::recording::{Recording, RecordingError};
use crate::statistics::{mean, median_of, variance};

/// Length of a window, s.
const WINDOW_S: f64 = 0.5;

/// Limit of the ratio of a window's variance to that of the quietest tenth of all windows: three times the noise. A
/// window of 100 samples and three axes scatters by 8 %, so noise alone never reaches it.
const VARIANCE_RATIO: f64 = 9.0;

/// Share of the rows from which on the detector is right without further evidence. Below it, motion must be detected too:
/// an interpolated or low-passed log has windows almost without noise, against which all others look like motion.
const MIN_DETECTED: f64 = 0.5;

/// Largest share of detected motion in a log that the detector wrongly takes for moving.
const MAX_MOTION: f64 = 0.1;

impl Stillness {
    /// Rejects a log in which less than half a minute of `rows` is at rest because the device moves all along.
    pub fn check_rest(&self, recording: &Recording, rows: &Range<usize>) -> Result<(), RecordingError> {
        disturbance::check_rest(recording, &self.disturbances, &self.still, rows)
    }
}

/// Finds the rows at rest: by the column `still`, else by the detector, else all of them; without detected motion in any
/// case.
pub fn find(recording: &Recording) -> Stillness {
    find_apart(recording, 0)
}

/// The same for fitting on the first `learnt_rows` rows: later rows have no influence on which of them are at rest.
/// Without such rows, as in a log that nothing was fitted to, all rows count alike.
pub fn find_apart(recording: &Recording, learnt_rows: usize) -> Stillness {
    let n = recording.n_rows();
    let learnt_rows = if (1..n).contains(&learnt_rows) { learnt_rows } else { n };
    let found =
        recording.detected.stillness.get_or_find(learnt_rows, || find_uncached(recording, learnt_rows));
    Stillness::clone(&found)
}

fn find_uncached(recording: &Recording, learnt_rows: usize) -> Stillness {
    let learnt = 0..learnt_rows;
    let parts = [learnt.clone(), learnt.end..recording.n_rows()];
    let limits = limits(recording, &learnt);
    let detected = || detect(recording, limits?, &parts);
    let (mut still, known_by) = match &recording.still {
        Some(still) => (still.clone(), KnownBy::Column),
        None => match detected() {
            Some(still) if is_refuted(recording, &still, &learnt) => {
                (vec![true; recording.n_rows()], KnownBy::NoMotion)
            }
            Some(still) => (still, KnownBy::Detector),
            None => (vec![true; recording.n_rows()], KnownBy::Assumed),
        },
    };
    let mut disturbances = Vec::new();
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        if part.len() == still.len() && known_by != KnownBy::Detector {
            disturbances = disturbance::find_at_rest(recording);
            continue;
        }
        let mut rest = vec![false; still.len()];
        rest[part.clone()].copy_from_slice(&still[part]);
        disturbances.extend(disturbance::find(recording, &rest));
    }
    disturbance::exclude(&mut still, &disturbances);
    let turns = pose::turns(recording, &still, &disturbance::tilted(&disturbances));
    Stillness {
        still,
        known_by,
        disturbances,
        turns,
        limits: limits.filter(|_| matches!(known_by, KnownBy::Column | KnownBy::Detector)),
    }
}

/// Returns true if the detector finds less than half of the `learnt` rows `still`, and hardly any motion is detected there.
fn is_refuted(recording: &Recording, still: &[bool], learnt: &Range<usize>) -> bool {
    let detected = still[learnt.clone()].iter().filter(|still| **still).count() as f64;
    if detected >= MIN_DETECTED * learnt.len() as f64 || !disturbance::is_detectable(recording) {
        return false;
    }
    let found = match learnt.len() < recording.n_rows() {
        true => disturbance::find_at_rest(&recording.first_rows(learnt.end)),
        false => disturbance::find_at_rest(recording),
    };
    let moved: usize = found.iter().filter(|one| one.is_excluded()).map(|one| one.rows.len()).sum();
    (moved as f64) < MAX_MOTION * learnt.len() as f64
}

fn triad<'a>(recording: &'a Recording, names: [&str; 3]) -> Option<[&'a [f64]; 3]> {
    let column = |name| recording.channel(name).ok().map(|channel| channel.values.as_slice());
    Some([column(names[0])?, column(names[1])?, column(names[2])?])
}

fn detect(recording: &Recording, limits: StillnessLimits<f64>, parts: &[Range<usize>]) -> Option<Vec<bool>> {
    let (accel, gyro) = (triad(recording, ACCELEROMETERS)?, triad(recording, GYROS)?);
    let mut detector = StillnessDetector::new(limits).ok()?;
    let mut still = vec![false; recording.n_rows()];
    for segment in &recording.segments {
        detector.disturbed();
        for row in segment.rows.clone() {
            still[row] = detector.update(accel.map(|axis| axis[row]), gyro.map(|axis| axis[row]));
        }
        for part in parts {
            let rows = segment.rows.start.max(part.start)..segment.rows.end.min(part.end);
            if !rows.is_empty() {
                back_date(&mut still[rows], usize::from(limits.window));
            }
        }
    }
    Some(still)
}

/// Moves the transitions back in time: the detector reports stillness after two quiet windows, the second of which is
/// known to have been still (the first is excluded as a margin), and motion up to a window after its begin.
fn back_date(still: &mut [bool], window: usize) {
    let turns = |still: &[bool], from: bool| -> Vec<usize> {
        (1..still.len()).filter(|&row| still[row - 1] == from && still[row] != from).collect()
    };
    for start in turns(still, false) {
        still[start.saturating_sub(window)..start].fill(true);
    }
    for end in turns(still, true) {
        still[end.saturating_sub(window)..end].fill(false);
    }
}

/// Largest drift of a gyro's bias within a log, rad/s: 2.9 °/s. Of 32 real parts nine in ten drift by less than 0.02 °/s
/// per kelvin. Without this limit, whatever turns slowly all along counts as at rest.
const MAX_DRIFT_RADS: f64 = 0.05;

/// Limits from the quietest windows among `rows`.
pub fn limits(recording: &Recording, rows: &Range<usize>) -> Option<StillnessLimits<f64>> {
    let (accel, gyro) = (triad(recording, ACCELEROMETERS)?, triad(recording, GYROS)?);
    let window = ((WINDOW_S / recording.rate.period_s).round() as usize).clamp(10, usize::from(u16::MAX));
    let windows: Vec<Window> = recording
        .segments
        .iter()
        .flat_map(|segment| {
            let (start, end) = (segment.rows.start.max(rows.start), segment.rows.end.min(rows.end));
            (start..end).step_by(window).filter(|start| start + window <= end).collect::<Vec<_>>()
        })
        .filter_map(|start| Window::of(&accel, &gyro, start..start + window))
        .collect();
    let accel_variance = VARIANCE_RATIO * low_quantile(windows.iter().map(|w| w.accel_variance).collect())?;
    let gyro_variance = VARIANCE_RATIO * low_quantile(windows.iter().map(|w| w.gyro_variance).collect())?;
    let quiet: Vec<&Window> = windows
        .iter()
        .filter(|w| w.accel_variance <= accel_variance && w.gyro_variance <= gyro_variance)
        .collect();
    let gyro_at_rest =
        [0, 1, 2].map(|axis| median_of(quiet.iter().map(|w| w.gyro_mean[axis])).unwrap_or(0.0));
    let distance =
        |w: &&Window| (0..3).map(|axis| (w.gyro_mean[axis] - gyro_at_rest[axis]).powi(2)).sum::<f64>().sqrt();
    // half of the quiet windows are closer than the median; a drifting bias goes some times further
    let spread = median_of(quiet.iter().map(distance)).unwrap_or(0.0);
    let limits = StillnessLimits {
        window: window as u16,
        accel_variance,
        gyro_variance,
        gyro_at_rest,
        gyro_deviation: (10.0 * spread).min(MAX_DRIFT_RADS) + gyro_variance.sqrt(),
    };
    StillnessDetector::<f64>::new(limits).ok().map(|_| limits)
}

struct Window {
    accel_variance: f64,
    gyro_variance: f64,
    gyro_mean: [f64; 3],
}

impl Window {
    /// `None` if a value is missing or a triad does not change at all.
    fn of(accel: &[&[f64]; 3], gyro: &[&[f64]; 3], rows: Range<usize>) -> Option<Self> {
        let moments = |axis: &[f64]| {
            let stretch = &axis[rows.clone()];
            (mean(&[stretch]), variance(&[stretch]))
        };
        let (accel, gyro) = (accel.map(moments), gyro.map(moments));
        let window = Self {
            accel_variance: accel.iter().map(|(_, variance)| variance).sum(),
            gyro_variance: gyro.iter().map(|(_, variance)| variance).sum(),
            gyro_mean: gyro.map(|(mean, _)| mean),
        };
        (window.accel_variance > 0.0 && window.gyro_variance > 0.0).then_some(window)
    }
}

fn low_quantile(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 10).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::AXES;
    use crate::recording::{LoadOptions, Source};
    use fos_testkit::noise::white_noise;

    /// Without a learnt row there were no limits, and the motion of the second minute counted as rest.
    #[test]
    fn log_that_nothing_was_fitted_to_is_searched_as_a_whole() {
        let rows = 12_000;
        let axis = |(seed, name): (u64, &str)| {
            let moves = |row: usize| if row < rows / 2 { 0.0 } else { (row as f64 / 7.0).sin() };
            let noise = white_noise(seed, rows);
            let values = noise.iter().enumerate().map(|(row, noise)| 1e-3 * noise + moves(row)).collect();
            (name.to_owned(), values)
        };
        let columns = (0..).zip(AXES).map(axis).collect();
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        let log = Recording::from_columns(Source::made_by("test"), columns, &options).expect("a log");
        let found = find_apart(&log, 0);
        assert_eq!(found, find(&log));
        let at_rest = found.still.iter().filter(|still| **still).count();
        assert_eq!(found.known_by, KnownBy::Detector);
        assert!((5_500..6_100).contains(&at_rest), "{at_rest}");
    }
}
