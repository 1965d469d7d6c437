//! Controls that cargo-deny must refuse.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::workspace::output;

/// Creates a package with its own workspace.
fn package(place: &Path, [name, version, licence]: [&str; 3], more: &str) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(place.join("src"))?;
    fs::write(place.join("src/lib.rs"), "")?;
    let manifest = format!(
        "[package]\nname = \"{name}\"\nversion = \"{version}\"\nedition = \"2021\"\nlicense = \"{licence}\"\npublish = false\n"
    );
    Ok(fs::write(place.join("Cargo.toml"), manifest + more)?)
}

/// Creates a package with these dependencies, whose crates are in subfolders.
pub(crate) fn scratch(
    place: &Path,
    dependencies: &str,
    crates: &[(&str, [&str; 3])],
) -> Result<PathBuf, Box<dyn Error>> {
    let folders: Vec<&str> = crates.iter().map(|(folder, _)| *folder).collect();
    package(
        place,
        ["scratch", "0.1.0", "MIT"],
        &format!("[dependencies]\n{dependencies}\n[workspace]\nexclude = {folders:?}\n"),
    )?;
    for (folder, described) in crates {
        package(&place.join(folder), *described, "")?;
    }
    Ok(place.to_owned())
}

fn commit(folder: &Path) -> Result<(), Box<dyn Error>> {
    for arguments in [&["init", "--quiet"][..], &["add", "."], &["commit", "--quiet", "--message", "control"]]
    {
        let mut git = Command::new("git");
        git.args(["-c", "user.name=control", "-c", "user.email=control@localhost"]).args(arguments);
        output(git.current_dir(folder))?;
    }
    Ok(())
}

/// Exit codes of cargo-deny for failed checks.
const BANS: i32 = 2;
const LICENSES: i32 = 4;
const SOURCES: i32 = 8;

/// Workspaces, with the exit code of the check that must refuse each.
pub(crate) fn workspaces(folder: &Path) -> Result<Vec<(PathBuf, i32)>, Box<dyn Error>> {
    let a = "a = { path = \"a\" }";
    let two = format!("{a}\nb = {{ path = \"b\", package = \"a\" }}");
    let elsewhere = scratch(&folder.join("elsewhere"), "", &[])?;
    commit(&elsewhere)?;
    let git = format!("b = {{ git = \"file://{}\", package = \"scratch\" }}", elsewhere.display());
    let workspaces = vec![
        (scratch(&folder.join("sound"), a, &[("a", ["a", "1.0.0", "MIT OR GPL-3.0-only"])])?, 0),
        (scratch(&folder.join("licence"), a, &[("a", ["a", "1.0.0", "MIT AND GPL-3.0-only"])])?, LICENSES),
        (
            scratch(
                &folder.join("duplicate"),
                &two,
                &[("a", ["a", "1.0.0", "MIT"]), ("b", ["a", "2.0.0", "MIT"])],
            )?,
            BANS,
        ),
        (scratch(&folder.join("source"), &git, &[])?, SOURCES),
    ];
    // cargo-deny itself does not download crates.
    for (workspace, _) in &workspaces {
        output(Command::new("cargo").args(["fetch", "--quiet"]).current_dir(workspace))?;
    }
    Ok(workspaces)
}

/// Folder of the database, named by cargo-deny from its address.
const DATABASE: &str = "advisory-db-3157b0e258782691";
const MADE_UP: &str = r#"```toml
[advisory]
id = "RUSTSEC-2020-0001"
package = "crc"
date = "2020-01-01"
[versions]
patched = []
```

# A made-up advisory

It must be found.
"#;

fn advisories_in(
    program: &Path,
    databases: &Path,
    folder: &Path,
    root: &Path,
    fetch: bool,
) -> Result<Output, Box<dyn Error>> {
    let config = folder.join("deny.toml");
    let rules = fs::read_to_string(root.join("deny.toml"))?;
    fs::write(
        &config,
        rules.replace(
            "[advisories]",
            &format!("[advisories]\ndb-path = {:?}", databases.display().to_string()),
        ),
    )?;
    let mut command = Command::new(program);
    if !fetch {
        command.arg("--offline");
    }
    Ok(command
        .arg("--config")
        .arg(config)
        .args(["--log-level", "error", "check", "advisories"])
        .current_dir(root)
        .output()?)
}

/// Result of the check for known vulnerabilities, in words. The database is the one that cargo-deny downloads, or an
/// earlier download ($CARGO_HOME/advisory-dbs) in the folder $FOS_ADVISORY_DB.
pub(crate) fn advisories(program: &Path, folder: &Path, root: &Path) -> Result<String, Box<dyn Error>> {
    let made_up = folder.join("made-up").join(DATABASE);
    fs::create_dir_all(made_up.join("crates/crc"))?;
    fs::write(made_up.join("crates/crc/RUSTSEC-2020-0001.md"), MADE_UP)?;
    commit(&made_up)?;
    let text = |done: &Output| String::from_utf8_lossy(&done.stderr).trim().to_owned();
    let result = advisories_in(program, &folder.join("made-up"), folder, root, false)?;
    if result.status.success() || !text(&result).contains("RUSTSEC-2020-0001") {
        return Err(format!("a made-up advisory is not found: {}", text(&result)).into());
    }
    let (done, by) = match env::var_os("FOS_ADVISORY_DB") {
        Some(copy) => {
            (advisories_in(program, Path::new(&copy), folder, root, false)?, "the copy in `FOS_ADVISORY_DB`")
        }
        None => (
            advisories_in(program, &folder.join("fetched"), folder, root, true)?,
            "the database as of this run",
        ),
    };
    if text(&done).contains("failed to fetch advisory database") {
        return Ok("skipped: advisories (no advisory database is reachable)".into());
    }
    if done.status.success() {
        Ok(format!("Advisories: none for these crates, according to {by}."))
    } else {
        Err(text(&done).into())
    }
}
