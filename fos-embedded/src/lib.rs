#![doc = include_str!("../README.md")]
//!
//! # Contents
//!
//! - [`sample_source`]: complete samples from a six-axis sensor, with fault handling; drivers for four parts behind the
//!   features `bmi323`, `icm42688`, `lsm6dso` and `lsm6dsv16x`.
//! - [`hub`]: six axes over shared inputs, the interface for an application.
//! - [`raw`]: raw codes of a sensor and their scales.
//! - [`streams`]: resampling of gyros, accelerometers and thermometer with separate timestamps, as in a phone.
//! - `store`: model images in flash, two slots, the newest valid one wins; behind the feature `store`.
//! - [`telemetry`]: samples and corrections as frames over any byte stream.
//! - [`blocking`]: adapter for blocking buses, delays and flash.
//! - `c_api`: the same for C, behind the feature `c-api`; its manual is `include/fos.h`.
//! - `test_log`: logs for test firmware, with digests of the output, behind the feature `test-log`.
//! - [`test_vector`]: known samples with the bits that a hub must compute from them.
#![no_std]
#![deny(unsafe_code)]

// on a host a C program uses the panic handler of std; on the device, that of `c_api::panic`
#[cfg(any(test, all(feature = "c-api", not(target_os = "none"))))]
extern crate std;

#[macro_use]
mod log;

pub mod blocking;
#[cfg(feature = "c-api")]
pub mod c_api;
pub mod hub;
pub mod raw;
pub mod sample_source;
#[cfg(feature = "store")]
pub mod store;
pub mod streams;
mod stuffing;
pub mod telemetry;
#[cfg(feature = "test-log")]
pub mod test_log;
pub mod test_vector;
