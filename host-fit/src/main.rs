//! `host-fit`: parse, run, print, exit code.

#![deny(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    // a reader that has seen enough, as in `host-fit fit … | head`, ends the program quietly
    sigpipe::reset();
    give_memory_back();
    fos_data::catch_panic::announce_no_caught_panic();
    host_fit::cli::run()
}

/// Columns of a log go back to the system as soon as they are dropped.
///
/// glibc raises the size from which it maps memory of its own with every mapping that is freed, up to 32 MB; what is
/// smaller stays with the thread that allocated it. A workbench over an hour of six axes held half as much again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn give_memory_back() {
    const LARGE: libc::c_int = 1 << 20;
    // SAFETY: sets a number in the allocator, which has a lock; no other thread is there yet. A refusal changes
    // nothing.
    #[expect(unsafe_code, reason = "the setting has no safe interface")]
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn give_memory_back() {}
