//! `man`: manual pages, one for each subcommand.

use clap::{Args, Command};
use clap_mangen::Man as Page;

use super::arguments::OutputFolder;
use super::command_tree::subcommands_of;
use super::output::{Failure, Written, print_written};
use fos_data::file::{make_folder, write_atomically};

/// Write manual pages, one for each subcommand
#[derive(Debug, Args)]
#[command(after_help = "Example: fos man ~/.local/share/man/man1 && man fos-add")]
pub(super) struct Man {
    /// The folder; created if missing
    folder: OutputFolder,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Man {
    /// Writes the pages of `program` and all its subcommands.
    pub(super) fn run(&self, mut program: Command) -> Result<(), Failure> {
        make_folder(&self.folder)?;
        program.build();
        let pages = subcommands_of(&program).into_iter().filter(|(words, _)| words != "help");
        let pages = pages.map(|(words, command)| command.name(format!("fos-{}", words.replace(' ', "-"))));
        let mut written = Vec::new();
        for command in std::iter::once(program.clone()).chain(pages) {
            let path = self.folder.join(format!("{}.1", command.get_name()));
            let mut text = Vec::new();
            Page::new(command).render(&mut text)?;
            write_atomically(&path, &text)?;
            written.push(Written { path: path.display().to_string(), what: "manual page".to_owned() });
        }
        print_written(&written, self.json)
    }
}
