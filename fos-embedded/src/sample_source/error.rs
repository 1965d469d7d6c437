//! Why a sensor gives no samples.

use core::fmt;

/// Why a sensor gives no samples. Every one may pass: go on polling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SourceError<E> {
    /// The bus, with the same transfer repeated.
    Bus(E),
    /// Something answers, but it is another part: what it says that it is.
    WrongPart(u8),
    /// A register does not keep what was written to it.
    NotKept {
        /// Its address, as in the data sheet.
        register: u8,
        /// What was written at set-up.
        written: u16,
        /// What it reads instead.
        read: u16,
    },
    /// The part reports a fatal error of its own.
    Fatal,
    /// It has failed too often; it is left alone for so many polls, this one included.
    Resting(u8),
}

impl<E> SourceError<E> {
    /// For a log, which may not know the bus.
    pub(super) fn without_bus(&self) -> SourceError<()> {
        match *self {
            Self::Bus(_) => SourceError::Bus(()),
            Self::WrongPart(id) => SourceError::WrongPart(id),
            Self::NotKept { register, written, read } => SourceError::NotKept { register, written, read },
            Self::Fatal => SourceError::Fatal,
            Self::Resting(polls) => SourceError::Resting(polls),
        }
    }
}

impl<E: fmt::Debug> fmt::Display for SourceError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus: {error:?}"),
            Self::WrongPart(id) => write!(f, "another part: its identity is {id:#04x}"),
            Self::NotKept { register, written, read } => {
                write!(f, "register {register:#04x} reads {read:#06x} after {written:#06x} was written")
            }
            Self::Fatal => write!(f, "the part reports a fatal error"),
            Self::Resting(polls) => write!(f, "left alone for {polls} polls"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for SourceError<E> {}
