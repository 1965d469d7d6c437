//! `completions`: what a shell needs to complete arguments.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::Cli;
use super::output::Failure;

/// Print a script that lets a shell complete subcommands and arguments
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-fit completions bash > ~/.local/share/bash-completion/completions/host-fit\nExample: host-fit completions zsh > ~/.zfunc/_host-fit"
)]
pub(super) struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub(super) fn run(&self) -> Result<(), Failure> {
        generate(self.shell, &mut Cli::command(), "host-fit", &mut std::io::stdout());
        Ok(())
    }
}
