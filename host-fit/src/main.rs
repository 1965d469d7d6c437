//! `host-fit`: parse, run, print, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_fit::cli::run()
}
