//! Concurrent changes of one study by several processes.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use super::bench::Bench;
use crate::form::Form;

const AXES: [&str; 3] = ["gx", "gy", "gz"];

/// Results of the rounds.
#[derive(Default)]
struct Tally {
    done: usize,
    refused: usize,
    /// Steps reported as done but missing, or reported as refused but present.
    lost: usize,
}

impl Bench {
    fn shared(&self) -> PathBuf {
        self.folder.join("shared.json")
    }

    /// Axes of the shared study with an added effect.
    fn grown(&self) -> Result<Vec<String>, Box<dyn Error>> {
        let study: Value = serde_json::from_slice(&fs::read(self.shared())?)?;
        let refinements = study["refinements"].as_array().cloned().unwrap_or_default();
        let has = |refinement: &&Value| {
            refinement["steps"]
                .as_array()
                .is_some_and(|steps| steps.iter().any(|step| !step["added"].is_null()))
        };
        Ok(refinements
            .iter()
            .filter(has)
            .filter_map(|refinement| Some(refinement["column"].as_str()?.get(..2)?.to_owned()))
            .collect())
    }

    /// Each process removes the step of one axis; `require_reason`: refused ones state the reason.
    fn round(
        &self,
        command: impl Fn(&str) -> Command,
        require_reason: bool,
        tally: &mut Tally,
    ) -> Result<(), Box<dyn Error>> {
        fs::write(self.shared(), self.read("grown.json")?)?;
        let started: Vec<_> = AXES
            .iter()
            .map(|axis| {
                command(axis).current_dir(&self.folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
            })
            .collect::<Result<_, _>>()?;
        let ended: Vec<_> =
            started.into_iter().map(|process| process.wait_with_output()).collect::<Result<_, _>>()?;
        let grown = self.grown()?;
        for (axis, ended) in AXES.iter().zip(ended) {
            let taken_back = !grown.iter().any(|other| other == axis);
            tally.lost += usize::from(taken_back != ended.status.success());
            *(if ended.status.success() { &mut tally.done } else { &mut tally.refused }) += 1;
            let message = String::from_utf8_lossy(&ended.stderr);
            if require_reason
                && !ended.status.success()
                && !(message.contains("shared.json: changed meanwhile") && message.contains("help:"))
            {
                return Err(format!("refused without a reason: {message}").into());
            }
        }
        Ok(())
    }

    /// A process that reads first and writes last, after the study was replaced. Returns whether it was refused and
    /// the study unchanged.
    fn late(&self) -> Result<bool, Box<dyn Error>> {
        let grown = self.read("grown.json")?;
        // The time at which it has read depends on the machine.
        let mut wait = Duration::from_millis(20);
        for _ in 0..12 {
            fs::write(self.shared(), self.read("fitted.json")?)?;
            let mut add = Command::new(&self.host_fit);
            add.args(["add", "shared.json", "temp_linear", "--from", "field.parquet", "--axis", "gx"]);
            let slow = add.current_dir(&self.folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
            sleep(wait);
            fs::write(self.shared(), &grown)?;
            let ended = slow.wait_with_output()?;
            if fs::read(self.shared())? != grown {
                return Ok(false);
            }
            if String::from_utf8_lossy(&ended.stderr).contains("changed meanwhile")
                && ended.status.code() == Some(1)
            {
                return Ok(true);
            }
            wait = wait.mul_f64(1.5);
        }
        Ok(false)
    }
}

pub(crate) fn look(bench: &Bench) -> Result<bool, Box<dyn Error>> {
    eprintln!("several processes on one study");
    let rounds = if bench.form == Form::Full { 200 } else { 20 };
    let undo = |axis: &str| {
        let mut command = Command::new(&bench.host_fit);
        command.args(["undo", "shared.json", "--axis", axis]);
        command
    };
    let careless = |axis: &str| {
        let script =
            r#"cp shared.json $1.json && "$0" undo $1.json --axis $1 && sleep 0.1 && mv $1.json shared.json"#;
        let mut command = Command::new("sh");
        command.args(["-c", script]).arg(&bench.host_fit).arg(axis);
        command
    };
    let (mut tally, mut control) = (Tally::default(), Tally::default());
    for _ in 0..rounds {
        bench.round(undo, true, &mut tally)?;
    }
    for _ in 0..5 {
        bench.round(careless, false, &mut control)?;
    }
    let refused_late = bench.late()?;
    println!(
        "\nThree processes ran `undo` on one study at the same time, {rounds} times: {} succeeded, {} were refused (“changed meanwhile \
         by another process; run the command again”), {} steps were lost. An `add` whose study was replaced during its computation {}. \
         Negative control: processes that edit a copy and rename it over the study lost {} of 15 steps.",
        tally.done,
        tally.refused,
        tally.lost,
        if refused_late { "was refused" } else { "WAS NOT REFUSED" },
        control.lost
    );
    Ok(tally.lost == 0 && refused_late && control.lost > 0)
}
