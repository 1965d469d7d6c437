//! Any bytes as a log in Parquet.
#![no_main]

use fos_fuzz::log;
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: log::init(), |bytes: &[u8]| {
    log::read("log.parquet", bytes);
    // Columns are reached only if both ends of the file are valid.
    let length = (bytes.len() as u32).to_le_bytes();
    log::read("log.parquet", &[b"PAR1", bytes, &length, b"PAR1"].concat());
});
