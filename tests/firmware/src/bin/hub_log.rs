//! The firmware: a replayed sensor, the hub, and telemetry of all its outputs; the same source on the board and on the
//! host, to the same bits.
//!
//! ```text
//! hub_log IMAGE LOG [TELEMETRY]
//! ```
//!
//! IMAGE is a model image (docs/MODEL_FORMAT.md), LOG a hub log (`fos_embedded::test_log`); TELEMETRY is written for
//! `fos record`. Prints the number of samples, a digest of all outputs, the same of a hub in fixed point and its largest
//! difference from the other, and (board only) the cost of each part.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::convert::Infallible;
use core::fmt;

use embedded_io::{ErrorType, Write};
use fos_core::{Fixed, Image};
use fos_embedded::hub::{Hub, MAX_LOGGED, Output};
use fos_embedded::telemetry::{HUB_AXES, Recorder, Snapshot, StartFrame, VERSION};
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord};
use fos_firmware::{File, Instructions, Tally, argument, fail, println};

/// Hub with capacity for 16 inputs, 128 terms, 256 values of history.
type Device = Hub<16, 128, 256>;
type FixedDevice = Hub<16, 128, 256, Fixed>;

/// Size of the pieces in which the log is read and telemetry written, bytes.
const CHUNK: usize = 8192;

const MAX_IMAGE: usize = 32_768;

/// A file as a stream, written in pieces.
struct Stream {
    file: File,
    piece: [u8; CHUNK],
    filled: usize,
}

impl ErrorType for Stream {
    type Error = Infallible;
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if self.filled == CHUNK {
            self.file.write(&self.piece);
            self.filled = 0;
        }
        let length = bytes.len().min(CHUNK - self.filled);
        self.piece[self.filled..][..length].copy_from_slice(&bytes[..length]);
        self.filled += length;
        Ok(length)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        self.file.write(&self.piece[..self.filled]);
        self.filled = 0;
        Ok(())
    }
}

/// Largest difference of the corrected values of two hubs.
#[derive(Default)]
struct Furthest {
    accel_mps2: f32,
    gyro_rads: f32,
    /// Number of samples with different flags of an axis: its value was at the edge of a range.
    otherwise: u32,
}

impl Furthest {
    fn take(&mut self, a: &Output, b: &Output<Fixed>) {
        self.otherwise += u32::from(a.validity() != b.validity());
        let apart =
            |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        self.accel_mps2 = self.accel_mps2.max(apart(a.accel(), b.accel()));
        self.gyro_rads = self.gyro_rads.max(apart(a.gyro(), b.gyro()));
    }
}

impl fmt::Display for Furthest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { accel_mps2, gyro_rads, otherwise } = self;
        write!(
            f,
            "at most {accel_mps2:.2e} m/s², {gyro_rads:.2e} rad/s; {otherwise} samples decided differently"
        )
    }
}

fn path(index: usize, buffer: &mut [u8; 1024]) -> &core::ffi::CStr {
    match argument(index, buffer) {
        Some(path) => path,
        None => fail(format_args!("usage: hub_log IMAGE LOG [TELEMETRY]")),
    }
}

fn run() {
    let mut bytes = [0; MAX_IMAGE];
    let length = File::open(path(1, &mut [0; 1024])).read(&mut bytes);
    let bytes = &bytes[..length];
    let mut name = [0; 1024];
    let name = path(2, &mut name);
    let mut log = File::open(name);
    let mut start = [0; HubLogHeader::LENGTH];
    let length = log.read(&mut start);
    let header = match HubLogHeader::decode(&start[..length]) {
        Ok(header) => header,
        Err(error) => fail(format_args!("{name:?}: {error}")),
    };

    let mut instructions = Instructions::start();
    let mut hub = Device::new(header.scales);
    let mut loaded = Ok(());
    let loading = instructions.of(|| loaded = hub.load(bytes));
    if let Err(error) = loaded {
        fail(format_args!("image: {error}"));
    }
    let mut in_fixed_point = FixedDevice::new(header.scales);
    let fits = in_fixed_point.load(bytes);
    let Some(columns) = Image::parse(bytes).ok().and_then(|image| hub.columns::<256>(&image.info())) else {
        fail(format_args!("image: its quantities have long names"))
    };
    let start = StartFrame {
        version: VERSION,
        period_s: header.scales.period_s as f32,
        axes: HUB_AXES,
        quantities: &columns,
    };
    let mut telemetry = argument(3, &mut [0; 1024]).map(|path| {
        Recorder::<_, 320>::new(Stream { file: File::create(path), piece: [0; CHUNK], filled: 0 })
    });

    let (mut digest, mut ticks, mut frames) = (HubDigest::default(), Tally::default(), Tally::default());
    let mut fixed_digest = HubDigest::default();
    let mut furthest = Furthest::default();
    let mut samples = 0_u64;
    let mut chunk = [0; CHUNK];
    let mut given = [0.0; 16];
    let Some(given) = given.get_mut(..usize::from(header.n_given)) else {
        fail(format_args!("log: more than 16 quantities"))
    };
    let whole_records = CHUNK - CHUNK % header.record_length();
    loop {
        let length = log.read(&mut chunk[..whole_records]);
        for bytes in chunk[..length].chunks(header.record_length()) {
            let record = match HubLogRecord::decode(bytes, given) {
                Ok(record) => record,
                Err(error) => fail(format_args!("log, sample {samples}: {error}")),
            };
            samples += 1;
            let spent = instructions.of(|| {
                let _ = record.step(&mut hub);
            });
            // a gap is not a tick: it costs as many ticks as the longest gap limit has
            if record.raw.skipped == 0 {
                ticks.add(spent);
            }
            digest.update(hub.output());
            if fits.is_ok() {
                let output = record.step(&mut in_fixed_point);
                fixed_digest.update(output);
                furthest.take(hub.output(), output);
            }
            if let Some(recorder) = &mut telemetry {
                let logged = hub.logged();
                frames.add(instructions.of(|| {
                    let snapshot: Snapshot<MAX_LOGGED> = Snapshot::new(hub.output(), &logged);
                    let frame = snapshot.frame();
                    if recorder.sample(&start, frame).is_err() {
                        fail(format_args!("a frame does not fit"));
                    }
                }));
            }
        }
        if length < whole_records {
            break;
        }
    }
    if let Some(recorder) = telemetry {
        let _ = recorder.release().flush();
    }
    println!("samples {samples}");
    println!("outputs {:016x}", digest.outputs());
    match fits {
        Ok(()) => {
            println!("fixed {:016x}", fixed_digest.outputs());
            println!("fixed point from f32: {furthest}");
        }
        Err(error) => println!("fixed none: {error}"),
    }
    if loading.is_finite() {
        println!(
            "instructions: loading the image {loading:.0}; a tick {ticks}; a frame of telemetry {frames}"
        );
    }
    println!("bytes: hub {}", size_of::<Device>());
}

fos_firmware::firmware!(run);
