//! Content of a certificate: the result, its conditions and its limits.

use fos_calibrate::{Calibration, Gravity, GravitySource, RestResidual, Shown, Turntable, shown};
use fos_data::recording::Recording;
use fos_data::text::capitalised;
use serde::Serialize;

/// Name and version of the schema of the JSON form.
pub const SCHEMA: &str = "fos-certificate/1";

/// Statements about a device that no log contains.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Stated {
    /// Name or number of the device.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// The part, as its maker calls it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Date of the log; logs seldom state it, and it is never guessed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
}

/// A log that was calibrated from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Log {
    /// Name or path, as the user stated it.
    pub path: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

/// The result: by hand, on a turntable, or both.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// From hand-turned orientations.
    Hand(Box<Calibration>),
    /// From plateaus of a turntable.
    Turntable(Box<Turntable>),
}

/// The content of a certificate.
#[derive(Debug, Clone, Serialize)]
pub struct Certificate {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Program and version.
    pub tool: String,
    /// Statements of the user.
    #[serde(flatten)]
    pub stated: Stated,
    /// The logs, in their order.
    pub logs: Vec<Log>,
    /// Duration of all logs, s.
    pub duration_s: f64,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// The calibration.
    pub result: Outcome,
}

impl Certificate {
    /// The certificate of a calibration from this recording.
    pub fn of(stated: Stated, recording: &Recording, result: Outcome) -> Self {
        let logs = recording.sources.iter();
        Self {
            schema: SCHEMA,
            tool: format!("fos {}", env!("CARGO_PKG_VERSION")),
            stated,
            logs: logs.map(|one| Log { path: one.path.clone(), sha256: one.sha256.clone() }).collect(),
            duration_s: recording.duration_s(),
            rate_hz: recording.rate.true_hz,
            result,
        }
    }

    /// The method in one sentence.
    pub(super) fn method(&self) -> String {
        match &self.result {
            Outcome::Hand(found) => {
                let gyro = found.gyro.as_ref().is_some_and(|gyro| gyro.matrix.is_some());
                format!(
                    "{} rests in {} orientations; accelerometer by least squares on |a| = g{}; intervals of 95 % with {:.0} degrees of freedom",
                    found.accelerometer.used().count(),
                    found.accelerometer.orientations,
                    if gyro { ", gyro by integration from rest to rest" } else { "" },
                    found.accelerometer.degrees_of_freedom
                )
            }
            Outcome::Turntable(found) => {
                let rates: Vec<String> =
                    found.rates_rads.iter().map(|rate| format!("{:.3} °/s", rate.to_degrees())).collect();
                format!(
                    "{} plateaus on a turntable at {}; least squares on the magnitude of the rate; intervals of 95 % with {:.0} degrees of freedom",
                    found.plateaus.iter().filter(|one| !one.excluded).count(),
                    rates.join(" and "),
                    found.degrees_of_freedom
                )
            }
        }
    }

    /// Conditions, a name and a value each.
    pub(super) fn conditions(&self) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        let mut add = |name: &str, value: String| rows.push((name.to_owned(), value));
        let stated =
            [("device", &self.stated.device), ("part", &self.stated.part), ("date", &self.stated.date)];
        for (name, value) in stated {
            if let Some(value) = value {
                add(name, value.clone());
            }
        }
        add("method", self.method());
        if let Outcome::Hand(found) = &self.result {
            add("gravity", gravity(&found.accelerometer.gravity));
            if let Some([low, high]) = found.accelerometer.temperature_c {
                let at = found.accelerometer.model.reference_c;
                add("temperature", format!("{low:.1} to {high:.1} °C; values hold at {at:.1} °C"));
            } else {
                add("temperature", "not logged".to_owned());
            }
        }
        add("log", format!("{:.1} s at {:.2} Hz", self.duration_s, self.rate_hz));
        for log in &self.logs {
            add("file", log.path.clone());
            add("SHA-256", log.sha256.clone());
        }
        rows
    }

    /// Parameters as people read them.
    pub(super) fn parameters(&self) -> Vec<Shown> {
        let all: Vec<_> = match &self.result {
            Outcome::Hand(found) => {
                let gyro = found.gyro.iter().flat_map(|gyro| gyro.parameters.iter().chain(&gyro.derived));
                found.accelerometer.parameters.iter().chain(gyro).collect()
            }
            Outcome::Turntable(found) => found.parameters.iter().collect(),
        };
        all.into_iter().map(|parameter| shown(parameter, true)).collect()
    }

    /// The rests with their residuals.
    pub(super) fn rests(&self) -> &[RestResidual] {
        match &self.result {
            Outcome::Hand(found) => &found.accelerometer.rests,
            Outcome::Turntable(_) => &[],
        }
    }

    /// Limits of the result, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut all = Vec::new();
        match &self.result {
            Outcome::Hand(found) => {
                if let Some(share) = found.accelerometer.gravity.unknown_share() {
                    all.push(format!(
                        "Gravity was assumed: on Earth it differs by up to {:.2} %, by which all three accelerometer sensitivities would be wrong alike. Latitude and height remove this.",
                        100.0 * share
                    ));
                }
                all.extend(found.cautions(true).iter().map(|caution| format!("{}.", capitalised(caution))));
                all.push("Angles and cross-axis refer to the sensor itself; the rotation of the sensor in its housing is not part of it.".to_owned());
            }
            Outcome::Turntable(_) => all.push(
                "An error of the turntable's rate is an error of all three sensitivities and not part of the intervals.".to_owned(),
            ),
        }
        all
    }
}

/// Gravity and its origin, as `9.80601 m/s², WGS84 at 45.40°, 12 m`.
pub fn gravity(gravity: &Gravity) -> String {
    match gravity.source {
        GravitySource::Assumed => format!("{:.5} m/s², assumed", gravity.mps2),
        GravitySource::Place { latitude_deg, height_m } => {
            format!("{:.5} m/s², WGS84 at latitude {latitude_deg}°, height {height_m} m", gravity.mps2)
        }
        GravitySource::Stated => format!("{:.5} m/s², stated", gravity.mps2),
    }
}
