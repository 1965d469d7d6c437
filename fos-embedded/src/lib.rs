//! The device side.
//!
//! - [`sample_source`]: complete samples from two real parts, and what went wrong on the way.
//! - [`hub`]: six axes over shared inputs: what an application calls.
//! - [`hub_log`]: raw samples as firmware reads them from a file, through a hub, with a digest of what came out.
//! - [`raw`]: raw codes of a sensor, and what they mean.
//! - [`store`]: model images in flash, two slots, the newest valid one wins.
//! - [`telemetry`]: samples and what the model made of them, as frames over any byte stream.
//! - [`blocking`]: blocking buses, delays and flash under all of this.
//! - `c_api`: the same for C, behind the feature `c-api`; its manual is `include/fos.h`.
//! - [`replay`]: a recorded log as firmware reads it, run through a predictor, with a digest of what came out.
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
pub mod hub_log;
pub mod raw;
pub mod replay;
pub mod sample_source;
pub mod store;
mod stuffing;
pub mod telemetry;
pub mod test_vector;
