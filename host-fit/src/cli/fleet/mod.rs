//! `fleet`: the population of the devices in a folder, odd devices, and the records to ship. One file per subcommand.

mod export;
mod make;
mod report;

use clap::{Args, Subcommand};

use super::output::Failure;

/// Compare many devices: mean of the part, scatter, odd devices
///
/// Every device is a log at rest of some minutes, in which the temperature changes. Its bias and its coefficients are estimated with their
/// errors, and the scatter of the devices is separated from those. Rows are stored beside the output, and interrupted runs resume. A device
/// that cannot be read is reported and excluded.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos fleet line3 -o population.json --regressor temp_c",
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true
)]
pub(super) struct Fleet {
    #[command(subcommand)]
    of_population: Option<OfPopulation>,
    #[command(flatten)]
    make: make::Make,
}

/// Commands that read a population.
#[derive(Debug, Subcommand)]
enum OfPopulation {
    Export(export::Export),
    Report(report::Report),
}

impl Fleet {
    pub(super) fn run(&self) -> Result<(), Failure> {
        match &self.of_population {
            Some(OfPopulation::Export(command)) => command.run(),
            Some(OfPopulation::Report(command)) => command.run(),
            None => self.make.run(),
        }
    }
}
