//! Every kind of fault at random moments, in the middle of transfers and set-ups too: all samples are the sensor's or
//! flagged, and the source recovers.

use std::fmt::Write;

use fos_embedded::blocking::poll_once;
use fos_embedded::raw::RawSample;
use fos_embedded::sample_source::SampleSource;
use fos_parts::{Fault, generated};

use super::simulated::{
    Shared, Simulated, SimulatedBmi323, SimulatedIcm42688, SimulatedLsm6dso, SimulatedLsm6dsv16x,
    for_every_part,
};

/// Interval between polls, ms: ten samples.
const POLL_MS: u64 = 50;

/// Moments at which each fault begins, for each part.
const MOMENTS: u64 = 25;

/// Largest time from the end of a fault to faultless samples, polls: a source rests at most as long as the fault lasted,
/// then sets the part up, and waits for the first temperature.
const RECOVERED_AFTER: u64 = 20;

/// Number of polls that are then compared with the sensor.
const COMPARED: u64 = 6;

struct Kind {
    name: &'static str,
    begins: &'static [(Fault, f64)],
    lasts_ms: u64,
    /// Damaged codes may look like any others.
    damages_codes: bool,
}

const fn kind(name: &'static str, begins: &'static [(Fault, f64)], lasts_ms: u64) -> Kind {
    Kind { name, begins, lasts_ms, damages_codes: false }
}

const KINDS: [Kind; 22] = [
    kind("a transfer is not answered", &[(Fault::Nack, 1.0)], 100),
    kind("four transfers are not answered", &[(Fault::Nack, 4.0)], 100),
    kind("not answered for 3 ms", &[(Fault::Unanswered, 3e6)], 3),
    kind("not answered for 300 ms", &[(Fault::Unanswered, 300e6)], 300),
    kind("line stuck high for 1 ms", &[(Fault::StuckHigh, 1.0)], 1),
    kind("line stuck high for 200 ms", &[(Fault::StuckHigh, 1.0)], 200),
    kind("line stuck low for 1 ms", &[(Fault::StuckLow, 1.0)], 1),
    kind("line stuck low for 200 ms", &[(Fault::StuckLow, 1.0)], 200),
    kind("burst cut short in the first 64 bytes", &[(Fault::Cut, 1.0)], 100),
    kind("burst cut short in the next 64 bytes", &[(Fault::Cut, 65.0)], 100),
    Kind { damages_codes: true, ..kind("a bit in 200 bytes flips", &[(Fault::Flip, 200.0)], 200) },
    kind("another identity", &[(Fault::Identity, 66.0)], 200),
    kind("reset, then another identity", &[(Fault::Reset, 1.0), (Fault::Identity, 66.0)], 200),
    Kind { damages_codes: true, ..kind("codes stand still", &[(Fault::Frozen, 1.0)], 200) },
    kind("no temperature", &[(Fault::NoTemperature, 1.0)], 1500),
    kind("FIFO stays empty", &[(Fault::Silent, 1.0)], 300),
    kind("reset, then registers keep nothing", &[(Fault::Reset, 1.0), (Fault::Forgetful, 1.0)], 200),
    kind("reset", &[(Fault::Reset, 1.0)], 1),
    kind("FIFO runs over", &[(Fault::Overrun, 1.0)], 1),
    kind("clock 5 % fast", &[(Fault::Ppm, 50_000.0)], 1000),
    kind("clock drifts to 5 % slow", &[(Fault::Drift, -50_000.0)], 1000),
    kind("SCL held for 200 µs after each byte", &[(Fault::Stretch, 200_000.0)], 200),
];

/// Random numbers, the same in every run.
fn random(seed: u64) -> u64 {
    let mut hash = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for _ in 0..3 {
        hash = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    hash ^ (hash >> 32)
}

/// Polls at a multiple of the interval.
fn poll<P: Simulated>(board: &Shared, source: &mut SampleSource<P>, index: u64) -> Vec<RawSample> {
    let wait_us = ((index * POLL_MS * 1000) as f64 - board.borrow().now_us()).max(0.0);
    board.borrow_mut().pass(wait_us);
    let now_us = board.borrow().now_us() as u64;
    poll_once(source.poll(now_us)).expect("done at once").map(<[_]>::to_vec).unwrap_or_default()
}

/// Tick of a sample after `before`; `None` if the sensor has not given it.
fn tick_of(board: &Shared, raw: &RawSample, before: u64) -> Option<u64> {
    (before + 1..=board.borrow().tick()).find(|tick| generated(*tick) == (raw.accel, raw.gyro))
}

/// Runs one fault at one moment.
fn run<P: Simulated>(kind: &Kind, seed: u64) -> Result<(), String> {
    let (board, mut source) = P::source();
    // the set-up takes 50 ms of the first polls
    let begins_us = random(seed) % 400_000 + 40_000;
    let ends_us = begins_us + kind.lasts_ms * 1000;
    for (fault, value) in kind.begins {
        let more = if *fault == Fault::Cut { random(!seed) % 64 } else { 0 };
        board.borrow_mut().schedule(begins_us, *fault, value + more as f64);
    }
    board.borrow_mut().schedule(ends_us, Fault::None, 0.0);
    let recovered = (ends_us / 1000).div_ceil(POLL_MS) + RECOVERED_AFTER;
    let mut before = 0;
    for index in 1..=recovered + COMPARED {
        let samples = poll(&board, &mut source, index);
        if index > recovered && samples.len() < 8 {
            return Err(format!("{} samples in {POLL_MS} ms after recovery", samples.len()));
        }
        for raw in &samples {
            let tick = tick_of(&board, raw, before);
            if index > recovered && (tick != Some(before + 1) || !raw.faults.is_empty()) {
                return Err(format!("{raw:?} at tick {tick:?} after {before}, after recovery"));
            }
            if tick.is_none() && raw.faults.is_empty() && !kind.damages_codes {
                return Err(format!("without a flag, but not given by the sensor: {raw:?}"));
            }
            before = tick.unwrap_or(before);
        }
    }
    Ok(())
}

fn add_failures<P: Simulated>(failures: &mut String) {
    for (index, kind) in KINDS.iter().enumerate() {
        for moment in 0..MOMENTS {
            let seed = index as u64 * MOMENTS + moment;
            if let Err(error) = run::<P>(kind, seed) {
                let _ = writeln!(failures, "{}, {}, moment {moment}: {error}", P::NAME, kind.name);
            }
        }
    }
}

#[test]
fn every_fault_is_recovered_from_at_random_moments() {
    let mut failures = String::new();
    for_every_part!(add_failures(&mut failures));
    assert!(failures.is_empty(), "{failures}");
}
