//! A new calibration, and one of a diagnosis that knows nothing.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::page::{CALIBRATION, CASES, README, SEEDS, section, summary, table};
use crate::form::host_fit;
use crate::workspace::output;

/// So few show it.
pub(crate) const CONTROL_CASES: usize = 30;

/// Calibrates on every seed and writes the tables; what the check says of a diagnosis that knows no effect.
pub(crate) fn calibrate(root: &Path) -> Result<String, Box<dyn Error>> {
    let program = host_fit(root)?;
    let missed = ignorant(&program)?;
    let mut page = fs::read_to_string(CALIBRATION)?;
    for seed in SEEDS {
        let (cases, seed_text) = (CASES.to_string(), seed.to_string());
        let arguments = ["calibrate", "--cases", &cases, "--seed", &seed_text, "--check", "--json"];
        eprintln!("calibrating: {}", arguments.join(" "));
        let done = Command::new(&program).args(arguments).stderr(Stdio::inherit()).output()?;
        if !done.status.success() {
            return Err(format!("seed {seed}: a figure is not as it must be").into());
        }
        let calibrated: Vec<Value> = serde_json::from_slice(&done.stdout)?;
        let head = format!(
            "Seed {seed}, {CASES} cases; times are of one core, the others busy with other cases:\n\n"
        );
        let place = section(&page, &format!("calibration {seed}"), CALIBRATION)?;
        page.replace_range(place, &(head + &table(&calibrated)?));
    }
    let mut readme = fs::read_to_string(README)?;
    readme.replace_range(section(&readme, "calibration", README)?, &summary(&page)?);
    fs::write(CALIBRATION, page)?;
    fs::write(README, readme)?;
    Ok(missed)
}

/// A diagnosis that looks for every effect in a column that no log has: what the check says of it.
fn ignorant(program: &Path) -> Result<String, Box<dyn Error>> {
    let listed: Vec<Value> =
        serde_json::from_str(&output(Command::new(program).args(["effects", "--json"]))?)?;
    let folder = tempfile::tempdir()?;
    let mut command = Command::new(program);
    command.args([
        "calibrate",
        "--check",
        "--cases",
        &CONTROL_CASES.to_string(),
        "--seed",
        &SEEDS[0].to_string(),
    ]);
    for effect in listed.iter().filter(|effect| effect["band"] == "slow") {
        let id = effect["id"].as_str().ok_or("an effect has no name")?;
        let path = folder.path().join(format!("{id}.toml"));
        let said = format!(
            r#"id = "{id}", name = "{id}", band = "slow", mechanism = "none", equation = "none", experiment = "none""#
        );
        fs::write(&path, said.replace(", ", "\n") + "\n[[terms]]\nregressor = \"nowhere\"\n")?;
        command.arg("--effect").arg(path);
    }
    let done = command.stdout(Stdio::null()).output()?;
    let said = String::from_utf8_lossy(&done.stderr).trim().lines().last().unwrap_or("nothing").to_owned();
    match said.split_once("not as it must be: ") {
        Some((_, missed)) if done.status.code() == Some(1) => Ok(missed.to_owned()),
        _ => Err(format!("a diagnosis that knows no effect passes: {said}").into()),
    }
}
