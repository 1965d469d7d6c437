//! Reasons why a sensor gives no samples.

use core::fmt;

/// Reason why a sensor gives no samples. Each may be temporary: continue polling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SourceError<E> {
    /// The bus failed, also when the transfer was repeated.
    Bus(E),
    /// Another part answers; holds its identity.
    WrongPart(u8),
    /// A register does not hold the value written to it.
    VerifyFailed {
        /// Address of the register in the data sheet.
        register: u8,
        /// Value written at the set-up.
        written: u16,
        /// Value read.
        read: u16,
    },
    /// The part reports an internal fatal error.
    Fatal,
    /// The sensor failed repeatedly and rests; holds the remaining polls without access, this one included.
    Resting(u8),
}

impl<E> SourceError<E> {
    /// The error without that of the bus, which may not implement `defmt::Format`.
    pub(super) fn without_bus(&self) -> SourceError<()> {
        match *self {
            Self::Bus(_) => SourceError::Bus(()),
            Self::WrongPart(id) => SourceError::WrongPart(id),
            Self::VerifyFailed { register, written, read } => {
                SourceError::VerifyFailed { register, written, read }
            }
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
            Self::VerifyFailed { register, written, read } => {
                write!(f, "register {register:#04x} reads {read:#06x} after {written:#06x} was written")
            }
            Self::Fatal => write!(f, "the part reports a fatal error"),
            Self::Resting(polls) => write!(f, "left alone for {polls} polls"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for SourceError<E> {}
