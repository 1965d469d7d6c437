//! Built-in example: three logs of one device, with effects hidden in two of them.

use std::path::Path;

use super::axis::Axis;
use super::case::simulate_case;
use super::effect::Effect;
use super::plan::{CasePlan, PlanError};
use super::plant::Plant;
use super::setup::Setup;
use fos_data::recording::{LoadOptions, Recording, RecordingError, load};

/// Axis with the hidden effects.
pub const HIDDEN_IN: &str = "gx_rads";

/// Hidden effects with their sizes as matched filters in the noise: clear, and easily overlooked.
const HIDDEN: [(Effect, f64); 2] = [(Effect::ThermalLag, 120.0), (Effect::SupplySensitivity, 40.0)];

#[derive(Debug, thiserror::Error)]
pub enum DemoCaseError {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// Simulates three logs of a phone-class device on a desk, writes them to `folder` and reads them: `reference.parquet`,
/// `log.parquet` with effects hidden in [`HIDDEN_IN`], and `evaluation.parquet` with the same effects.
pub fn hidden_effects(folder: &Path, seed: u64) -> Result<[Recording; 3], DemoCaseError> {
    let mut plan = CasePlan::new(seed, "bmi270", Setup::Desk, Axis::Gx);
    plan.planted = HIDDEN.into_iter().map(|(effect, size)| Plant { effect, parameter: None, size }).collect();
    let case = simulate_case(&plan)?;
    case.write_logs(folder)?;
    let read = |name: &str| load(folder.join(name), &LoadOptions::default());
    Ok([read("reference.parquet")?, read("log.parquet")?, read("evaluation.parquet")?])
}
