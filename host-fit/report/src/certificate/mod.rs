//! The certificate of a calibration: one page as plain data; [`html`] and [`markdown`] only render it.
//!
//! | file | subject |
//! |---|---|
//! | `content` | result, conditions and limits |
//! | `shown` | numbers in the units of data sheets, with as many digits as the interval allows |
//! | `picture` | residual of each rest as points of a small figure |
//! | `render` | HTML and Markdown |

mod content;
mod picture;
mod render;
mod shown;

pub use content::{Certificate, Log, Outcome, SCHEMA, Stated, gravity};
pub use picture::Picture;
pub use render::{html, json, markdown, of_form};
pub use shown::{Shown, exclusion, shown, with_interval};
