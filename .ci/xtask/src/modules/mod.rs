//! `cargo xtask modules`: dependencies between files.
//!
//! A name is followed through `pub use` and globs to the file that defines it, so that a file which only re-exports
//! names adds no dependency. Covered: `use`, paths in code, in macros and in serde's attributes, and `impl` blocks of
//! types from other files. Not covered: `#[cfg(test)]`, tests, build scripts, and the types of method calls, which only
//! the compiler knows.

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

/// Output of `cargo xtask modules` in addition to the errors.
#[derive(PartialEq)]
pub(crate) enum Print {
    /// Numbers of files, edges and cycles.
    Summary,
    /// Every edge with its names.
    Arrows,
    /// The graph for Graphviz.
    Dot,
}

/// Reads the workspace; an error if files import each other in a cycle, or a crate has a forbidden dependency.
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
    for problem in circles.iter().chain(&refused) {
        eprintln!("{problem}");
    }
    Err(summary.into())
}
