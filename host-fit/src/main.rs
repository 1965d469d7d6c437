//! `host-fit`: parse, run, print, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    // a reader that has seen enough, as in `host-fit fit … | head`, ends the program quietly
    sigpipe::reset();
    host_fit::cli::run()
}
