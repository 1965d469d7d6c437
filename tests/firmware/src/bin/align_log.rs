//! Aligns a simulated pair of streams: the same source on the board and on the host, to the same bits.
//!
//! A gyro of 208 Hz leads, an accelerometer of 104 Hz on a clock 200 ppm faster follows, a thermometer is held;
//! timestamps have a jitter of up to a millisecond, samples come in batches of 0.2 s, and some are lost, wrong or not
//! finite. Prints the number of rows, a digest of them (FNV-1a), and the cost of a sample of the lead (board only).
#![cfg_attr(target_os = "none", no_std, no_main)]

use fos_core::align::{Aligner, Stream};
use fos_firmware::{Instructions, Tally, println};

/// Number of samples of the gyro, in total and in a batch.
const SAMPLES: i64 = 20_000;
const BATCH: i64 = 40;

/// Periods and jitter, ns.
const GYRO_PERIOD: i64 = 4_807_692;
const ACCEL_PERIOD: i64 = 9_617_308;
const TEMPERATURE_PERIOD: i64 = 100_000_000;
const JITTER: f32 = 1e6;

/// Uniform in 0 … 1 (a linear congruential generator, Knuth's constants).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }

    /// Timestamp of sample n of a stream, ns.
    fn stamp(&mut self, n: i64, period: i64) -> i64 {
        let wild = if self.next() < 0.0005 { 1_000_000_000_000 } else { 0 };
        n * period + (JITTER * (2.0 * self.next() - 1.0)) as i64 + wild
    }

    fn value(&mut self) -> f32 {
        if self.next() < 0.001 { f32::NAN } else { self.next() - 0.5 }
    }

    fn values(&mut self) -> [f32; 3] {
        [self.value(), self.value(), self.value()]
    }

    fn is_lost(&mut self) -> bool {
        self.next() < 0.002
    }
}

struct Digest(u64);

impl Digest {
    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Adds a number; every NaN counts as the same one.
    fn value(&mut self, value: f32) {
        self.update(&if value.is_nan() { 0x7fc0_0000 } else { value.to_bits() }.to_le_bytes());
    }
}

fn run() {
    let mut aligner = Aligner::<f32, 1, 1, 64>::new([ACCEL_PERIOD], [TEMPERATURE_PERIOD]);
    let mut random = Random(1);
    let (mut digest, mut rows, mut cost) = (Digest(0xcbf2_9ce4_8422_2325), 0_u32, Tally::default());
    let mut instructions = Instructions::start();
    for batch in 0..SAMPLES / BATCH {
        let from_ns = batch * BATCH * GYRO_PERIOD;
        let due = |period: i64| from_ns / period..(from_ns + BATCH * GYRO_PERIOD) / period;
        for n in due(TEMPERATURE_PERIOD) {
            let (stamp, value) = (random.stamp(n, TEMPERATURE_PERIOD), random.value());
            let _ = aligner.push_slow(0, stamp, value);
        }
        for n in due(ACCEL_PERIOD) {
            let (stamp, values) = (random.stamp(n, ACCEL_PERIOD), random.values());
            if !random.is_lost() {
                let _ = aligner.push_follower(0, stamp, values);
            }
        }
        for n in due(GYRO_PERIOD) {
            let (stamp, values) = (random.stamp(n, GYRO_PERIOD), random.values());
            let mut row = None;
            cost.add(instructions.of(|| {
                let _ = aligner.push_lead(stamp, values);
                row = aligner.pop();
            }));
            while let Some(joined) = row {
                rows += 1;
                digest.update(&joined.stamp.to_le_bytes());
                joined.lead.iter().for_each(|value| digest.value(*value));
                joined.followers[0].values.iter().for_each(|value| digest.value(*value));
                digest.update(&joined.followers[0].weight.unwrap_or(u32::MAX).to_le_bytes());
                digest.value(joined.slow[0].value);
                digest.update(&joined.slow[0].age.unwrap_or(-1).to_le_bytes());
                row = aligner.pop();
            }
        }
    }
    println!("rows {rows}");
    println!("joined {:016x}", digest.0);
    for (name, stream) in
        [("lead", Stream::Lead), ("follower", Stream::Follower(0)), ("slow", Stream::Slow(0))]
    {
        let counts = aligner.counts(stream);
        println!(
            "{name}: refused {}, not finite {}, dropped {}, set back {}, missing {}",
            counts.refused, counts.not_finite, counts.dropped, counts.set_back, counts.missing
        );
    }
    // on the host nothing is counted
    if cost.mean().is_finite() {
        println!("instructions a sample of the lead: {cost}");
    }
    println!("bytes: aligner {}", size_of::<Aligner<f32, 1, 1, 64>>());
}

fos_firmware::firmware!(run);
