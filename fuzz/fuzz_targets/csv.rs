//! Any bytes as a log in CSV.
#![no_main]

use std::sync::LazyLock;

use fos_fuzz::log;
use host_fit::contained::announce_no_contained_panic;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(log::folder);

// else the first panic, contained or not, ends the fuzzer
fuzz_target!(init: announce_no_contained_panic(), |bytes: &[u8]| log::read(&FOLDER, "log.csv", bytes));
