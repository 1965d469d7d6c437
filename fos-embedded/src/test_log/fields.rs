//! Sequential reading of the fields of headers and records, and its errors.

use core::fmt;

/// Reason why a log cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TestLogError {
    /// The log ends within its header or within a record.
    Truncated {
        /// Length of the header or record, bytes.
        needed: usize,
        /// Available bytes.
        found: usize,
    },
    /// The log does not start with this magic: not a log of this kind.
    Magic(&'static str),
    /// Unknown version of the log.
    UnknownVersion {
        /// Version of the log.
        found: u16,
        /// Version that this program reads.
        read: u16,
    },
    /// The field of this name has an invalid value.
    Field(&'static str),
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
        }
    }
}

impl core::error::Error for TestLogError {}

/// Unread fields of a header or record.
pub(super) struct Fields<'a> {
    rest: &'a [u8],
    needed: usize,
    found: usize,
}

impl<'a> Fields<'a> {
    /// Fields of a header or record of `needed` bytes; more bytes may follow.
    pub(super) fn of(bytes: &'a [u8], needed: usize) -> Self {
        Self { rest: bytes, needed, found: bytes.len() }
    }

    /// Fields of a header after its magic and version, which must match.
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

    /// Reads the codes of axes x, y, z.
    pub(super) fn codes(&mut self) -> Result<[i16; 3], TestLogError> {
        Ok([self.code()?, self.code()?, self.code()?])
    }

    /// Fills `values`.
    pub(super) fn values(&mut self, values: &mut [f32]) -> Result<(), TestLogError> {
        for value in values {
            *value = self.f32()?;
        }
        Ok(())
    }
}

/// The values as little-endian bytes.
pub(super) fn bytes_of(values: &[f32]) -> impl Iterator<Item = u8> + '_ {
    values.iter().flat_map(|value| value.to_le_bytes())
}
