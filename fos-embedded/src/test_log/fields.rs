//! The fields of headers and records, one after the other, and why a log cannot be read.

use core::fmt;

use super::PredictorLogHeader;

/// Why a log cannot be read, or does not fit a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TestLogError {
    /// The log ends within its header or within a record.
    Truncated {
        /// Bytes of the header or record.
        needed: usize,
        /// Bytes that were left.
        found: usize,
    },
    /// It does not start with this magic: not a log of this kind.
    Magic(&'static str),
    /// A version that this program does not read.
    UnknownVersion {
        /// What the log says.
        found: u16,
        /// What this program reads.
        read: u16,
    },
    /// The field of this name has a value that it cannot have.
    Field(&'static str),
    /// The log has other axes or quantities than the model.
    Mismatch {
        /// What the log has.
        log: PredictorLogHeader,
        /// What the model has.
        model: PredictorLogHeader,
    },
}

impl fmt::Display for TestLogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { needed, found } => write!(f, "truncated: {found} of {needed} bytes"),
            Self::Magic(magic) => write!(f, "not such a log: it does not start with {magic}"),
            Self::UnknownVersion { found, read } => {
                write!(f, "log version {found}; this program reads version {read}")
            }
            Self::Field(name) => write!(f, "{name} has a value that it cannot have"),
            Self::Mismatch { log, model } => write!(
                f,
                "the log has {} axes and {} quantities, the model {} and {}",
                log.n_axes, log.n_quantities, model.n_axes, model.n_quantities
            ),
        }
    }
}

impl core::error::Error for TestLogError {}

/// What has not been read yet of a header or record.
pub(super) struct Fields<'a> {
    rest: &'a [u8],
    needed: usize,
    found: usize,
}

impl<'a> Fields<'a> {
    /// Of something of `needed` bytes; more may follow it.
    pub(super) fn of(bytes: &'a [u8], needed: usize) -> Self {
        Self { rest: bytes, needed, found: bytes.len() }
    }

    /// As [`of`](Self::of), after a magic and a version that must be these.
    pub(super) fn of_header(
        log: &'a [u8],
        needed: usize,
        magic: &'static str,
        version: u16,
    ) -> Result<Self, TestLogError> {
        let mut fields = Self::of(log, needed);
        if fields.bytes::<4>()? != magic.as_bytes() {
            return Err(TestLogError::Magic(magic));
        }
        let found = fields.u16()?;
        if found != version {
            return Err(TestLogError::UnknownVersion { found, read: version });
        }
        Ok(fields)
    }

    pub(super) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], TestLogError> {
        let truncated = TestLogError::Truncated { needed: self.needed, found: self.found };
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(truncated)?;
        self.rest = rest;
        Ok(*bytes)
    }

    pub(super) fn u8(&mut self) -> Result<u8, TestLogError> {
        let [byte] = self.bytes()?;
        Ok(byte)
    }

    pub(super) fn u16(&mut self) -> Result<u16, TestLogError> {
        self.bytes().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, TestLogError> {
        self.bytes().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, TestLogError> {
        self.bytes().map(u64::from_le_bytes)
    }

    pub(super) fn f32(&mut self) -> Result<f32, TestLogError> {
        self.bytes().map(f32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64, TestLogError> {
        self.bytes().map(f64::from_le_bytes)
    }

    pub(super) fn code(&mut self) -> Result<i16, TestLogError> {
        self.bytes().map(i16::from_le_bytes)
    }

    /// Axes x, y, z.
    pub(super) fn codes(&mut self) -> Result<[i16; 3], TestLogError> {
        Ok([self.code()?, self.code()?, self.code()?])
    }

    /// As many as `values` has.
    pub(super) fn values(&mut self, values: &mut [f32]) -> Result<(), TestLogError> {
        for value in values {
            *value = self.f32()?;
        }
        Ok(())
    }
}

/// As bytes, in their order.
pub(super) fn bytes_of(values: &[f32]) -> impl Iterator<Item = u8> + '_ {
    values.iter().flat_map(|value| value.to_le_bytes())
}
