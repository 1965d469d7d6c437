//! Reading logs of every format.

mod candidates;
mod damaged_formats;
mod format_page;
mod formats;
mod provenance;
