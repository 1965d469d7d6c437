//! `export`: from a study to what the device takes.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::OutputFile;
use super::output::{Failure, Written, print_written};
use crate::export::{c_source, image, rust_source};
use fos_data::file::write_atomically;
use fos_diagnose::study::Study;

/// Write the model of a study as an image, as Rust source, as a C header
///
/// Both sources come with a test vector: raw samples, and the bits that the device must make of them. Its `check` runs
/// them at start-up. Rust source needs fos-core, its check fos-embedded; the header needs fos.h.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit export unit.json --image unit.fosm --rust model.rs --c model.h")]
pub(super) struct Export {
    /// The study
    study: PathBuf,
    /// The image to write
    #[arg(long, value_name = "FILE")]
    image: Option<OutputFile>,
    /// The Rust source to write
    #[arg(long, value_name = "FILE")]
    rust: Option<OutputFile>,
    /// The C header to write; everything in it is named after it: model.h has model_image, model_check
    #[arg(long, value_name = "FILE")]
    c: Option<OutputFile>,
    /// Name of the sensor, stored in the image
    #[arg(long, default_value = "")]
    sensor: String,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Export {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.image.is_none() && self.rust.is_none() && self.c.is_none() {
            return Err("nothing to write\nhelp: give --image FILE, --rust FILE, --c FILE, or several".into());
        }
        let study = Study::read(&self.study)?;
        let provenance = study.provenance();
        let mut written = Vec::new();
        let mut note = |path: &Path, what: String| {
            written.push(Written { path: path.display().to_string(), what });
        };
        if let Some(path) = &self.image {
            let bytes = image(&study.model, &self.sensor, &provenance)?;
            write_atomically(path, &bytes)?;
            note(path, format!("{} bytes, {} terms", bytes.len(), study.model.n_terms()));
        }
        if let Some(path) = &self.rust {
            write_atomically(path, rust_source(&study.model, &provenance).as_bytes())?;
            note(path, format!("Rust source, {} terms", study.model.n_terms()));
        }
        if let Some(path) = &self.c {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let source = c_source(&study.model, &name, &self.sensor, &provenance)?;
            write_atomically(path, source.as_bytes())?;
            note(path, format!("C header, {} terms", study.model.n_terms()));
        }
        print_written(&written, self.json)
    }
}
