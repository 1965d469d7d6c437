//! An effect to be planted.

use serde::{Deserialize, Serialize};

use super::effect::Effect;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    pub effect: Effect,
    /// Parameter named in `Effect::description`; drawn if `None`. For a fault of the data it determines the size.
    pub parameter: Option<f64>,
    /// Size d in the true coloured noise of the log to explain; strength.rs defines it for each kind.
    pub size: f64,
}
