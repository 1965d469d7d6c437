//! `fos`: parse, run, print, exit code.

#![deny(unsafe_code)]

use std::process::ExitCode;

use host_fit::cli::{self, Lifetime};

fn main() -> ExitCode {
    // a reader that has seen enough, as in `fos fit … | head`, ends the program quietly
    sigpipe::reset();
    fos_data::catch_panic::announce_no_caught_panic();
    cli::run(set_allocator)
}

/// What is dropped is a column of a log, megabytes, and the next column has its size.
///
/// A command that ends soon keeps the memory of what it drops for what comes next: to get each column anew from the system, page by
/// page, took a third of the time of a fit. Four threads share a heap: with one of each the peak would be a fifth higher.
///
/// A workbench gives columns back as soon as they are dropped: glibc raises the size from which it maps memory of its own with
/// every mapping that is freed, up to 32 MB, and what is smaller stays with the thread that allocated it; one over an hour of six
/// axes held half as much again.
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
        // SAFETY: sets a number in the allocator, which has a lock; no other thread is there yet. A refusal changes
        // nothing.
        #[expect(unsafe_code, reason = "the setting has no safe interface")]
        unsafe {
            libc::mallopt(*setting, *value);
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn set_allocator(_: Lifetime) {}
