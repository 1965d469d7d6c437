//! The device side.
//!
//! - [`hub`]: six axes over shared inputs: what an application calls.
//! - [`raw`]: raw codes of a sensor, and what they mean.
//! - [`store`]: model images in flash, two slots, the newest valid one wins.
//! - [`telemetry`]: samples and what the model made of them, as frames over any byte stream.
//! - `c_api`: the same for C, behind the feature `c-api`; its manual is `include/fos.h`.
//! - [`replay`]: a recorded log as firmware reads it, run through a predictor, with a digest of what came out.
#![no_std]
#![deny(unsafe_code)]

// on a host a C program takes the panic handler of std; on the device it is `c_api::panic`
#[cfg(any(test, all(feature = "c-api", not(target_os = "none"))))]
extern crate std;

#[cfg(feature = "c-api")]
pub mod c_api;
pub mod hub;
pub mod raw;
pub mod replay;
pub mod store;
mod stuffing;
pub mod telemetry;
