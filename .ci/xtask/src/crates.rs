//! Allowed dependencies between crates.
//!
//! ```text
//! fos-core ◄ fos-embedded      fos-core ◄ fos-data ◄ fos-fit ◄ fos-diagnose ◄ fos-fleet ◄ fos-report ◄ fos-workbench ◄ host-fit
//! fos-data ◄ fos-simulate, fos-calibrate ◄ fos-figures      fos-fit ◄ fos-export, fos-device-io      fos-diagnose ◄ fos-figures ◄ fos-report, fos-imu
//! ```
//!
//! Only dependencies compiled for users of a crate count: tests may depend on all.

use std::error::Error;
use std::path::Path;
use std::process::Command;

use crate::workspace::{Package, output};

/// Crates of the engine from which the program and the Python package are built.
const ENGINE: &[&str] =
    &["fos-core", "fos-data", "fos-fit", "fos-calibrate", "fos-diagnose", "fos-fleet", "fos-simulate"];

/// Crates with their allowed dependencies in the workspace, as lists. Crates under `tests/` may depend on all and are not listed.
const MAY: &[(&str, &[&[&str]])] = &[
    ("fos-core", &[]),
    ("fos-embedded", &[&["fos-core"]]),
    ("fos-data", &[&["fos-core"]]),
    ("fos-fit", &[&["fos-core", "fos-data"]]),
    ("fos-calibrate", &[&["fos-data"]]),
    ("fos-diagnose", &[&["fos-core", "fos-data", "fos-fit"]]),
    ("fos-fleet", &[&["fos-core", "fos-data", "fos-fit", "fos-diagnose"]]),
    ("fos-simulate", &[&["fos-core", "fos-data"]]),
    ("fos-export", &[&["fos-core", "fos-embedded", "fos-data", "fos-fit"]]),
    ("fos-device-io", &[&["fos-core", "fos-embedded", "fos-data", "fos-fit"]]),
    ("fos-figures", &[&["fos-data", "fos-fit", "fos-calibrate", "fos-diagnose"]]),
    (
        "fos-report",
        &[&["fos-core", "fos-data", "fos-fit", "fos-calibrate", "fos-diagnose", "fos-fleet", "fos-figures"]],
    ),
    ("fos-workbench", &[ENGINE, &["fos-export", "fos-device-io", "fos-figures", "fos-report"]]),
    (
        "host-fit",
        &[
            ENGINE,
            &["fos-embedded", "fos-export", "fos-device-io", "fos-figures", "fos-report", "fos-workbench"],
        ],
    ),
    ("fos-imu", &[ENGINE, &["fos-figures"]]),
    ("xtask", &[]),
];

/// Crates of the program and the Python package; the others are the engine, which a user may link without them.
const PROGRAM: [&str; 6] =
    ["fos-device-io", "fos-figures", "fos-imu", "fos-report", "fos-workbench", "host-fit"];

/// Libraries for the program only: servers, figures, command lines.
const OF_THE_PROGRAM: [&str; 4] = ["axum", "clap", "plotters", "tokio"];

/// Forbidden dependencies, a line for each.
pub(crate) fn refused(packages: &[Package], root: &Path) -> Vec<String> {
    let is_outside = |package: &Package| package.folder.starts_with(root.join("tests"));
    let mut found = Vec::new();
    for package in packages.iter().filter(|package| !is_outside(package)) {
        let Some((_, may)) = MAY.iter().find(|(name, _)| *name == package.name) else {
            found.push(format!("{}: has no place among the crates of .ci/xtask/src/crates.rs", package.name));
            continue;
        };
        let normal = package.dependencies.iter().filter(|dependency| dependency.is_normal);
        for dependency in
            normal.filter(|dependency| packages.iter().any(|other| other.name == dependency.package))
        {
            if !may.concat().contains(&dependency.package.as_str()) {
                found.push(format!("{} must not depend on {}", package.name, dependency.package));
            }
        }
    }
    found
}

/// Crates of the engine that depend on a library for the program only, a line for each.
pub(crate) fn heavy(packages: &[Package], root: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let mut found = Vec::new();
    for package in packages {
        if PROGRAM.contains(&package.name.as_str()) || package.folder.starts_with(root.join("tests")) {
            continue;
        }
        let tree = [
            "tree",
            "--edges",
            "normal",
            "--target",
            "all",
            "--all-features",
            "--prefix",
            "none",
            "--format",
            "{p}",
        ];
        let printed =
            output(Command::new("cargo").args(tree).args(["--package", &package.name]).current_dir(root))?;
        found.extend(
            named(&printed).map(|name| format!("{} must not depend on {name}, by any way", package.name)),
        );
    }
    Ok(found)
}

/// Libraries for the program in a tree printed by cargo.
fn named(tree: &str) -> impl Iterator<Item = &'static str> {
    OF_THE_PROGRAM
        .into_iter()
        .filter(move |name| tree.lines().any(|line| line.split(' ').next() == Some(name)))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::workspace::packages_of;

    fn package(name: &str, folder: &str, dependencies: &[(&str, Value)]) -> Value {
        let dependencies: Vec<Value> = dependencies
            .iter()
            .map(|(name, kind)| json!({"name": name, "rename": null, "kind": kind}))
            .collect();
        json!({"name": name, "manifest_path": format!("/work/{folder}/Cargo.toml"), "targets": [], "dependencies": dependencies})
    }

    fn refused_of(packages: &[Value]) -> Vec<String> {
        refused(&packages_of(&json!({"packages": packages})).unwrap(), Path::new("/work"))
    }

    #[test]
    fn accepts_dependencies_to_the_left() {
        let packages = [
            package("fos-core", "fos-core", &[]),
            package("fos-data", "host-fit/data", &[("fos-core", Value::Null), ("serde", Value::Null)]),
            package(
                "fos-simulate",
                "host-fit/simulate",
                &[("fos-data", Value::Null), ("fos-fit", json!("dev"))],
            ),
            package("fos-fit", "host-fit/fit", &[("fos-data", Value::Null)]),
            package("host-fit", "host-fit", &[("fos-simulate", Value::Null), ("fos-core", Value::Null)]),
            package("fos-testkit", "tests", &[("host-fit", Value::Null)]),
        ];
        assert_eq!(refused_of(&packages), [""; 0]);
    }

    #[test]
    fn rejects_dependencies_to_the_right() {
        let packages = [
            package("fos-core", "fos-core", &[]),
            package("fos-fit", "host-fit/fit", &[("fos-core", Value::Null), ("fos-embedded", Value::Null)]),
            package("fos-embedded", "fos-embedded", &[("fos-core", Value::Null)]),
            package("fos-simulate", "host-fit/simulate", &[("fos-fit", Value::Null)]),
            package("fos-testkit", "tests", &[]),
            package("host-fit", "host-fit", &[("fos-testkit", Value::Null)]),
            package("fos-more", "fos-more", &[]),
        ];
        assert_eq!(
            refused_of(&packages),
            [
                "fos-fit must not depend on fos-embedded",
                "fos-simulate must not depend on fos-fit",
                "host-fit must not depend on fos-testkit",
                "fos-more: has no place among the crates of .ci/xtask/src/crates.rs",
            ]
        );
    }

    #[test]
    fn finds_program_libraries_by_whole_name() {
        assert_eq!(named("fos-fit v0.1.0\ntokio v1.54.0\nclap_lex v1.0.0\n").collect::<Vec<_>>(), ["tokio"]);
    }
}
