#![doc = include_str!("../README.md")]
//!
//! # What is here
//!
//! - [`sample_source`]: complete samples from a six-axis sensor, and what went wrong on the way; two real parts
//!   behind the features `bmi323` and `lsm6dsv16x`.
//! - [`hub`]: six axes over shared inputs: what an application calls.
//! - [`raw`]: raw codes of a sensor, and what they mean.
//! - [`streams`]: samples of gyros, accelerometers and a thermometer that have stamps of their own, as of a phone.
//! - `store`: model images in flash, two slots, the newest valid one wins; behind the feature `store`.
//! - [`telemetry`]: samples and what the model made of them, as frames over any byte stream.
//! - [`blocking`]: blocking buses, delays and flash under all of this.
//! - `c_api`: the same for C, behind the feature `c-api`; its manual is `include/fos.h`.
//! - `test_log`: logs as test firmware reads them, with digests of what came out, behind the feature `test-log`.
//! - [`test_vector`]: known samples, and the bits that a hub must make of them.
#![no_std]
#![deny(unsafe_code)]

// on a host a C program takes the panic handler of std; on the device it is `c_api::panic`
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
