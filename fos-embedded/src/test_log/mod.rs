//! Logs for test firmware: host and device must compute the same output from a log, bit for bit.
//!
//! A log is a little-endian file: a header with magic, version and layout of the records, then one record of fixed length
//! per sample. A record is decoded without a heap and processed by a hub or predictor, and the output enters a digest
//! (CRC-64/XZ) that two machines can compare. There are two kinds, for the two levels at which a device is tested:
//!
//! | magic | record | processed by | digest |
//! |---|---|---|---|
//! | `FOSH` | [`HubLogRecord`]: raw codes, faults, a clock | a [`Hub`](crate::hub::Hub) | [`HubDigest`] |
//! | `FOSR` | [`PredictorLogRecord`]: values in their units | a [`Predictor`](fos_core::Predictor) | [`PredictorDigest`] |
//!
//! `fos replay` writes both from any recording, with `--hub-log` and `--device-log`.

mod digest;
mod fields;
mod hub_log;
mod predictor_header;
mod predictor_log;

pub use digest::{HubDigest, PredictorDigest};
pub use fields::TestLogError;
pub use hub_log::{HubLogHeader, HubLogRecord};
pub use predictor_header::PredictorLogHeader;
pub use predictor_log::PredictorLogRecord;
