//! Common parts of the checks of docs/trust.md: their two forms, and the program under test.

use std::env;
use std::error::Error;
use std::path::{Path, PathBuf, absolute};
use std::process::Command;

/// Extent of a check.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// Seconds; runs in the gate.
    Short,
    /// Minutes; as documented.
    Full,
}

impl Form {
    pub(crate) fn name(self) -> &'static str {
        if self == Form::Full { "full" } else { "short" }
    }
}

/// Target folder of cargo.
pub(crate) fn target_folder(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(folder))
}

/// The program as shipped: `$FOS_HOST_FIT`, otherwise built here.
pub(crate) fn host_fit(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    if let Some(given) = env::var_os("FOS_HOST_FIT").filter(|given| !given.is_empty()) {
        return Ok(absolute(given)?);
    }
    let built = target_folder(root).join("release/fos");
    if !built.exists()
        && !Command::new("cargo").args(["build", "--release", "-p", "host-fit"]).status()?.success()
    {
        return Err("fos cannot be built".into());
    }
    Ok(built)
}
