//! A fitted model in the forms that leave the host. The rounding to f32 happens here, once.
//!
//! Both forms of source come with the same test vector: samples, and the bits that the device must make of them.

mod c_source;
mod description;
mod image;
mod rust_source;
mod test_vector;

pub use c_source::c_source;
pub use description::description;
pub use image::{ExportError, image};
pub use rust_source::rust_source;
pub use test_vector::{OwnedTestVector, Unnoticed, test_vector};
