//! Every public type of both crates can be logged with defmt.
//!
//! The text of the log exists only on the target: `.ci/device defmt` checks it.

use std::fs;
use std::path::Path;

/// A type of a feature for hosts, and types without a value.
const NOT_LOGGED: [&str; 3] = ["Coasts", "Lsm6dsoRegisters", "Lsm6dsv16xRegisters"];

/// Names of the public types of a source that neither derive `defmt::Format` nor implement it there.
fn not_logged(source: &str) -> Vec<String> {
    let words = source.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut attributes = String::new();
    let mut found = Vec::new();
    for line in source.lines().map(str::trim_start) {
        let item =
            ["pub struct ", "pub enum ", "pub union "].iter().find_map(|start| line.strip_prefix(start));
        if let Some(item) = item {
            let name: String =
                item.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
            let implements = |end: &str| words.contains(&format!("defmt::Format for {name}{end}"));
            if !attributes.contains("derive(defmt::Format)") && !implements("<") && !implements(" ") {
                found.push(name);
            }
        }
        if !line.starts_with('#') && !line.starts_with("//") {
            attributes.clear();
        }
        attributes.push_str(line);
    }
    found
}

fn search(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => search(&path, found),
            false => found.extend(not_logged(&fs::read_to_string(&path).expect("text"))),
        }
    }
}

#[test]
fn every_public_type_can_be_logged() {
    let mut found = Vec::new();
    for source in ["src", "../fos-core/src"] {
        search(&Path::new(env!("CARGO_MANIFEST_DIR")).join(source), &mut found);
    }
    found.sort();
    assert_eq!(found, NOT_LOGGED);
}

#[test]
fn detects_types_that_cannot_be_logged() {
    let derived =
        "#[cfg_attr(feature = \"defmt\", derive(defmt::Format))]\n/// Text.\npub struct Derived<T> {\n";
    let source = format!(
        "{derived}    pub enum Inner;\npub struct Own;\nimpl<R> defmt::Format\n    for Own {{}}\npub(crate) struct Private;\n"
    );
    assert_eq!(not_logged(&source), ["Inner"]);
}
