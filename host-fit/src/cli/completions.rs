//! `completions`: shell completions of the arguments.

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use super::output::Failure;

/// Print completions for a shell
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos completions bash > ~/.local/share/bash-completion/completions/fos\nExample: fos completions zsh > ~/.zfunc/_fos"
)]
pub(super) struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    /// Prints the completions of `program` with all its subcommands.
    pub(super) fn run(&self, mut program: Command) -> Result<(), Failure> {
        generate(self.shell, &mut program, "fos", &mut std::io::stdout());
        Ok(())
    }
}
