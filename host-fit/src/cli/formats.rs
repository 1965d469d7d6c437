//! `formats`: list of the supported formats, or details of one.

use clap::Args;

use super::output::{Failure, print_json, print_line, table};
use fos_data::recording::{Format, KNOWN_FORMATS};

/// List the formats of logs that are read, or explain one
#[derive(Debug, Args)]
#[command(after_help = "Example: fos formats ulog")]
pub(super) struct Formats {
    /// The format to explain
    format: Option<Format>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

impl Formats {
    pub(super) fn run(&self) -> Result<(), Failure> {
        match self.format {
            Some(format) if self.json => print_json(format.knowledge()),
            Some(format) => {
                let known = format.knowledge();
                print_line!("{} (`--format {}`): {}", known.name, known.id, known.files);
                for (what, text) in [
                    ("read", known.read),
                    ("units", known.units),
                    ("clock", known.clock),
                    ("temperature", known.temperature),
                    ("values", known.values),
                    ("look out for", known.traps),
                    ("refused", known.refused),
                ] {
                    print_line!("  {what}: {text}");
                }
                Ok(())
            }
            None if self.json => print_json(&KNOWN_FORMATS),
            None => {
                let mut rows = table(&["format", "is", "files"]);
                for column in rows.column_iter_mut() {
                    column.set_cell_alignment(comfy_table::CellAlignment::Left);
                }
                for known in KNOWN_FORMATS {
                    rows.add_row(vec![known.id, known.name, known.files]);
                }
                print_line!(
                    "{rows}\n\nthe format is recognised by the content of the log; `fos formats FORMAT` explains one"
                );
                Ok(())
            }
        }
    }
}
