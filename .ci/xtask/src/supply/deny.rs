//! Runs cargo-deny, or compares with its last run.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::findings::Findings;
use super::{controls, judged};
use crate::form::{Form, target_folder};

/// Checks licences, duplicates and sources; with `full` also advisories.
pub(crate) fn look(findings: &mut Findings, form: Form, root: &Path) -> Result<(), Box<dyn Error>> {
    let Some(program) = cargo_deny(form, root) else {
        let news = judged::news(root)?;
        findings.problems.extend(
            news.iter().map(|one| format!("{one} has not been checked by cargo-deny: run .ci/trust supply")),
        );
        findings.report.push(format!(
            "No crate was added since cargo-deny last accepted all of them (`{}`).",
            judged::RECORD
        ));
        if judged::passes_one_more(root)? {
            findings.problems.push("an additional crate is not detected".into());
        }
        findings.controls.push("an additional crate");
        if form == Form::Full {
            findings.report.push("skipped: cargo-deny (not installed, and the installation failed)".into());
            if env::var("CI").is_ok_and(|is| is == "true") {
                findings.problems.push("cargo-deny could not be installed".into());
            }
        }
        return Ok(());
    };
    let config = root.join("deny.toml");
    for workspace in [root.to_owned(), root.join("fuzz"), root.join("python")] {
        let done = check(&program, &workspace, &config, &["licenses", "bans", "sources"])?;
        if !done.status.success() {
            findings.problems.push(String::from_utf8_lossy(&done.stderr).into());
        }
    }
    let folder = tempfile::tempdir()?;
    // A single crate does not use every licence of the list.
    let lenient = folder.path().join("deny-control.toml");
    let strict = r#"unused-allowed-license = "deny""#;
    fs::write(&lenient, fs::read_to_string(&config)?.replace(strict, r#"unused-allowed-license = "allow""#))?;
    for (workspace, wanted) in controls::workspaces(folder.path())? {
        let code = check(&program, &workspace, &lenient, &["licenses", "bans", "sources"])?.status.code();
        if code != Some(wanted) {
            let name = workspace.display();
            findings
                .problems
                .push(format!("cargo-deny ends with {code:?} on the control {name}, not with {wanted}"));
        }
    }
    findings.controls.push("a crate under `MIT AND GPL-3.0-only`, two versions of a crate, a git source (a valid workspace was accepted)");
    let version = Command::new(&program).arg("--version").output()?;
    let version = String::from_utf8_lossy(&version.stdout).trim().to_owned();
    findings.report.push(format!(
        "`{version}` refuses none of these crates, and each negative control by the intended check."
    ));
    if form == Form::Full {
        let result = controls::advisories(&program, folder.path(), root)?;
        findings.controls.push("a made-up advisory");
        if result.starts_with("skipped") {
            eprintln!("{result}");
        }
        findings.report.push(result);
        if findings.problems.is_empty() {
            judged::write(root)?;
        }
    }
    Ok(())
}

/// Path of cargo-deny, which `full` installs; none if it is unavailable.
fn cargo_deny(form: Form, root: &Path) -> Option<PathBuf> {
    let ours = target_folder(root).join("cargo-deny");
    let runs = |program: &Path| {
        Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success())
    };
    let places = [PathBuf::from("cargo-deny"), ours.join("bin/cargo-deny")];
    let found = || places.iter().find(|program| runs(program)).cloned();
    if form == Form::Full && found().is_none() {
        eprintln!("installing cargo-deny: some minutes");
        let install = [
            "install",
            "cargo-deny",
            "--version",
            "^0.20",
            "--locked",
            "--quiet",
            "--profile",
            "dev",
            "--root",
        ];
        let mut command = Command::new("cargo");
        command.args(install).arg(&ours).env("CARGO_TARGET_DIR", ours.join("build"));
        if let Err(error) = command.status() {
            eprintln!("{error}");
        }
        // Its build files are not needed any more.
        let _ = fs::remove_dir_all(ours.join("build"));
    }
    found()
}

fn check(program: &Path, workspace: &Path, config: &Path, checks: &[&str]) -> Result<Output, Box<dyn Error>> {
    let mut command = Command::new(program);
    command.arg("--offline").arg("--config").arg(config).args(["--log-level", "error", "check"]).args(checks);
    Ok(command.current_dir(workspace).output()?)
}
