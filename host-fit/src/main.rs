//! `host-fit`: parse, run, print, exit code.

#![forbid(unsafe_code)]

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// Columns of a log are some megabytes each, and come and go: an allocator that keeps some of them for the next spares a
/// third of the time of a diagnosis, and gives back what is not asked for again (docs/decisions/libraries.md).
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    // a reader that has seen enough, as in `host-fit fit … | head`, ends the program quietly
    sigpipe::reset();
    fos_data::catch_panic::announce_no_caught_panic();
    host_fit::cli::run()
}
