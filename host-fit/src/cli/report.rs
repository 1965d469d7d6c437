//! `report`: writes a study as one file for people.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::arguments::{OutputFile, Reading, library, only_ends_in};
use super::output::{Failure, print_json, print_line, spinner};
use super::refinement::{LogArguments, column_of, read_logs};
use fos_data::file::write_atomically;
use fos_diagnose::study::Study;
use fos_report::{Report as Content, html, markdown};

/// Write a study as one HTML or Markdown file
#[derive(Debug, Args)]
#[command(after_help = "Example: fos report unit.json --from log.parquet --axis gx -o report.html")]
pub(super) struct Report {
    /// The study
    study: PathBuf,
    /// The axis; by default those with added effects, otherwise the only one of the study
    #[arg(long)]
    axis: Option<String>,
    #[command(flatten)]
    logs: LogArguments,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// The file to write
    #[arg(short, long, default_value = "report.html")]
    output: OutputFile,
    /// The form; by default that of the ending of the file
    #[arg(long)]
    form: Option<Form>,
    #[command(flatten)]
    reading: Reading,
    /// Print the content as JSON and write nothing
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Form {
    /// One page that needs no network
    Html,
    /// Text
    Md,
}

impl Report {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.form.is_none() && !self.json {
            only_ends_in(&self.output, "--output", &["html", "htm", "md"])?;
        }
        let library = library(&self.effects)?;
        let study = Study::read(&self.study)?;
        let refined: Vec<String> =
            study.refinements.iter().map(|refinement| refinement.column.clone()).collect();
        let columns = match (&self.axis, refined.is_empty()) {
            (None, false) => refined,
            (axis, _) => vec![column_of(&study, axis.as_deref())?],
        };
        let logs = read_logs(&self.logs, &self.reading, &study, &self.study, &columns[0])?;
        let spinner = spinner("examining");
        let content = Content::of(&study, &columns, &logs, &library, &mut |what| {
            spinner.set_message(what);
        })?;
        spinner.finish_and_clear();
        if self.json {
            return print_json(&content);
        }
        let ending = self.output.extension().is_some_and(|ending| ending == "md");
        let text = match self.form {
            Some(Form::Md) => markdown(&content)?,
            None if ending => markdown(&content)?,
            _ => html(&content)?,
        };
        write_atomically(&self.output, text.as_bytes())?;
        print_line!(
            "{}: {}, {} kB",
            self.output.display(),
            axes_in_words(content.axes.len()),
            text.len().div_ceil(1000)
        );
        Ok(())
    }
}

fn axes_in_words(count: usize) -> String {
    if count == 1 { "1 axis".to_owned() } else { format!("{count} axes") }
}
