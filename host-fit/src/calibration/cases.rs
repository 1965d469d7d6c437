//! Which cases are simulated.

use serde::Serialize;

use fos_simulate::Disturbance;

/// The cases to simulate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cases {
    /// Seed of all of them.
    pub seed: u64,
    /// How many, or of how many those that suit the world.
    pub count: usize,
    /// What disturbs their logs.
    pub world: Disturbance,
    /// Whether the axes in which nothing was hidden are asked too, of logs in which nothing is missing.
    pub every_axis: bool,
}
