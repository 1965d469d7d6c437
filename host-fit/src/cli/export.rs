//! `export`: from a study to what the device takes.

use std::path::PathBuf;

use clap::Args;

use super::output::Failure;
use crate::export::{image, rust_source};
use crate::file::write_atomically;
use crate::study::Study;

/// Write the model of a study as an image, as Rust source, or both
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit export unit.json --image unit.fosm --rust model.rs")]
pub(super) struct Export {
    /// The study
    study: PathBuf,
    /// The image to write
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// The Rust source to write
    #[arg(long, value_name = "FILE")]
    rust: Option<PathBuf>,
    /// Name of the sensor, stored in the image
    #[arg(long, default_value = "")]
    sensor: String,
}

impl Export {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.image.is_none() && self.rust.is_none() {
            return Err("nothing to write\nhelp: give --image FILE, --rust FILE, or both".into());
        }
        let study = Study::read(&self.study)?;
        let provenance = study.provenance();
        if let Some(path) = &self.image {
            let bytes = image(&study.model, &self.sensor, &provenance)?;
            write_atomically(path, &bytes)?;
            println!("{}: {} bytes, {} terms", path.display(), bytes.len(), study.model.n_terms());
        }
        if let Some(path) = &self.rust {
            write_atomically(path, rust_source(&study.model, &provenance).as_bytes())?;
            println!("{}: Rust source, {} terms", path.display(), study.model.n_terms());
        }
        Ok(())
    }
}
