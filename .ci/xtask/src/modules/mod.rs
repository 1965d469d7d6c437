//! `cargo xtask modules`: which file takes names from which.
//!
//! A name is followed through `pub use` and globs to the file that defines it, so that a file that only passes names on
//! ties nothing. What has been read: `use`, paths in code, in macros and in serde's attributes, `impl` blocks (of a
//! type that another file defines). Left out: `#[cfg(test)]`, tests, build scripts, and what only the compiler can
//! know: the types of method calls.

mod excluded;
mod graph;
mod read;
mod resolve;
mod source;
#[cfg(test)]
mod tests;
mod tokens;
mod visit;

use std::error::Error;
use std::path::Path;

use crate::{crates, workspace};

/// What `cargo xtask modules` prints beside what it finds.
#[derive(PartialEq)]
pub(crate) enum Print {
    /// How much there is of what.
    Summary,
    /// Every arrow, with the names that it stands for.
    Arrows,
    /// The same for Graphviz.
    Dot,
}

/// Reads the workspace; an error if files import each other in a circle, or a crate depends on one that it must not.
pub(crate) fn run(print: Print, root: &Path) -> Result<(), Box<dyn Error>> {
    let packages = workspace::packages(root)?;
    let sources = read::workspace(&packages, root)?;
    let graph = graph::Graph::of(&sources);
    match print {
        Print::Summary => {}
        Print::Arrows => print!("{}", graph.arrows()),
        Print::Dot => print!("{}", graph.dot()),
    }
    let circles = graph.circles();
    let mut refused = crates::refused(&packages, root);
    refused.extend(crates::heavy(&packages, root)?);
    let summary = format!(
        "{} crates, {} files, {} arrows between files: {} circles, {} arrows between crates that must not be",
        packages.len(),
        graph.files(),
        graph.count(),
        circles.len(),
        refused.len()
    );
    if print == Print::Summary {
        println!("{summary}");
    }
    if circles.is_empty() && refused.is_empty() {
        return Ok(());
    }
    for told in circles.iter().chain(&refused) {
        eprintln!("{told}");
    }
    Err(summary.into())
}
