//! Any bytes as an archive, and a valid archive of files with any names and contents.
#![no_main]

use fos_fuzz::log;
use fos_testkit::foreign::zip;
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: log::init(), |bytes: &[u8]| {
    if bytes.starts_with(b"PK") {
        return log::read("log.zip", bytes);
    }
    let parts: Vec<&[u8]> = bytes.split(|&byte| byte == 0).collect();
    let files = parts.chunks_exact(2).filter_map(|pair| Some((std::str::from_utf8(pair[0]).ok()?, pair[1])));
    let files: Vec<(&str, &[u8])> = files.filter(|(name, _)| name.len() < usize::from(u16::MAX)).collect();
    log::read("log.zip", &zip(&files));
});
