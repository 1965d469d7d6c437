//! Sources of the logged quantities: the sensor or the application.

use fos_core::Quantity;

/// Source of a logged quantity of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum QuantitySource {
    Thermometer,
    /// Measured value of one of the six axes, by index.
    Measured(u8),
    /// Given by the application; NaN until then.
    Application(Quantity),
}

impl QuantitySource {
    pub(super) fn is_application(&self) -> bool {
        matches!(self, Self::Application(_))
    }
}

/// True if the application must give the quantity; false if the sensor measures it.
pub const fn is_given(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::Temperature | Quantity::Measured(_))
}
