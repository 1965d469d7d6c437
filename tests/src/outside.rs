//! Files of other people, which are not part of the project: recorded logs, cases of another simulator, answers that
//! others computed or published.
//!
//! | folder of `name` | environment variable with its location | location in every folder above the repository |
//! |---|---|---|
//! | `reference/` | `FOS_REFERENCE` | `shared/reference` |
//! | `data/` | `FOS_REAL_LOGS` | `shared/data` |
//! | `cases/` | `FOS_CASES` | `shared/cases` |
//!
//! All required files are in `tests/fixtures`; these files verify it against others. `tests/fixtures/README.md` states
//! when a missing one fails.

use std::io::Write as _;
use std::path::{Path, PathBuf};

const KINDS: [(&str, &str); 3] =
    [("reference", "FOS_REFERENCE"), ("data", "FOS_REAL_LOGS"), ("cases", "FOS_CASES")];

/// A file or folder of `shared`, such as `data/log.csv.gz`. If it is missing, a message is printed, bypassing the
/// harness' capture of output.
///
/// # Panics
///
/// It is missing, was promised (its folder is named, or exists above the repository), and `CI` is `true`.
pub fn path(name: &str) -> Option<PathBuf> {
    let (kind, rest) = name.split_once('/').expect("a folder and a name in it");
    let (_, variable) =
        KINDS.into_iter().find(|(known, _)| *known == kind).expect("one of the three folders");
    let named = std::env::var_os(variable).map(PathBuf::from);
    let above: Vec<PathBuf> =
        Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|folder| folder.join("shared")).collect();
    let beside = above.iter().map(|shared| shared.join(kind));
    let found =
        named.iter().cloned().chain(beside).map(|folder| folder.join(rest)).find(|path| path.exists());
    let promised = named.is_some()
        || above.iter().any(|shared| KINDS.iter().any(|(kind, _)| shared.join(kind).is_dir()));
    match (&found, missing(promised, std::env::var("CI").is_ok_and(|ci| ci == "true"))) {
        (Some(_), _) => {}
        (None, Missing::Skipped) => {
            // not by `eprintln!`, whose output is shown for failing tests only
            let _ = writeln!(std::io::stderr(), "skipped: no ../shared/{name}, and {variable} names none");
        }
        (None, Missing::Fails) => {
            panic!("no ../shared/{name}, where others of its kind are: what was promised is checked")
        }
    }
    found
}

#[derive(Debug, PartialEq)]
enum Missing {
    Skipped,
    Fails,
}

/// Treatment of a test whose file is missing.
fn missing(promised: bool, ci: bool) -> Missing {
    if promised && ci { Missing::Fails } else { Missing::Skipped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn promised_files_are_required_in_ci() {
        assert_eq!(missing(true, true), Missing::Fails);
        // people see the message; a clone was never promised any
        for (promised, ci) in [(true, false), (false, true), (false, false)] {
            assert_eq!(missing(promised, ci), Missing::Skipped);
        }
    }

    #[test]
    #[should_panic(expected = "one of the three folders")]
    fn unknown_folder_panics() {
        let _ = path("other/file");
    }
}
