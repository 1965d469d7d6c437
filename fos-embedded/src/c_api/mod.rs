//! The hub for C: `include/fos.h` is generated from here, and its comments are these.
//!
//! Whatever C hands over is checked before anything is done with it: NULL, alignment, length, numbers that stand for
//! something. What cannot be checked is what the head of the header asks of its reader, and what makes every function
//! here `unsafe`: that a pointer leads to what it says, and that one hub is not in two calls at once. Names are those
//! of C, so that one search finds both sides.
#![allow(unsafe_code, reason = "C hands over pointers")]
#![allow(clippy::missing_safety_doc, reason = "the head of the header says it once for all")]
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
