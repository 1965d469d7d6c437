//! Writers without precautions: `xtask write in-place FROM TO`, `xtask write hasty TO`.

use std::error::Error;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use super::writer::Writer;

/// What they write to.
pub(crate) const TARGET: &str = "in_place";

/// One that writes what is in a file.
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

/// What they do.
pub(crate) fn write(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    match arguments {
        // in pieces; a disk takes its time, so that a kill has something to hit
        ["in-place", from, to] => {
            let (content, mut file) = (fs::read(from)?, File::create(to)?);
            for piece in content.chunks(content.len() / 64 + 1) {
                file.write_all(piece)?;
                file.sync_all()?;
            }
            Ok(())
        }
        // beside and renamed, but nothing is put onto the disk before the file has its name
        ["hasty", to] => {
            fs::write(".fos-hasty.tmp", "new")?;
            Ok(fs::rename(".fos-hasty.tmp", to)?)
        }
        _ => Err("no such writer".into()),
    }
}
