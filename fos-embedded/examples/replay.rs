//! Runs a recorded log through a stored model: the same source on the board and on the host, to the same bits.
//!
//! ```text
//! replay IMAGE LOG
//! ```
//!
//! IMAGE is a model image (docs/MODEL_FORMAT.md), LOG a log for replay (`fos_embedded::replay`). Prints how many samples
//! there were, a digest of all corrections and one of the innovations, what a step costs (board only) and how much
//! memory the model takes.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

use fos_core::{Image, Predictor};
use fos_embedded::replay::{self, Decoder, Digest, HEADER_LENGTH, Header};
use platform::{File, Instructions, Tally, argument, fail, println};

mod platform;

/// Capacities for six axes, 16 inputs, 128 terms in all, and 256 values of history.
type Device = Predictor<f32, 6, 16, 128, 256>;

/// The log is read in pieces of at most so many bytes.
const CHUNK: usize = 8192;

const MAX_IMAGE: usize = 32_768;

fn open(index: usize) -> File {
    let mut path = [0; 1024];
    match argument(index, &mut path) {
        Some(path) => File::open(path),
        None => fail(format_args!("usage: replay IMAGE LOG")),
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
    let model = Header { n_axes: count(predictor.n_axes()), n_quantities: count(image.quantities().count()) };

    let mut log = open(2);
    let mut start = [0; HEADER_LENGTH];
    let length = log.read(&mut start);
    let header = Header::decode(&start[..length]).and_then(|header| header.check(model).map(|()| header));
    let (header, mut decoder) =
        match header.and_then(|header| Decoder::new(header).map(|decoder| (header, decoder))) {
            Ok(ready) => ready,
            Err(error) => fail(format_args!("log: {error}")),
        };

    let (mut digest, mut cost) = (Digest::default(), Tally::new());
    let mut instructions = Instructions::start();
    let (mut samples, mut skipped) = (0_u64, 0_u64);
    let mut chunk = [0; CHUNK];
    let whole_records = CHUNK - CHUNK % header.record_length();
    loop {
        let length = log.read(&mut chunk[..whole_records]);
        for bytes in chunk[..length].chunks(header.record_length()) {
            let record = match decoder.record(bytes) {
                Ok(record) => record,
                Err(error) => fail(format_args!("log, sample {samples}: {error}")),
            };
            samples += 1;
            skipped += u64::from(record.skipped);
            let mut corrections = &[][..];
            cost.add(instructions.of(|| corrections = replay::step(&mut predictor, &record)));
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
    println!("bytes: predictor {}, decoder {}", size_of::<Device>(), size_of::<Decoder>());
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    run();
}
