//! What can be planted.

use serde::{Deserialize, Serialize};

use super::effect::Effect;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    pub effect: Effect,
    /// Its parameter (`Effect::description` says which); drawn if `None`. For a fault of the data it decides the size.
    pub parameter: Option<f64>,
    /// Size d in the true coloured noise of the field; strength.rs says what that is for each kind.
    pub size: f64,
}
