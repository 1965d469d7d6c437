//! Subcommands of a program, including nested ones.

use clap::Command;

/// Subcommands with the words that call them, each before its nested ones: `fleet`, `fleet report`.
pub(super) fn subcommands_of(program: &Command) -> Vec<(String, Command)> {
    let below = |words: &str, command: &Command| {
        let named = |one: &Command| (format!("{words} {}", one.get_name()).trim().to_owned(), one.clone());
        command.get_subcommands().map(named).collect::<Vec<_>>()
    };
    let mut found = below("", program);
    let mut place = 0;
    while let Some((words, command)) = found.get(place) {
        let more = below(words, command);
        place += 1;
        found.splice(place..place, more);
    }
    found
}
