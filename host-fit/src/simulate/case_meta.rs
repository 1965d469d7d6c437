//! `meta.json` of a case: what the user is told.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::part::Part;
use super::plan::{CasePlan, NOMINAL_RATE_HZ};

/// `meta.json` of a case folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseMeta {
    /// `fos-case/1`.
    #[serde(default)]
    pub schema: String,
    /// Name of the case.
    pub case: String,
    /// Column to be explained.
    pub target: String,
    /// Kind of device.
    #[serde(default)]
    pub device: String,
    /// How it was used, in words.
    #[serde(default)]
    pub setup: String,
    /// Nominal sample rate, Hz.
    pub nominal_rate_hz: f64,
    /// Full scale of the accelerometers, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_full_scale_mps2: Option<f64>,
    /// Full scale of the gyros, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_full_scale_rads: Option<f64>,
    /// Least significant bit of the accelerometers, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_lsb_mps2: Option<f64>,
    /// Least significant bit of the gyros, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_lsb_rads: Option<f64>,
    /// What the data sheet says.
    #[serde(default)]
    pub datasheet: Datasheet,
    /// Names of the logs, without ending.
    pub files: CaseFiles,
    /// What the logs are, in words.
    #[serde(default)]
    pub note: String,
}

/// Figures of a data sheet; any may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Datasheet {
    /// Noise density of the gyros, °/s/√Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_noise_density_dps_rthz: Option<f64>,
    /// Noise density of the accelerometers, µg/√Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_noise_density_ug_rthz: Option<f64>,
    /// Bias instability of the gyros, °/h.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_bias_instability_dph: Option<f64>,
    /// Bias instability of the accelerometers, µg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_bias_instability_ug: Option<f64>,
    /// Temperature coefficient of the gyros, °/s/K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_tco_dps_per_k: Option<f64>,
    /// Temperature coefficient of the accelerometers, mg/K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_tco_mg_per_k: Option<f64>,
}

/// Names of the logs of a case, without ending; up to three.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CaseFiles {
    /// The quiet log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// The log to be explained.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The log to be corrected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eval: Option<String>,
}

/// Tells nothing of what is planted.
pub(super) fn meta(plan: &CasePlan, part: &Part) -> CaseMeta {
    CaseMeta {
        schema: "fos-case/1".to_owned(),
        case: "case".to_owned(),
        target: plan.target.column().to_owned(),
        device: format!("{}-like", part.name),
        setup: plan.setup.words().to_owned(),
        nominal_rate_hz: NOMINAL_RATE_HZ,
        accel_full_scale_mps2: Some(part.full_scale(Axis::Ax)),
        gyro_full_scale_rads: Some(part.full_scale(Axis::Gx)),
        accel_lsb_mps2: Some(part.lsb(Axis::Ax)),
        gyro_lsb_rads: Some(part.lsb(Axis::Gx)),
        datasheet: Datasheet {
            gyro_noise_density_dps_rthz: Some(part.gyro_noise_density_dps_rthz),
            accel_noise_density_ug_rthz: Some(part.accel_noise_density_ug_rthz),
            gyro_bias_instability_dph: Some(part.gyro_bias_instability_dph),
            accel_bias_instability_ug: Some(part.accel_bias_instability_ug),
            gyro_tco_dps_per_k: Some(part.gyro_tco_dps_per_k),
            accel_tco_mg_per_k: Some(part.accel_tco_mg_per_k),
        },
        files: CaseFiles {
            baseline: Some("baseline".to_owned()),
            field: Some("field".to_owned()),
            eval: Some("eval".to_owned()),
        },
        note: "baseline: quiet log of the same unit, nothing missing. field: explain its target channel. eval: apply the final model, nothing to fit.".to_owned(),
    }
}
