//! Crates of the device side: reviewed one by one, with their enabled features.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use proc_macro2::{TokenStream, TokenTree};
use serde_json::Value;

use super::findings::Findings;
use crate::workspace::output;

const REVIEW: &str = "docs/decisions/supply-chain.md";
const FEATURES: &str = ".ci/device-features";

/// `name version` of each crate, and whether it has unsafe code: yes or no.
type Reviewed = BTreeMap<String, String>;

pub(crate) fn look(findings: &mut Findings, packages: &[Value]) -> Result<(), Box<dyn Error>> {
    let (device, reviewed) = (device_side(packages)?, review_of(&fs::read_to_string(REVIEW)?));
    findings.problems.extend(unlike(&device, &reviewed));
    let mut wrong = reviewed.clone();
    if let Some(word) = wrong.values_mut().next() {
        *word = if word == "yes" { "no".into() } else { "yes".into() };
    }
    if unlike(&device, &wrong).is_empty() {
        findings.problems.push("a review with one wrong entry is not detected".into());
    }
    findings.controls.push("a review with one wrong entry");
    findings.report.push(format!(
        "The device side depends on {} crates, {} of them with `unsafe` in their source (fos-core: {} crates); [the \
         review](decisions/supply-chain.md) covers each.",
        device.len(),
        device.values().filter(|word| *word == "yes").count(),
        fs::read_to_string(".ci/fos-core-dependencies")?.lines().filter(|line| *line != "fos-core").count()
    ));

    let (on, wanted) = (features(&[])?, fs::read_to_string(FEATURES)?.lines().map(str::to_owned).collect());
    let changed: Vec<&String> = on.symmetric_difference(&wanted).collect();
    if !changed.is_empty() {
        findings.problems.push(format!("{FEATURES} differs from the enabled features: {changed:?}"));
    }
    if features(&["--features", "fos-core/micromath"])? == wanted {
        findings.problems.push("an additional feature is not detected".into());
    }
    findings.controls.push("an additional feature");
    let (by_default, unasked) = default_features(packages);
    if !unasked.is_empty() {
        findings.problems.push(format!("default features are enabled and not empty: {unasked:?}"));
    }
    let crates: BTreeSet<&str> =
        on.iter().filter_map(|line| line.split_once(" > ")?.1.split(':').next()).collect();
    findings.report.push(format!(
        "Features: `{FEATURES}` lists the features enabled in the {} crates that fos-core and fos-embedded use. Of their direct \
         dependencies only {} have default features enabled, and these sets are empty.",
        crates.len(),
        by_default.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    ));
    Ok(())
}

/// Dependencies of fos-embedded on the device.
fn device_side(packages: &[Value]) -> Result<Reviewed, Box<dyn Error>> {
    let tree = [
        "tree",
        "-p",
        "fos-embedded",
        "--all-features",
        "--target",
        "all",
        "-e",
        "normal",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ];
    let printed = output(Command::new("cargo").args(tree))?;
    let mut found = Reviewed::new();
    for line in printed.lines() {
        let mut words = line.split(' ');
        if let (Some(name), Some(version)) = (words.next(), words.next())
            && !name.starts_with("fos-")
        {
            let version = version.trim_start_matches('v');
            let package =
                packages.iter().find(|package| package["name"] == name && package["version"] == version);
            let manifest = package
                .and_then(|package| package["manifest_path"].as_str())
                .ok_or_else(|| format!("{line}: no source"))?;
            let sources = Path::new(manifest).with_file_name("src");
            found
                .insert(format!("{name} {version}"), if has_unsafe(&sources)? { "yes" } else { "no" }.into());
        }
    }
    Ok(found)
}

/// Rust code in this folder contains `unsafe` outside comments.
fn has_unsafe(folder: &Path) -> Result<bool, Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let found = if path.is_dir() {
            has_unsafe(&path)?
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            is_unsafe(&fs::read_to_string(&path)?)
        } else {
            false
        };
        if found {
            return Ok(true);
        }
    }
    Ok(false)
}

fn is_unsafe(source: &str) -> bool {
    fn has(tokens: TokenStream) -> bool {
        tokens.into_iter().any(|token| match token {
            TokenTree::Group(group) => has(group.stream()),
            TokenTree::Ident(word) => word == "unsafe",
            _ => false,
        })
    }
    // A file that cannot be parsed, such as a template, counts if it contains the letters.
    source.contains("unsafe") && source.parse().map_or(true, has)
}

fn unlike(device: &Reviewed, reviewed: &Reviewed) -> Vec<String> {
    let names: BTreeSet<&String> = device.keys().chain(reviewed.keys()).collect();
    let differ = names.into_iter().filter(|name| device.get(*name) != reviewed.get(*name));
    differ
        .map(|name| {
            format!("{REVIEW}: {name}: there {:?}, in its source {:?}", reviewed.get(name), device.get(name))
        })
        .collect()
}

/// Reads the table of the review: | `name version` | … | unsafe | …
fn review_of(text: &str) -> Reviewed {
    let row = |line: &str| {
        let cells: Vec<&str> = line.strip_prefix("| `")?.split('|').map(str::trim).collect();
        let word = cells.get(2).filter(|word| ["yes", "no"].contains(word))?;
        Some((cells[0].trim_end_matches('`').to_owned(), (*word).to_owned()))
    };
    text.lines().filter_map(row).collect()
}

/// A line for every crate of the device side, sensors and store included, with the features enabled by these requested
/// ones.
fn features(asked: &[&str]) -> Result<BTreeSet<String>, Box<dyn Error>> {
    let mut lines = BTreeSet::new();
    let sides: [(&str, &[&str]); 2] =
        [("fos-core", &[]), ("fos-embedded", &["--features", "bmi323,lsm6dsv16x,store"])];
    for (package, parts) in sides {
        let tree = [
            "-e",
            "normal",
            "--target",
            "thumbv7em-none-eabihf",
            "--prefix",
            "none",
            "--no-dedupe",
            "--format",
            "{p}|{f}",
        ];
        let printed =
            output(Command::new("cargo").args(["tree", "-p", package]).args(parts).args(asked).args(tree))?;
        for line in printed.lines() {
            let (name, on) =
                (line.split(' ').next().unwrap_or_default(), line.split_once('|').map_or("", |(_, on)| on));
            lines.insert(format!("{package} > {}", format!("{name}: {on}").trim_end_matches([':', ' '])));
        }
    }
    Ok(lines)
}

/// Crates that fos-core and fos-embedded need with default features, and those with selected features.
fn default_features(packages: &[Value]) -> (BTreeSet<&str>, Vec<&str>) {
    let ours =
        packages.iter().filter(|package| package["name"] == "fos-core" || package["name"] == "fos-embedded");
    let direct = ours.flat_map(|package| package["dependencies"].as_array().into_iter().flatten());
    let by_default: BTreeSet<&str> = direct
        .filter(|one| {
            one["uses_default_features"] == true && !one["source"].is_null() && one["kind"] != "dev"
        })
        .filter_map(|one| one["name"].as_str())
        .collect();
    let has_some = |package: &&Value| {
        package["features"]["default"].as_array().is_some_and(|default| !default.is_empty())
    };
    let unasked = packages
        .iter()
        .filter(has_some)
        .filter_map(|package| package["name"].as_str())
        .filter(|name| by_default.contains(name));
    let unasked = unasked.collect();
    (by_default, unasked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_unsafe_in_code_only() {
        for source in [
            "fn f() { unsafe { g() } }",
            "macro_rules! m { () => { unsafe impl T for U {} } }",
            "{{ template }} unsafe (",
        ] {
            assert!(is_unsafe(source), "{source}");
        }
        for source in
            ["// unsafe\n#![forbid(unsafe_code)]", "/* unsafe */ fn f() {}", "const S: &str = \"unsafe\";"]
        {
            assert!(!is_unsafe(source), "{source}");
        }
    }

    #[test]
    fn parses_table_of_the_review() {
        let text =
            "| crate | does | unsafe |\n| `a 1.0.0` | sums | yes | who |\n| `b 2.0.0` | no | no | who |\n";
        let reviewed = review_of(text);
        assert_eq!(
            reviewed,
            Reviewed::from([("a 1.0.0".into(), "yes".into()), ("b 2.0.0".into(), "no".into())])
        );
        let device = Reviewed::from([("a 1.0.0".into(), "yes".into()), ("c 1.0.0".into(), "no".into())]);
        assert_eq!(unlike(&device, &reviewed).len(), 2);
    }
}
