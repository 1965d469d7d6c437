//! The certificate of a calibration: one page as plain data; [`html`] and [`markdown`] only render it.
//!
//! | file | subject |
//! |---|---|
//! | `content` | result, conditions and limits |
//! | `picture` | residual of each rest as points of a small figure |
//! | `render` | HTML and Markdown |

mod content;
mod picture;
mod render;

pub use content::{Certificate, Log, Outcome, SCHEMA, Stated, gravity};
pub use picture::Picture;
pub use render::{html, json, markdown, of_form};
