//! Runs a new calibration, and one of a diagnosis that finds nothing.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::page::{CALIBRATION, CASES, README, SEEDS, headline, section, summary, table};
use crate::form::host_fit;

/// Number of cases that suffices for the control.
pub(crate) const CONTROL_CASES: usize = 30;

/// Calibrates on every seed and writes the tables; returns the check's output for a diagnosis that finds nothing.
pub(crate) fn calibrate(root: &Path) -> Result<String, Box<dyn Error>> {
    let program = host_fit(root)?;
    let missed = blind(&program)?;
    let mut page = fs::read_to_string(CALIBRATION)?;
    for seed in SEEDS {
        let (cases, seed_text) = (CASES.to_string(), seed.to_string());
        let arguments = ["calibrate", "--cases", &cases, "--seed", &seed_text, "--check", "--json"];
        eprintln!("calibrating: {}", arguments.join(" "));
        let done = Command::new(&program).args(arguments).stderr(Stdio::inherit()).output()?;
        if !done.status.success() {
            return Err(format!("seed {seed}: a figure misses its requirement").into());
        }
        let calibrated: Vec<Value> = serde_json::from_slice(&done.stdout)?;
        let head = format!(
            "Seed {seed}, {CASES} cases; times are of one core, the others busy with other cases:\n\n"
        );
        let place = section(&page, &format!("calibration {seed}"), CALIBRATION)?;
        page.replace_range(place, &(head + &table(&calibrated)?));
    }
    let place = section(&page, "calibration", CALIBRATION)?;
    page.replace_range(place, &summary(&page)?);
    let mut readme = fs::read_to_string(README)?;
    let place = section(&readme, "calibration", README)?;
    readme.replace_range(place, &headline(&page)?);
    fs::write(CALIBRATION, page)?;
    fs::write(README, readme)?;
    Ok(missed)
}

/// Output of the check for a diagnosis that finds nothing. Simulated by resuming a calibration from stored outcomes
/// with all findings removed.
fn blind(program: &Path) -> Result<String, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let (outcomes, kept) = (folder.path().join("outcomes.json"), folder.path().join("outcomes.json.partial"));
    let calibrate = || {
        let mut command = Command::new(program);
        let (cases, seed) = (CONTROL_CASES.to_string(), SEEDS[0].to_string());
        command.args(["calibrate", "--check", "--cases", &cases, "--seed", &seed, "--outcomes"]);
        command.arg(&outcomes).stdout(Stdio::null());
        command
    };
    let mut running = calibrate().spawn()?;
    let mut heading = None;
    let done = loop {
        let text = fs::read_to_string(&kept).unwrap_or_default();
        heading = heading.or_else(|| text.split_once('\n').map(|(first, _)| first.to_owned()));
        if let Some(done) = running.try_wait()? {
            break done;
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    if !done.success() {
        return Err(
            format!("seed {}: a figure of {CONTROL_CASES} cases misses its requirement", SEEDS[0]).into()
        );
    }
    let mut lines = heading.ok_or("the running calibration stored no outcomes")? + "\n";
    let mut diagnosed: Vec<Value> = serde_json::from_slice(&fs::read(&outcomes)?)?;
    for outcome in &mut diagnosed {
        outcome["found"] = Value::Array(Vec::new());
        outcome["verdict"] = "nothing_missing".into();
        lines += &format!("{outcome}\n");
    }
    fs::write(&kept, lines)?;
    let done = calibrate().output()?;
    let message = String::from_utf8_lossy(&done.stderr).trim().lines().last().unwrap_or("nothing").to_owned();
    match message.split_once("not as it must be: ") {
        Some((_, missed)) if done.status.code() == Some(1) => Ok(missed.to_owned()),
        _ => Err(format!("a diagnosis that finds nothing passes: {message}").into()),
    }
}
