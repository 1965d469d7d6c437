//! `effects`: list of the library, or details of one effect.

use std::path::PathBuf;

use clap::Args;

use super::arguments::library;
use super::output::{Failure, print_json, print_line, print_text, table};
use fos_diagnose::effects::{EXAMPLE, Effect};

/// List the library of physical effects, or explain one
#[derive(Debug, Args)]
#[command(after_help = "Example: fos effects thermal_lag")]
pub(super) struct Effects {
    /// The effect to explain
    effect: Option<String>,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Print a complete effect file to start from
    #[arg(long)]
    example: bool,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

impl Effects {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.example {
            print_text!("{EXAMPLE}");
            return Ok(());
        }
        let library = library(&self.effects)?;
        match &self.effect {
            Some(id) if self.json => print_json(library.get(id)?),
            Some(id) => {
                explain(library.get(id)?);
                Ok(())
            }
            None if self.json => print_json(&library.effects()),
            None => {
                let mut rows = table(&["effect", "band", "error it makes"]);
                for column in rows.column_iter_mut() {
                    column.set_cell_alignment(comfy_table::CellAlignment::Left);
                }
                for effect in library.effects() {
                    let band = format!("{:?}", effect.band).to_lowercase();
                    rows.add_row(vec![effect.id.clone(), band, effect.equation.clone()]);
                }
                print_line!(
                    "{rows}\n\n`fos effects ID` explains one; `--example` prints a file for one of your own"
                );
                Ok(())
            }
        }
    }
}

fn explain(effect: &Effect) {
    print_line!("{} ({})\n", effect.id, effect.name);
    print_line!("{}\n", wrapped(&effect.mechanism));
    let line = |what: &str, text: &str| {
        if !text.is_empty() {
            print_line!("{what}\n{}\n", indented(text));
        }
    };
    line("equation", &effect.equation);
    let terms: Vec<&str> = effect.terms.iter().map(|term| term.regressor.as_str()).collect();
    line("regressors", &terms.join("\n"));
    line("typical size", &effect.typical_size);
    line("source", &effect.source);
    line("signature in a plot", &effect.gives_away);
    line("experiment that shows it", &effect.experiment);
    line("on the device", &effect.device);
    if !effect.confused_with.is_empty() {
        print_line!("confused with");
        for rival in &effect.confused_with {
            print_line!("  {}\n{}", rival.effect, indented(&format!("  {}", rival.separate)));
        }
    }
}

const WIDTH: usize = 100;

fn wrapped(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

fn indented(text: &str) -> String {
    text.lines()
        .map(|line| format!("  {}", wrapped(line).replace('\n', "\n  ")))
        .collect::<Vec<_>>()
        .join("\n")
}
