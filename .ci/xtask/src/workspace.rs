//! The workspace around this program.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Output of a command; an error if it failed.
pub(crate) fn output(command: &mut Command) -> Result<String, Box<dyn Error>> {
    let done = command.output()?;
    if !done.status.success() {
        return Err(format!("{command:?}: {}", String::from_utf8_lossy(&done.stderr).trim()).into());
    }
    Ok(String::from_utf8(done.stdout)?)
}

/// Root of the workspace in the current folder.
pub(crate) fn root() -> Result<PathBuf, Box<dyn Error>> {
    let manifest =
        output(Command::new("cargo").args(["locate-project", "--workspace", "--message-format", "plain"]))?;
    Ok(Path::new(manifest.trim()).parent().ok_or("no workspace")?.to_path_buf())
}
