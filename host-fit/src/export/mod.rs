//! A model as source code for a device: Rust and C, with the test vector that proves it runs there as here.

mod c_source;
mod error;
mod refusal;
mod rust_source;
mod test_vector;

pub use c_source::c_source;
pub use error::ExportError;
pub use fos_fit::export::{UnusableImage, current, description, image, version};
pub use refusal::Refusal;
pub use rust_source::rust_source;
pub use test_vector::{OwnedTestVector, Room, Unnoticed, test_vector};
