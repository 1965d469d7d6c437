//! Minimum supported Rust version.

use std::error::Error;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::controls::scratch;
use super::findings::Findings;
use crate::form::{Form, target_folder};
use crate::workspace::output;

type Version = (u32, u32);

fn version(text: &str) -> Option<Version> {
    let mut parts = text.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next().unwrap_or(Some(0))?))
}

/// Packages that need a newer Rust version.
fn too_new(packages: &[Value], promised: Version) -> Vec<String> {
    let newer = |package: &&Value| package["rust_version"].as_str().and_then(version) > Some(promised);
    packages
        .iter()
        .filter(newer)
        .map(|package| format!("{} {}: {}", package["name"], package["version"], package["rust_version"]))
        .collect()
}

pub(crate) fn look(
    findings: &mut Findings,
    packages: &[Value],
    form: Form,
    root: &Path,
) -> Result<(), Box<dyn Error>> {
    let ours = packages.iter().find(|package| package["name"] == "fos-core").ok_or("no fos-core")?;
    let promised =
        ours["rust_version"].as_str().and_then(version).ok_or("fos-core states no Rust version")?;
    findings.problems.extend(too_new(packages, promised));
    let newer = serde_json::json!({"name": "newer", "version": "1.0.0", "rust_version": format!("1.{}", promised.1 + 1)});
    if too_new(&[newer], promised).is_empty() {
        findings.problems.push("a crate that requires a newer Rust is not detected".into());
    }
    findings.controls.push("a crate that requires a newer Rust");
    let built = build_with(promised, form, root)?;
    findings
        .report
        .push(format!("Rust {}.{}: no crate requires a newer version. {built}", promised.0, promised.1));
    Ok(())
}

/// Builds everything with exactly this version and describes the result.
fn build_with(promised: Version, form: Form, root: &Path) -> Result<String, Box<dyn Error>> {
    let name = format!("{}.{}", promised.0, promised.1);
    let installed = output(Command::new("rustup").args(["toolchain", "list"])).unwrap_or_default();
    let exact = installed
        .lines()
        .filter_map(|line| line.split(' ').next())
        .find(|line| line.starts_with(&format!("{name}.")));
    if let (Form::Full, Some(exact)) = (form, exact) {
        let with = |folder: &Path| {
            let mut command = Command::new("rustup");
            command.args(["run", exact, "cargo", "check"]).env("CARGO_INCREMENTAL", "0").current_dir(folder);
            command
        };
        // In a separate folder, so that no other artefacts are reused.
        let target = target_folder(root).join(format!("rust-{name}"));
        output(with(root).args(["--workspace", "--all-targets", "--locked", "--target-dir"]).arg(target))?;
        let folder = tempfile::tempdir()?;
        let later = format!("{}.{}", promised.0, promised.1 + 1);
        let newer = scratch(folder.path(), "", &[])?;
        let manifest = std::fs::read_to_string(newer.join("Cargo.toml"))?;
        std::fs::write(
            newer.join("Cargo.toml"),
            manifest.replace("publish", &format!("rust-version = \"{later}\"\npublish")),
        )?;
        if with(&newer).output()?.status.success() {
            return Err(format!("{exact} accepts a crate that requires {later}").into());
        }
        return Ok(format!(
            "`cargo +{exact} check --workspace --all-targets --locked` passes; a crate that requires {later} is refused."
        ));
    }
    let in_use = output(Command::new("rustc").arg("--version"))?;
    let in_use = in_use.split(' ').nth(1).unwrap_or_default();
    Ok(match form {
        _ if in_use.starts_with(&format!("{name}.")) => {
            format!("The compiler of this run is {in_use}, so everything else here is built with it.")
        }
        Form::Full => {
            format!("skipped: a build with {name} (toolchain not installed; in use: {in_use})")
        }
        Form::Short => format!("The compiler of this run is {in_use}; `full` builds with {name}."),
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn versions_are_compared_as_numbers() {
        use super::version;
        assert!(
            version("1.100") > version("1.95.2")
                && version("1.95.0") == version("1.95")
                && version("2") > version("1.95")
        );
        assert_eq!(version("so"), None);
    }
}
