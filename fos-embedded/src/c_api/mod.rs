//! The hub for C: `include/fos.h` with its comments is generated from this module.
//!
//! All arguments are checked before use: NULL, alignment, length, valid numbers. Two conditions cannot be checked: a pointer
//! must point to the stated object, and a hub must not be in two calls at once. The head of the header demands both, and
//! they make every function here `unsafe`. Names are those of C, so that one search finds both sides.
#![allow(unsafe_code, reason = "C passes pointers")]
#![allow(clippy::missing_safety_doc, reason = "the head of the header states it for all functions")]
#![allow(non_camel_case_types, reason = "the names of the header")]

mod convert;
mod flash;
mod hub;
mod panic;
mod place;
mod status;
mod store;
mod streams;
mod telemetry;
mod unit;
mod values;

pub use flash::fos_flash;
pub use hub::*;
pub use status::*;
pub use store::*;
pub use streams::*;
pub use telemetry::*;
pub use unit::*;
pub use values::*;
