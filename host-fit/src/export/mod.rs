//! A fitted model in the forms that leave the host. The rounding to f32 happens here, once.

mod image;
mod rust_source;

pub use image::{ExportError, image};
pub use rust_source::rust_source;
