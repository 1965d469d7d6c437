//! Any bytes as what a device sends or a file of it holds: damaged frames are counted, the rest makes a log with columns of one
//! length.
#![no_main]

use fos_embedded::{hub_log, replay};
use fos_fuzz::sealed_frame;
use host_fit::record::record;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    run(bytes);
    // as frames that arrived whole, a length before each
    let (mut rest, mut stream) = (bytes, vec![0]);
    while let Some((&length, after)) = rest.split_first() {
        let (payload, after) = after.split_at(usize::from(length).min(after.len()));
        stream.extend(sealed_frame(payload));
        rest = after;
    }
    run(&stream);
    files(bytes);
});

fn run(stream: &[u8]) {
    match record(stream) {
        Ok(recorded) => {
            let rows = recorded.report.samples as usize;
            assert!(recorded.columns.iter().all(|(_, values)| values.len() == rows));
            assert!(recorded.columns[0].1.iter().all(|time| time.is_finite()));
            assert_eq!(recorded.report.bytes, stream.len() as u64);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Logs that firmware reads back.
fn files(bytes: &[u8]) {
    if let Ok(header) = hub_log::Header::decode(bytes) {
        let mut given = [0.0; 64];
        let record = header.record_length().min(bytes.len());
        for chunk in bytes[bytes.len() - record..].chunks(header.record_length().max(1)) {
            let _ = hub_log::Record::decode(chunk, &mut given);
        }
    }
    if let Ok(header) = replay::Header::decode(bytes)
        && let Ok(mut decoder) = replay::Decoder::new(header)
    {
        for chunk in bytes.chunks(header.record_length().max(1)) {
            let _ = decoder.record(chunk);
        }
    }
}
