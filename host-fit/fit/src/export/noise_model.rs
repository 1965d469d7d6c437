//! One noise level for the three axes of a sensor, as in the files of other stacks.

use super::filter_comment::filter_comment;
use super::noise_unit::NoiseUnits;
use super::real::real;
use crate::noise::{AxisNoise, Level};
use fos_data::column::{ACCELEROMETERS, GYROS};

/// Noise of an accelerometer and a gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Name of the log.
    pub log: String,
    /// Measured sampling rate, Hz.
    pub rate_hz: f64,
    /// Noise of the accelerometers.
    pub accel: TriadNoise,
    pub gyro: TriadNoise,
    /// Comment lines with the discrete noise of a Kalman filter of every axis.
    pub filter: String,
}

/// Noise of three axes, at each level that of the noisiest axis. A filter given too small a noise value becomes
/// overconfident and diverges; with too large a value it only converges more slowly.
#[derive(Debug, Clone, PartialEq)]
pub struct TriadNoise {
    pub white: Worst,
    /// Random walk K.
    pub walk: Worst,
}

/// Largest value of three axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Worst {
    /// Value, or the upper limit if none was detected.
    pub value: f64,
    /// Remark for a comment.
    pub about: String,
}

#[derive(Debug, thiserror::Error)]
pub enum NoiseModelError {
    #[error(
        "{column} is missing: such a file has the noise of three accelerometers and three gyros\nhelp: ask all six axes of a log that has them"
    )]
    Missing { column: &'static str },
}

impl NoiseModel {
    /// Combines the axes of a log.
    pub fn of(log: &str, rate_hz: f64, axes: &[AxisNoise]) -> Result<Self, NoiseModelError> {
        let of = |columns: [&'static str; 3]| -> Result<TriadNoise, NoiseModelError> {
            let mut three = Vec::new();
            for column in columns {
                let axis = axes.iter().find(|axis| axis.column == column);
                three.push(axis.ok_or(NoiseModelError::Missing { column })?);
            }
            let units = NoiseUnits::of(&three[0].unit);
            Ok(TriadNoise {
                white: worst(&three, &units.white, |axis| axis.levels.white),
                walk: worst(&three, &units.walk, |axis| axis.levels.walk),
            })
        };
        Ok(Self {
            log: log.to_owned(),
            rate_hz,
            accel: of(ACCELEROMETERS)?,
            gyro: of(GYROS)?,
            filter: filter_comment(axes),
        })
    }
}

fn worst(three: &[&AxisNoise], unit: &str, level: impl Fn(&AxisNoise) -> Level) -> Worst {
    // a detected value takes precedence over a limit, which only shows how short the log was
    let seen = |axis: &&AxisNoise| level(axis).value.is_some();
    let any_seen = three.iter().any(seen);
    let most = three
        .iter()
        .filter(|axis| !any_seen || seen(axis))
        .max_by(|a, b| level(a).at_most().total_cmp(&level(b).at_most()))
        .expect("there are three");
    let Level { low, high, .. } = level(most);
    let drift = most.thermal_drift.map_or("", |_| "; its drift with temperature is removed");
    let about = match low {
        Some(low) => format!("{unit}, {}, 90 % in {low:.3e} .. {high:.3e}{drift}", most.column),
        None => {
            format!(
                "{unit}, not seen in any axis: the limit that the log sets (95 %), {}{drift}",
                most.column
            )
        }
    };
    Worst { value: level(most).at_most(), about }
}

impl Worst {
    /// Formats the value as a line of YAML with the key of its reader.
    pub(super) fn line(&self, key: &str) -> String {
        yaml_line(key, self.value, &self.about)
    }
}

/// Formats a line of YAML: a number, with a remark as a comment.
pub(super) fn yaml_line(key: &str, value: f64, about: &str) -> String {
    format!("{key}: {}  # {about}\n", real(value))
}
