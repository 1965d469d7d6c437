//! `fleet report`: a population in one page for people.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{OutputFile, only_ends_in};
use crate::cli::output::{Failure, print_json, print_line};
use fos_data::file::write_atomically;
use fos_fleet::Fleet;
use fos_report::fleet::{FleetReport, html};

/// Write a population as one page: scatter of devices and lots, odd devices, what to ship
#[derive(Debug, Args)]
#[command(after_help = "Example: fos fleet report population.json -o fleet.html")]
pub(super) struct Report {
    /// The population; its rows are next to it, under the same name with .rows appended
    population: PathBuf,
    /// The page to write
    #[arg(short, long, default_value = "fleet.html")]
    output: OutputFile,
    /// Print the content as JSON and write nothing
    #[arg(long)]
    json: bool,
}

impl Report {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if !self.json {
            only_ends_in(&self.output, "--output", &["html", "htm"])?;
        }
        let (fleet, rows) = Fleet::read(&self.population)?;
        let content = FleetReport::of(&fleet, &rows, &self.population);
        if self.json {
            return print_json(&content);
        }
        let text = html(&content)?;
        write_atomically(&self.output, text.as_bytes())?;
        print_line!("{}: {} devices, {} kB", self.output.display(), fleet.units, text.len().div_ceil(1000));
        Ok(())
    }
}
