//! Guidance during a recording: what to record next, and for how long.

use clap::ValueEnum;

use super::noise::duration;
use super::units::three;
use fos_calibrate::{CalibrateError, Imu, Options, calibrate};
use fos_data::interrupt::in_parallel;
use fos_data::recording::{LoadOptions, Recording, RecordingError, Source};
use fos_data::stillness;
use fos_data::text::counted;
use fos_data::unit::MG_MPS2;
use fos_device_io::record::Recorded;
use fos_fit::noise::{AxisNoise, axis_noise};

/// Purpose of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Guide {
    /// The orientation to lay the device down in next, for `calibrate-imu`
    Calibration,
    /// The time at rest that is missing, for `noise`
    Noise,
}

impl Guide {
    /// States in a line what the log so far lacks.
    pub(super) fn line(self, recorded: &Recorded) -> String {
        let line = log_of(recorded).map(|log| match self {
            Self::Calibration => orientation(&log),
            Self::Noise => time_at_rest(&log),
        });
        let line = line.unwrap_or_else(|error| error.to_string());
        line.replace("\nhelp: ", "; ")
    }
}

fn log_of(recorded: &Recorded) -> Result<Recording, RecordingError> {
    Recording::from_columns(Source::made_by("a recording"), recorded.columns.clone(), &LoadOptions::default())
}

fn orientation(log: &Recording) -> String {
    let found = Imu::of(log).and_then(|imu| calibrate(&imu, &Options::default()));
    match found {
        Ok(found) => {
            let accelerometer = &found.accelerometer;
            let [now, then] = accelerometer.next.worst_mps2.map(|size| three(size / MG_MPS2));
            format!(
                "{} in {} orientations: within ± {now} mg at 1 g; next: {}, 3 s, to ± {then} mg",
                counted(accelerometer.used().count(), "rest"),
                accelerometer.orientations,
                accelerometer.next.instruction
            )
        }
        Err(CalibrateError::OneOrientation { rests, next, .. }) => {
            format!("{} in one orientation; next: {next}", counted(rests, "rest"))
        }
        Err(CalibrateError::NoRedundancy { orientations, more, next, .. }) => {
            format!("{orientations} orientations, {more} more are needed at least; next: {next}")
        }
        Err(error) => error.to_string(),
    }
}

fn time_at_rest(log: &Recording) -> String {
    let still = stillness::find(log);
    let axes = log.axes().unwrap_or_default();
    let found = in_parallel(&axes, |axis| axis_noise(log, &still, axis));
    let found: Vec<AxisNoise> = match found.into_iter().collect() {
        Ok(found) => found,
        Err(error) => return error.to_string(),
    };
    let seconds = found.iter().map(|axis| axis.seconds).fold(f64::INFINITY, f64::min);
    let at_rest = format!("{} at rest", duration(seconds));
    let missing = found.iter().filter_map(|axis| {
        let until = axis.levels.walk_within_20_percent_s.or(axis.walk_needs_s)?;
        (until > axis.seconds).then_some((until - axis.seconds, axis))
    });
    match missing.max_by(|(one, _), (other, _)| one.total_cmp(other)) {
        None => format!("{at_rest}: enough, K of every axis that has one is within ± 20 %"),
        Some((more, axis)) if axis.levels.walk_within_20_percent_s.is_some() => {
            format!("{at_rest}: about {} more for K of {} within ± 20 %", duration(more), axis.column)
        }
        Some((more, axis)) => format!(
            "{at_rest}: no K of {} seen yet; {} more would halve its limit",
            axis.column,
            duration(more)
        ),
    }
}
