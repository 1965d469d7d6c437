//! One measured quantity.

use std::sync::Arc;

use crate::column::Column;
use crate::unit::Unit;

/// One measured quantity, a value per row of its recording.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Name, with the unit as its last part where it is known: `gx_rads`, `temp_c`.
    pub name: String,
    pub unit: Unit,
    /// One value per row, in `unit`; NaN if the cell is empty or not finite. Shared among derived recordings.
    pub values: Arc<Vec<f64>>,
}

impl Channel {
    pub fn column(&self) -> Column<'_> {
        Column::named(&self.name)
    }

    /// Number of missing values (NaN).
    pub fn n_missing(&self) -> usize {
        self.values.iter().filter(|value| value.is_nan()).count()
    }
}
