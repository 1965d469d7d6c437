//! Runs a recorded log through a stored model: the same source on the board and on the host, to the same bits.
//!
//! ```text
//! predictor_log IMAGE LOG
//! ```
//!
//! IMAGE is a model image (docs/MODEL_FORMAT.md), LOG a log for replay (`fos_embedded::test_log`). Prints the number of
//! samples, a digest of all corrections and one of the innovations, the cost of a step (board only) and the memory of
//! the model.
#![cfg_attr(target_os = "none", no_std, no_main)]

use fos_core::{Image, Predictor};
use fos_embedded::test_log::{PredictorDigest, PredictorLogHeader, PredictorLogRecord};
use fos_firmware::{File, Instructions, Tally, argument, fail, println};

/// Capacities for six axes, 16 inputs, 128 terms in all, and 256 values of history.
type Device = Predictor<f32, 6, 16, 128, 256>;

/// Size of the pieces in which the log is read, bytes.
const CHUNK: usize = 8192;

const MAX_IMAGE: usize = 32_768;

fn open(index: usize) -> File {
    let mut path = [0; 1024];
    match argument(index, &mut path) {
        Some(path) => File::open(path),
        None => fail(format_args!("usage: predictor_log IMAGE LOG")),
    }
}

fn run() {
    let mut bytes = [0; MAX_IMAGE];
    let length = open(1).read(&mut bytes);
    let image = match Image::parse(&bytes[..length]) {
        Ok(image) => image,
        Err(error) => fail(format_args!("image: {error}")),
    };
    let mut predictor: Device = match image.predictor() {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("image: {error}")),
    };
    let count = |things: usize| u8::try_from(things).unwrap_or(u8::MAX);
    let model = PredictorLogHeader {
        n_axes: count(predictor.n_axes()),
        n_quantities: count(image.quantities().count()),
    };

    let mut log = open(2);
    let mut start = [0; PredictorLogHeader::LENGTH];
    let length = log.read(&mut start);
    let header = PredictorLogHeader::decode(&start[..length]);
    let header = match header.and_then(|header| header.check(model).map(|()| header)) {
        Ok(header) => header,
        Err(error) => fail(format_args!("log: {error}")),
    };
    let (mut measured, mut quantities) = ([0.0; 6], [0.0; 16]);
    // as many as the predictor has, which has no more
    let measured = &mut measured[..usize::from(header.n_axes)];
    let quantities = &mut quantities[..usize::from(header.n_quantities)];

    let (mut digest, mut cost) = (PredictorDigest::default(), Tally::default());
    let mut instructions = Instructions::start();
    let (mut samples, mut skipped) = (0_u64, 0_u64);
    let mut chunk = [0; CHUNK];
    let whole_records = CHUNK - CHUNK % header.record_length();
    loop {
        let length = log.read(&mut chunk[..whole_records]);
        for bytes in chunk[..length].chunks(header.record_length()) {
            let record = match PredictorLogRecord::decode(bytes, measured, quantities) {
                Ok(record) => record,
                Err(error) => fail(format_args!("log, sample {samples}: {error}")),
            };
            samples += 1;
            skipped += u64::from(record.skipped);
            let mut corrections = &[][..];
            cost.add(instructions.of(|| corrections = record.step(&mut predictor)));
            digest.update(corrections);
        }
        if length < whole_records {
            break;
        }
    }
    println!("samples {samples} skipped {skipped}");
    println!("corrections {:016x}", digest.corrections());
    println!("innovations {:016x}", digest.innovations());
    if cost.mean().is_finite() {
        println!("instructions a sample: {cost}");
    }
    println!("bytes: predictor {}", size_of::<Device>());
}

fos_firmware::firmware!(run);
