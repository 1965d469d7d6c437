//! `meta.json` of a case: the metadata known to the user.

use super::axis::Axis;
use super::part::Part;
use super::plan::CasePlan;
use fos_data::case::{CaseFiles, CaseMeta, DataSheetFigures, SCHEMA};

/// Metadata of a plan, without the planted effects.
pub(super) fn meta(plan: &CasePlan, part: &Part) -> CaseMeta {
    CaseMeta {
        schema: SCHEMA.to_owned(),
        case: "case".to_owned(),
        target: plan.target.column().to_owned(),
        device: format!("{}-like", part.name),
        setup: plan.setup.words().to_owned(),
        nominal_rate_hz: plan.nominal_rate_hz(),
        accel_full_scale_mps2: Some(part.full_scale(Axis::Ax)),
        gyro_full_scale_rads: Some(part.full_scale(Axis::Gx)),
        accel_lsb_mps2: Some(part.lsb(Axis::Ax)),
        gyro_lsb_rads: Some(part.lsb(Axis::Gx)),
        datasheet: DataSheetFigures {
            gyro_noise_density_dps_rthz: Some(part.gyro_noise_density_dps_rthz),
            accel_noise_density_ug_rthz: Some(part.accel_noise_density_ug_rthz),
            gyro_bias_instability_dph: Some(part.gyro_bias_instability_dph),
            accel_bias_instability_ug: Some(part.accel_bias_instability_ug),
            gyro_tco_dps_per_k: Some(part.gyro_tco_dps_per_k),
            accel_tco_mg_per_k: Some(part.accel_tco_mg_per_k),
        },
        files: CaseFiles {
            baseline: Some("reference".to_owned()),
            field: Some("log".to_owned()),
            eval: Some("evaluation".to_owned()),
        },
        note: "reference: steady conditions, no effect missing. log: explain its target column. evaluation: apply the final model, fit nothing.".to_owned(),
    }
}
