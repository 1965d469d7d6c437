//! Atomic writes: files are written to a temporary sibling and renamed, so that a reader sees the complete old or new
//! file even if the writer is killed or the power fails. Inputs are never replaced.

mod error;
mod inputs;
mod paths;
mod read;
mod replace;

pub mod compare_and_swap;
pub mod keyed_rows;

pub use error::FileError;
pub use inputs::{is_same_file, protect};
pub use paths::{folder_of, followed, name_of, sync_folder};
pub use read::{open, open_to_seek, read, read_up_to, standard_input};
pub use replace::{TemporarySibling, check_output, make_folder, replace, write_atomically};
