//! A model on its way to a device: the image, and what it says in words.

mod description;
mod earlier;
mod image;

pub use description::description;
pub use earlier::{current, version};
pub use image::{UnusableImage, image};
