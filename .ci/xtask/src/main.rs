//! `cargo xtask COMMAND`: checks of the workspace itself, as the gate and people run them.

mod crates;
mod modules;
mod workspace;

use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask COMMAND

  modules [--arrows | --dot]   what imports what: fails where files import each other in a circle, or a crate another than it may";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let ended = match arguments[..] {
        ["modules"] => modules::run(modules::Print::Summary),
        ["modules", "--arrows"] => modules::run(modules::Print::Arrows),
        ["modules", "--dot"] => modules::run(modules::Print::Dot),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}
