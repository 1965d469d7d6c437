//! Any bytes as a log of Axivity.
#![no_main]

use std::sync::LazyLock;

use fos_fuzz::log;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(log::folder);

fuzz_target!(init: log::init(), |bytes: &[u8]| log::read(&FOLDER, "log.cwa", bytes));
