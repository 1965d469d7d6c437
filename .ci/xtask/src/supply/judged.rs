//! Record of the last run of cargo-deny: the crates of all lock files, and the rules.

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::workspace::output;

/// Written by `full` and checked in.
pub(crate) const RECORD: &str = ".ci/judged";

/// Third-party crates of a lock file, as `name version`.
fn locked(text: &str) -> impl Iterator<Item = String> {
    text.split("[[package]]").filter_map(|entry| {
        let value = |key: &str| {
            entry.lines().find_map(|line| Some(line.strip_prefix(key)?.trim_matches('"').to_owned()))
        };
        value("source = ").and_then(|_| Some(format!("{} {}", value("name = ")?, value("version = ")?)))
    })
}

fn now(root: &Path) -> Result<BTreeSet<String>, Box<dyn Error>> {
    let mut found = BTreeSet::new();
    for lock in ["Cargo.lock", "fuzz/Cargo.lock", "python/Cargo.lock"] {
        found.extend(locked(&fs::read_to_string(root.join(lock))?));
    }
    let rules = output(Command::new("git").args(["hash-object", "deny.toml"]).current_dir(root))?;
    found.insert(format!("deny.toml {}", rules.trim()));
    Ok(found)
}

fn unjudged(now: &BTreeSet<String>, record: &str) -> Vec<String> {
    now.iter().filter(|one| !record.lines().any(|judged| judged == one.as_str())).cloned().collect()
}

/// Crates added since the last run.
pub(crate) fn news(root: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    Ok(unjudged(&now(root)?, &fs::read_to_string(root.join(RECORD))?))
}

/// Control: a crate missing from the record is not detected.
pub(crate) fn passes_one_more(root: &Path) -> Result<bool, Box<dyn Error>> {
    let more = BTreeSet::from(["made-up 1.0.0".to_owned()]);
    Ok(unjudged(&more, &fs::read_to_string(root.join(RECORD))?).is_empty())
}

/// Records the current crates as checked.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let lines: Vec<String> = now(root)?.into_iter().collect();
    Ok(fs::write(root.join(RECORD), lines.join("\n") + "\n")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn third_party_crates_have_a_source() {
        let lock = "version = 4\n\n[[package]]\nname = \"a\"\nversion = \"1.2.0\"\nsource = \"registry+https://x\"\n\n\
                    [[package]]\nname = \"fos-core\"\nversion = \"0.1.0\"\ndependencies = [\n \"a\",\n]\n";
        assert_eq!(locked(lock).collect::<Vec<_>>(), ["a 1.2.0"]);
    }

    #[test]
    fn reports_added_crates_but_not_removed_ones() {
        let now = BTreeSet::from(["a 1.2.0".to_owned(), "b 2.0.0".to_owned()]);
        assert_eq!(unjudged(&now, "a 1.2.0\nc 1.0.0\n"), ["b 2.0.0"]);
    }
}
