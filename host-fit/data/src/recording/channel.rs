//! One measured quantity.

use std::sync::Arc;

use super::unit::Unit;

/// Before the name of an axis: its innovation, from the telemetry of a device.
pub const INNOVATION: &str = "innovation_";
/// Before the name of an axis: what speaks against its corrected value (flags), from the telemetry of a device.
pub const VALIDITY: &str = "validity_";

/// One measured quantity, a value per row of its recording.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Name, with the unit as its last part where it is known: `gx_rads`, `temp_c`.
    pub name: String,
    /// Unit of the values.
    pub unit: Unit,
    /// One value per row, in `unit`. NaN: the cell is empty or not finite.
    /// Shared by the recordings that are made of one another.
    pub values: Arc<Vec<f64>>,
}

impl Channel {
    /// Whether it is what a model on the device made of an axis: no cause of what is left of that.
    pub fn is_of_model(&self) -> bool {
        self.name.starts_with(INNOVATION) || self.name.starts_with(VALIDITY)
    }

    /// How many values are missing (NaN).
    pub fn n_missing(&self) -> usize {
        self.values.iter().filter(|value| value.is_nan()).count()
    }
}
