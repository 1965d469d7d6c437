//! Formats of logs: the documentation of each, and the rules for recognising it.
//!
//! A file is opened by its content ([`open`](container::open)): a container (gzip, zip, a folder) is searched, a table
//! of text or Parquet is interpreted by the names of its columns (`recognise`, `meaning`), and any other file is
//! recognised by its first bytes. Formats with separate timestamps for every sensor give [`Stream`](super::Stream)s.

mod archive;
mod axivity;
#[cfg(feature = "bag")]
mod bag;
mod betaflight;
mod bytes;
mod choice;
mod container;
#[cfg(feature = "dataflash")]
mod dataflash;
mod dialect;
mod found;
mod geneactiv;
mod gnss_logger;
mod header;
mod identity;
mod known;
#[cfg(feature = "mcap")]
mod mcap_file;
mod meaning;
mod names;
mod opened;
mod recognise;
#[cfg(any(feature = "bag", feature = "mcap"))]
mod ros;
#[cfg(any(feature = "dataflash", feature = "ulog"))]
mod rotation;
mod several;
#[cfg(feature = "ulog")]
mod ulog;
mod unnamed;
mod wearable;
mod xsens;

pub(super) use container::open;
pub(super) use header::is_unit;
pub use identity::{ReadAs, UnknownFormat};
pub use known::{FormatKnowledge, KNOWN_FORMATS, LOG_ENDINGS, may_be_log};
pub(super) use meaning::Meaning;
pub use names::Format;
pub(super) use opened::{Extent, Opened};
pub(super) use recognise::meaning;
