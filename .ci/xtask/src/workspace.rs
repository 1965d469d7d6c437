//! Packages of a workspace, from cargo.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A package of the workspace.
pub(crate) struct Package {
    /// Name in its manifest.
    pub(crate) name: String,
    /// Folder of its manifest.
    pub(crate) folder: PathBuf,
    /// Compiled targets, except tests and build scripts.
    pub(crate) targets: Vec<Target>,
    /// Dependencies of any kind.
    pub(crate) dependencies: Vec<Dependency>,
}

/// One compilation: a library, a program, an example or a benchmark.
pub(crate) struct Target {
    /// Other packages can depend on it.
    pub(crate) is_library: bool,
    /// Root source file.
    pub(crate) root: PathBuf,
}

/// A dependency in a manifest.
pub(crate) struct Dependency {
    /// Name of the package.
    pub(crate) package: String,
    /// Name in the source, with underscores.
    pub(crate) name: String,
    /// Not only for tests or build scripts.
    pub(crate) is_normal: bool,
}

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

/// Packages of the workspace.
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>, Box<dyn Error>> {
    let arguments = ["metadata", "--format-version", "1", "--no-deps"];
    packages_of(&serde_json::from_str(&output(Command::new("cargo").args(arguments).current_dir(root))?)?)
}

/// Packages in the output of `cargo metadata`.
pub(crate) fn packages_of(metadata: &Value) -> Result<Vec<Package>, Box<dyn Error>> {
    let missing = |what: &str| format!("cargo metadata gives no {what}");
    let text = |value: &Value, key: &str| value[key].as_str().map(str::to_owned).ok_or_else(|| missing(key));
    let list = |value: &Value, key: &str| value[key].as_array().cloned().ok_or_else(|| missing(key));
    let mut packages = Vec::new();
    for package in list(metadata, "packages")? {
        let mut targets = Vec::new();
        for target in list(&package, "targets")? {
            let kinds = list(&target, "kind")?;
            let is =
                |names: &[&str]| kinds.iter().any(|kind| names.contains(&kind.as_str().unwrap_or_default()));
            if !is(&["test", "custom-build"]) {
                targets.push(Target {
                    is_library: !is(&["bin", "example", "bench"]),
                    root: text(&target, "src_path")?.into(),
                });
            }
        }
        let mut dependencies = Vec::new();
        for dependency in list(&package, "dependencies")? {
            let name = text(&dependency, "name")?;
            dependencies.push(Dependency {
                name: dependency["rename"].as_str().unwrap_or(&name).replace('-', "_"),
                package: name,
                is_normal: dependency["kind"].is_null(),
            });
        }
        let manifest = PathBuf::from(text(&package, "manifest_path")?);
        let folder = manifest.parent().ok_or_else(|| missing("folder"))?.to_path_buf();
        packages.push(Package { name: text(&package, "name")?, folder, targets, dependencies });
    }
    Ok(packages)
}
