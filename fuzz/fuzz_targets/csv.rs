//! Any bytes as a log in CSV.
#![no_main]

use fos_fuzz::log;
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: log::init(), |bytes: &[u8]| log::read("log.csv", bytes));
