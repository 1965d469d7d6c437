//! Any bytes as the telemetry of a device or a file of it: damaged frames are counted, and the others give a log with
//! columns of one length.
#![no_main]

use fos_embedded::telemetry::{Frame, decode};
use fos_embedded::test_log::{HubLogHeader, HubLogRecord};
use fos_fuzz::sealed_frame;
use fos_device_io::record::{RecordError, record};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    run(bytes);
    // As intact frames, each with its length before it.
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
            let (samples, damaged) = counted(stream);
            assert_eq!(recorded.report.damaged, damaged);
            // Repeated samples are not counted twice.
            assert!(recorded.report.samples + recorded.report.unknown <= samples, "{:?}", recorded.report);
            let rows = recorded.report.samples as usize;
            assert!(recorded.columns.iter().all(|(_, values)| values.len() == rows));
            assert!(recorded.columns[0].1.iter().all(|time| time.is_finite()));
            assert_eq!(recorded.report.bytes, stream.len() as u64);
        }
        Err(RecordError::Nothing { damaged, bytes }) => {
            assert_eq!((damaged, bytes), (counted(stream).1, stream.len() as u64));
        }
        Err(error) => assert!(error.to_string().contains("\nhelp: "), "{error}"),
    }
}

/// Numbers of frames of samples, and of invalid frames, in a stream.
fn counted(stream: &[u8]) -> (u64, u64) {
    let (mut samples, mut damaged) = (0, 0);
    // The first bytes may be the end of a frame.
    for (index, frame) in stream.split(|&byte| byte == 0).enumerate().filter(|(_, frame)| !frame.is_empty()) {
        let mut frame = [frame, &[0]].concat();
        match decode::<Frame<&str, Vec<f32>, Vec<u16>>>(&mut frame) {
            Ok(Frame::Sample(_)) => samples += 1,
            Ok(Frame::Start(start)) => {
                damaged += u64::from(!(start.period_s.is_finite() && start.period_s > 0.0))
            }
            Err(_) => damaged += u64::from(index > 0),
        }
    }
    (samples, damaged)
}

/// Logs read by firmware.
fn files(bytes: &[u8]) {
    if let Ok(header) = HubLogHeader::decode(bytes) {
        let mut given = [0.0; 64];
        let record = header.record_length().min(bytes.len());
        for chunk in bytes[bytes.len() - record..].chunks(header.record_length().max(1)) {
            let _ = HubLogRecord::decode(chunk, &mut given);
        }
    }
}
