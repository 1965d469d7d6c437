//! Logs as test firmware reads them: what a device does with one, a host must do too, to the last bit.
//!
//! A log is a file, little-endian throughout: a header that begins with a magic, a version and what its records hold,
//! then records of one fixed length up to its end, one a sample. A record is decoded without a heap, takes its step
//! through what it drives, and what comes out goes into a digest (CRC-64/XZ) that two machines can compare. There are
//! two, for the two levels at which a device is tested:
//!
//! | magic | a record is | it drives | digest |
//! |---|---|---|---|
//! | `FOSH` | [`HubLogRecord`]: raw codes, faults, a clock | a [`Hub`](crate::hub::Hub) | [`HubDigest`] |
//! | `FOSR` | [`PredictorLogRecord`]: values in their units | a [`Predictor`](fos_core::Predictor) | [`PredictorDigest`] |
//!
//! `fos replay` writes both of any recording, `--hub-log` and `--device-log`.

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
