//! The program `fos`: parses arguments, runs the command, prints, sets the exit code.

#![deny(unsafe_code)]

use std::process::ExitCode;

use host_fit::cli::{self, Lifetime};

fn main() -> ExitCode {
    // A closed pipe, as in `fos fit … | head`, ends the program quietly.
    sigpipe::reset();
    fos_data::catch_panic::announce_no_caught_panic();
    cli::run(set_allocator)
}

/// Sets the thresholds of the allocator. Freed memory is mostly a column of a log (megabytes), and the next allocation has the same size.
///
/// A short command keeps freed memory for reuse: getting each column from the system again, page by page, took a third of the time of a
/// fit. Four threads share a heap; with a heap for each, the peak would be a fifth higher.
///
/// A workbench returns columns to the system as soon as they are freed. glibc raises its mapping threshold with every mapping that is
/// freed, up to 32 MB, and smaller blocks stay with the thread that allocated them; a workbench on an hour of six axes held half as much
/// again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn set_allocator(lifetime: Lifetime) {
    const LARGE: libc::c_int = 1 << 20;
    const LARGEST: libc::c_int = 32 << 20;
    const KEPT: libc::c_int = 256 << 20;
    let heaps = std::thread::available_parallelism().map_or(1, |cores| cores.get().div_ceil(4));
    let settings: &[(libc::c_int, libc::c_int)] = match lifetime {
        Lifetime::UntilDone => &[
            (libc::M_ARENA_MAX, heaps.try_into().unwrap_or(1)),
            (libc::M_MMAP_THRESHOLD, LARGEST),
            (libc::M_TRIM_THRESHOLD, KEPT),
        ],
        Lifetime::UntilEnded => &[(libc::M_MMAP_THRESHOLD, LARGE)],
    };
    for (setting, value) in settings {
        // SAFETY: sets a number in the allocator, which has a lock; no other thread is running yet. A refusal changes nothing.
        #[expect(unsafe_code, reason = "the setting has no safe interface")]
        unsafe {
            libc::mallopt(*setting, *value);
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn set_allocator(_: Lifetime) {}
