//! Any bytes as a compressed log, and any text validly compressed, truncated or followed by other data.
#![no_main]

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use fos_fuzz::{log, split};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: log::init(), |bytes: &[u8]| {
    log::read("log.csv.gz", bytes);
    let (tail, text) = split(bytes);
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text).expect("into memory");
    let mut packed = packed.finish().expect("into memory");
    match tail.first() {
        Some(1) => packed.truncate(packed.len().saturating_sub(tail.len())),
        _ => packed.extend(tail),
    }
    log::read("log.csv.gz", &packed);
});
