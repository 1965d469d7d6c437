//! Which logged quantities the sensor gives, which the application.

use fos_core::Quantity;

/// Where a logged quantity of the model comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum QuantitySource {
    Thermometer,
    /// One of the six, as measured.
    Measured(u8),
    /// What the application gives, or NaN until it does.
    Application(Quantity),
}

impl QuantitySource {
    pub(super) fn is_application(&self) -> bool {
        matches!(self, Self::Application(_))
    }
}

/// Whether a logged quantity is the application's to give; the others the sensor itself measures.
pub const fn is_given(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::Temperature | Quantity::Measured(_))
}
