//! Header of a `FOSR` log: the layout of its records. `predictor_log.rs` reads it.

/// Length of a record without its values, bytes.
pub(super) const RECORD_LENGTH: usize = 8;

/// Header of a log: the layout of its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PredictorLogHeader {
    /// Number of measured values per record.
    pub n_axes: u8,
    /// Number of logged quantities per record.
    pub n_quantities: u8,
}

impl PredictorLogHeader {
    /// The first four bytes of a log.
    pub const MAGIC: &'static str = "FOSR";

    /// Version of the log that this crate writes; it reads no other.
    pub const VERSION: u16 = 1;

    /// Length of the header, bytes.
    pub const LENGTH: usize = 8;

    /// Bytes of the header.
    pub fn encode(&self) -> [u8; Self::LENGTH] {
        let fields =
            Self::MAGIC.bytes().chain(Self::VERSION.to_le_bytes()).chain([self.n_axes, self.n_quantities]);
        let mut header = [0; Self::LENGTH];
        for (byte, field) in header.iter_mut().zip(fields) {
            *byte = field;
        }
        header
    }

    /// Length of a record, bytes.
    pub fn record_length(&self) -> usize {
        RECORD_LENGTH + 4 * (usize::from(self.n_axes) + usize::from(self.n_quantities))
    }
}
