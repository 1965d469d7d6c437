//! The packages of a workspace, as cargo sees them.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A package of the workspace.
pub(crate) struct Package {
    /// As in its manifest.
    pub(crate) name: String,
    /// The folder of its manifest.
    pub(crate) folder: PathBuf,
    /// What is compiled of it, but for tests and build scripts.
    pub(crate) targets: Vec<Target>,
    /// What it names in its manifest, of any kind.
    pub(crate) dependencies: Vec<Dependency>,
}

/// One compilation: a library, a program, an example or a benchmark.
pub(crate) struct Target {
    /// Whether others can depend on it.
    pub(crate) is_library: bool,
    /// The file it begins with.
    pub(crate) root: PathBuf,
}

/// What a manifest names.
pub(crate) struct Dependency {
    /// The package.
    pub(crate) package: String,
    /// As the source calls it, with underscores.
    pub(crate) name: String,
    /// Neither for tests nor for build scripts alone.
    pub(crate) is_normal: bool,
}

/// What a command printed; an error if it failed.
pub(crate) fn output(command: &mut Command) -> Result<String, Box<dyn Error>> {
    let done = command.output()?;
    if !done.status.success() {
        return Err(format!("{command:?}: {}", String::from_utf8_lossy(&done.stderr).trim()).into());
    }
    Ok(String::from_utf8(done.stdout)?)
}

/// The folder of the workspace that cargo is in.
pub(crate) fn root() -> Result<PathBuf, Box<dyn Error>> {
    let manifest =
        output(Command::new("cargo").args(["locate-project", "--workspace", "--message-format", "plain"]))?;
    Ok(Path::new(manifest.trim()).parent().ok_or("no workspace")?.to_path_buf())
}

/// Its packages.
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>, Box<dyn Error>> {
    let arguments = ["metadata", "--format-version", "1", "--no-deps"];
    packages_of(&serde_json::from_str(&output(Command::new("cargo").args(arguments).current_dir(root))?)?)
}

/// The packages of what `cargo metadata` prints.
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
