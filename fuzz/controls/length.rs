//! Control: a decoder that trusts a length in its input. The fuzzer must find it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some(rest) = bytes.strip_prefix(b"FOSM") else { return };
    let [length, rest @ ..] = rest else { return };
    let body = &rest[..usize::from(*length)];
    assert!(body.len() < 256);
});
