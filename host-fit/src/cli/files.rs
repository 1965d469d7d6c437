//! Checks the paths of a command line before anything is read or computed: no input is overwritten, and no file is written twice. Inputs
//! named elsewhere, such as the logs of a study, are protected when an output is written (`file/inputs.rs` in fos-data).

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, ArgMatches, Command};

use super::arguments::{OutputFile, OutputFolder};
use super::output::Failure;
use fos_data::file::{check_output, is_same_file, protect};

/// Role of a path in the arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// A file or folder to read.
    Input,
    /// A file to write.
    OutputFile,
    /// A folder to write into.
    OutputFolder,
}

/// Role of an argument, if it is a path.
pub fn role_of(argument: &Arg) -> Option<Role> {
    let kind = argument.get_value_parser().type_id();
    let roles = [
        (TypeId::of::<PathBuf>(), Role::Input),
        (TypeId::of::<OutputFile>(), Role::OutputFile),
        (TypeId::of::<OutputFolder>(), Role::OutputFolder),
    ];
    roles.into_iter().find(|(of, _)| kind == *of).map(|(_, role)| role)
}

/// Two outputs of a command line are one file.
#[derive(Debug, thiserror::Error)]
#[error("{first} and {second} are one file, {}: only the last would be there\nhelp: write each to another file", at.display())]
struct TwoOutputs {
    /// Arguments of the outputs.
    first: String,
    second: String,
    /// Common path.
    at: PathBuf,
}

/// # Errors
///
/// An output is an input, or another output.
pub(super) fn check(command: &Command, matches: &ArgMatches) -> Result<(), Failure> {
    let paths = |argument: &Arg| {
        let values = matches.get_raw(argument.get_id().as_str()).into_iter().flatten();
        values.map(PathBuf::from).collect::<Vec<_>>()
    };
    let of_role =
        |role: Role| command.get_arguments().filter(move |argument| role_of(argument) == Some(role));
    of_role(Role::Input).flat_map(paths).for_each(|input| protect(&input));
    let mut outputs: Vec<(String, PathBuf)> = Vec::new();
    for argument in of_role(Role::OutputFile) {
        for at in paths(argument) {
            let second = name_of(argument);
            if let Some((first, _)) = outputs.iter().find(|(_, other)| is_same_file(other, &at)) {
                return Err(TwoOutputs { first: first.clone(), second, at }.into());
            }
            check_output(&at)?;
            outputs.push((second, at));
        }
    }
    Ok(())
}

/// Name as in the help: --output, LOG.
fn name_of(argument: &Arg) -> String {
    let placeholder = || argument.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
    match argument.get_long() {
        Some(long) => format!("--{long}"),
        None => placeholder().unwrap_or_else(|| argument.get_id().to_string().to_uppercase()),
    }
}
