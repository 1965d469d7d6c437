//! The header of a `FOSR` log: what its records hold. `predictor_log.rs` reads it.

/// Bytes of a record before its values.
pub(super) const RECORD_LENGTH: usize = 8;

/// What the records of a log hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PredictorLogHeader {
    /// Measured values of a record.
    pub n_axes: u8,
    /// Logged quantities of a record.
    pub n_quantities: u8,
}

impl PredictorLogHeader {
    /// The first four bytes of a log.
    pub const MAGIC: &'static str = "FOSR";

    /// The version that this crate writes, and the only one it reads.
    pub const VERSION: u16 = 1;

    /// Bytes before the first record.
    pub const LENGTH: usize = 8;

    /// The bytes that a log begins with.
    pub fn encode(&self) -> [u8; Self::LENGTH] {
        let fields =
            Self::MAGIC.bytes().chain(Self::VERSION.to_le_bytes()).chain([self.n_axes, self.n_quantities]);
        let mut header = [0; Self::LENGTH];
        for (byte, field) in header.iter_mut().zip(fields) {
            *byte = field;
        }
        header
    }

    /// Bytes of a record.
    pub fn record_length(&self) -> usize {
        RECORD_LENGTH + 4 * (usize::from(self.n_axes) + usize::from(self.n_quantities))
    }
}
