//! `batch`: a folder of cases.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{OutputFolder, library};
use super::output::{Failure, number, print_json, print_line, progress, table};
use crate::program::this_build;
use fos_diagnose::batch;

/// Diagnose every case in a folder; interrupted runs resume
#[derive(Debug, Args)]
#[command(after_help = "Example: fos batch cases -o answers")]
pub(super) struct Batch {
    /// The folder: one folder per case, with meta.json and its logs
    folder: PathBuf,
    /// Where answers.json and the corrections go; created if missing
    #[arg(short, long, default_value = "answers")]
    output: OutputFolder,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Print the answers as JSON
    #[arg(long)]
    json: bool,
}

impl Batch {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let bar = progress(0, "diagnosing");
        let answers = batch::run(&self.folder, &self.output, &library, &this_build(), |done, all, case| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
            bar.set_message(case);
        })?;
        bar.finish_and_clear();
        if self.json {
            return print_json(&answers);
        }
        let mut rows = table(&["case", "verdict", "findings", "s"]);
        for answer in &answers.cases {
            let (verdict, findings) = match (&answer.diagnosis, &answer.error) {
                (Some(diagnosis), _) => (
                    diagnosis.verdict.words().to_owned(),
                    diagnosis.findings.iter().map(|f| f.effect.clone()).collect::<Vec<_>>().join(", "),
                ),
                (None, error) => ("error".to_owned(), error.clone().unwrap_or_default()),
            };
            rows.add_row(vec![answer.case.clone(), verdict, findings, number(answer.seconds)]);
        }
        print_line!("{rows}");
        print_line!("\nanswers written to {}", self.output.join("answers.json").display());
        if answers.cases.iter().any(|answer| answer.error.is_some()) {
            return Err("some cases could not be diagnosed; their reason is in the table".into());
        }
        Ok(())
    }
}
