//! Careless writers as controls: `xtask write in-place FROM TO`, `xtask write hasty TO`.

use std::error::Error;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use super::writer::Writer;

/// File that they write.
pub(crate) const TARGET: &str = "in_place";

/// A writer that overwrites a file in place with the content of another.
pub(crate) fn in_place(from: &Path) -> Result<Writer, Box<dyn Error>> {
    let from = from.to_str().ok_or("a folder whose name is no text")?;
    Ok(Writer::new(
        "in place",
        &std::env::current_exe()?,
        &["write", "in-place", from, TARGET],
        vec![TARGET.to_owned()],
        [0, 0],
    ))
}

/// Runs a careless writer.
pub(crate) fn write(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    match arguments {
        // In pieces with pauses, so that a kill can interrupt it.
        ["in-place", from, to] => {
            let (content, mut file) = (fs::read(from)?, File::create(to)?);
            for piece in content.chunks(content.len() / 64 + 1) {
                file.write_all(piece)?;
                file.sync_all()?;
            }
            Ok(())
        }
        // Atomic rename, but without a sync before it.
        ["hasty", to] => {
            fs::write(".fos-hasty.tmp", "new")?;
            Ok(fs::rename(".fos-hasty.tmp", to)?)
        }
        _ => Err("no such writer".into()),
    }
}
