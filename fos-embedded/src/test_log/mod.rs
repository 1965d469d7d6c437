//! Logs for test firmware: host and device must compute the same output from a log, bit for bit.
//!
//! A log is a little-endian file: a header with magic, version and layout of the records, then one record of fixed length
//! per sample, [`HubLogRecord`]: raw codes, faults, a clock. Its layout is fixed so that a C program reads it without a
//! library, as `c/replay.c` does. A record is decoded without a heap and processed by a [`Hub`](crate::hub::Hub), and the
//! output enters a digest (CRC-64/XZ), [`HubDigest`], that two machines can compare. [`PredictorDigest`] is the same for
//! a firmware without a hub.
//!
//! `fos replay --hub-log` writes a log from any recording, and prints its digest.

mod digest;
mod fields;
mod hub_log;

pub use digest::{HubDigest, PredictorDigest};
pub use fields::TestLogError;
pub use hub_log::{HubLogHeader, HubLogRecord};
