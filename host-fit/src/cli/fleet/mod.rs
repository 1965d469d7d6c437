//! `fleet`: what the units in a folder have in common, which do not belong, and what follows from it. Each subcommand in a file of its own.

mod export;
mod make;
mod report;

use clap::{Args, Subcommand};

use super::output::Failure;

/// Compare many devices: mean of the part, scatter, odd devices
///
/// Every unit is a log at rest of some minutes, in which the temperature changes. Its bias and its coefficients are estimated with their errors,
/// and the scatter of the units is told apart from those. Rows are kept beside the output, and a run that was broken off goes on where it
/// was. A unit that cannot be read is told and left out.
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

/// What is done with a population that was made.
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
