//! `cargo xtask supply short|full`: checks everything that enters the build: licences, duplicates, sources and
//! advisories (deny.toml, by cargo-deny), the crates of the device side, the Rust version.
//!
//! cargo-deny takes minutes to build. `short` runs it if it is installed; otherwise no crate may have been added since
//! its last run (`.ci/judged`). `full` installs it into cargo's target folder, writes `.ci/judged`, also checks
//! advisories, and builds with exactly the minimum Rust version.

mod controls;
mod deny;
mod device;
mod findings;
mod judged;
mod rust_version;

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::form::Form;
use crate::workspace::output;
use findings::Findings;

/// Prints the dependencies; an error if one is not allowed.
pub(crate) fn run(form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    let metadata = Command::new("cargo")
        .args(["metadata", "--all-features", "--format-version", "1", "--locked"])
        .output()?;
    if !metadata.status.success() {
        return Err(String::from_utf8_lossy(&metadata.stderr).trim().into());
    }
    let metadata: Value = serde_json::from_slice(&metadata.stdout)?;
    let packages = metadata["packages"].as_array().ok_or("cargo metadata gives no packages")?;

    let mut findings = Findings::default();
    findings.report.push(counts(root)?);
    deny::look(&mut findings, form, root)?;
    device::look(&mut findings, packages)?;
    rust_version::look(&mut findings, packages, form, root)?;
    if !findings.problems.is_empty() {
        return Err(findings.problems.join("\n").into());
    }
    println!("`cargo xtask supply {}`\n\n{}", form.name(), findings.report.join("\n\n"));
    println!(
        "\nNegative controls: {}. Each was refused, and nothing else was.",
        findings.controls.join(", ")
    );
    Ok(())
}

/// Number of crates.
fn counts(root: &Path) -> Result<String, Box<dyn Error>> {
    let deny = fs::read_to_string(root.join("deny.toml"))?;
    let entries = |with: &str| {
        deny.lines().filter(|line| line.trim().starts_with("{ crate = ") && line.contains(with)).count()
    };
    Ok(format!(
        "The build contains {} third-party crates, {} with tests (all features and targets), the fuzz targets {}. `deny.toml` \
         (licences, duplicates, sources) has {} exceptions for licences and {} for second versions, each with its reason.",
        from_outside(root, "normal,build")?,
        from_outside(root, "normal,build,dev")?,
        from_outside(&root.join("fuzz"), "normal,build")?,
        entries("allow = "),
        entries("reason = ")
    ))
}

/// Third-party crates reached by these edges, on every target.
fn from_outside(workspace: &Path, edges: &str) -> Result<usize, Box<dyn Error>> {
    let tree = [
        "tree",
        "--workspace",
        "--all-features",
        "--target",
        "all",
        "--prefix",
        "none",
        "--no-dedupe",
        "--format",
        "{p}",
    ];
    let printed = output(Command::new("cargo").args(tree).args(["--edges", edges]).current_dir(workspace))?;
    // Local packages have their folder after the version.
    let of_others = printed
        .lines()
        .map(|line| line.trim_end_matches(" (proc-macro)"))
        .filter(|line| !line.is_empty() && !line.contains('('));
    Ok(of_others.collect::<BTreeSet<_>>().len())
}
