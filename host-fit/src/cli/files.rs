//! Checks the paths of a command line before anything is read or computed: no input is overwritten, and no file is written twice. Files
//! named elsewhere, such as the logs of a study, are protected by the writer (`inputs.rs`).

use std::any::TypeId;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgMatches, Command};

use super::arguments::{OutputFile, OutputFolder};
use fos_data::file::process_reads::{Identity, Place};

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

/// A conflict of paths that would lose a file.
#[derive(Debug, thiserror::Error)]
pub(super) enum PathConflict {
    /// An output is an input.
    #[error("{output} {}: it is what {input} reads, {}, and would be lost\nhelp: write to another file", at.display(), read.display())]
    OutputIsInput {
        /// Argument of the output.
        output: String,
        /// Path of the output.
        at: PathBuf,
        /// Argument of the input.
        input: String,
        /// Path of the input.
        read: PathBuf,
    },
    /// Two outputs are the same.
    #[error("{first} and {second} are one file, {}: only the last would be there\nhelp: give each a file of its own", at.display())]
    TwoOutputs {
        /// First argument.
        first: String,
        /// Second argument.
        second: String,
        /// Common path.
        at: PathBuf,
    },
}

/// # Errors
///
/// An output is an input, or another output.
pub(super) fn check(command: &Command, matches: &ArgMatches) -> Result<(), PathConflict> {
    let mut inputs: Vec<(String, &Path)> = Vec::new();
    let mut outputs: Vec<(String, &Path)> = Vec::new();
    for argument in command.get_arguments() {
        let paths = match role_of(argument) {
            Some(Role::Input) => &mut inputs,
            Some(Role::OutputFile) => &mut outputs,
            Some(Role::OutputFolder) | None => continue,
        };
        let values = matches.get_raw(argument.get_id().as_str()).into_iter().flatten();
        paths.extend(values.map(|value| (name_of(argument), Path::new(value))));
    }
    for (index, (name, output)) in outputs.iter().enumerate() {
        let place = Place::of(output);
        if let Some((first, _)) = outputs[..index].iter().find(|(_, other)| Place::of(other) == place) {
            let (first, second) = (first.clone(), name.clone());
            return Err(PathConflict::TwoOutputs { first, second, at: output.to_path_buf() });
        }
        let Place::Taken(identity) = place else { continue };
        let is_output = |(_, input): &&(String, &Path)| Identity::of(input).as_ref() == Some(&identity);
        if let Some((input, read)) = inputs.iter().find(is_output) {
            return Err(PathConflict::OutputIsInput {
                output: name.clone(),
                at: output.to_path_buf(),
                input: input.clone(),
                read: read.to_path_buf(),
            });
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
