//! The certificate of a calibration: one page as plain data; [`html`] and [`markdown`] only render it.
//!
//! | file | subject |
//! |---|---|
//! | `content` | result, conditions and limits |
//! | `sphere` | orientations on the sphere, those that are there and the next |
//! | `render` | HTML and Markdown |

mod content;
mod render;
mod sphere;

pub use content::{Certificate, Log, Outcome, SCHEMA, Stated, gravity};
pub use render::{html, json, markdown, of_form};
pub use sphere::Sphere;
