//! Selection of the simulated cases.

use serde::Serialize;

use fos_simulate::Disturbance;

/// Selection of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cases {
    /// Seed of all cases.
    pub seed: u64,
    /// Number of cases; those unsuitable for the world are then omitted.
    pub count: usize,
    /// Disturbance of the logs.
    pub world: Disturbance,
    /// Diagnose all axes of logs without a missing effect.
    pub every_axis: bool,
}
