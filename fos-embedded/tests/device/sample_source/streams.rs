//! Long streams of samples: invariants under all conditions.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{self, I2c};
use embedded_hal::spi::{self, SpiDevice};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::raw::{Faults, RawSample};
use fos_embedded::sample_source::{
    Address, Bmi323, INTERRUPT_SAMPLES, Icm42688, Imu, Lsm6dso, Lsm6dsv16x, MAX_SAMPLES, SampleSource,
    SourceError,
};
use fos_parts::{Fault, generated};

use super::simulated::{
    Board, NoAnswer, Shared, Simulated, SimulatedBmi323, SimulatedIcm42688, SimulatedLsm6dso,
    SimulatedLsm6dsv16x, for_every_part,
};

/// Advances the time to the next multiple of `period_us` and polls.
fn poll<P: Simulated>(
    board: &Shared,
    source: &mut SampleSource<P>,
    period_us: f64,
) -> Result<Vec<RawSample>, SourceError<NoAnswer>> {
    let wait_us = period_us - board.borrow().now_us() % period_us;
    board.borrow_mut().pass(wait_us);
    let now_us = board.borrow().now_us() as u64;
    poll_once(source.poll(now_us)).expect("done at once").map(<[_]>::to_vec)
}

/// Checks that every sample of five minutes arrives, in order.
fn assert_no_loss<P: Simulated>(fast: f64) {
    let (board, mut source) = P::source();
    board.borrow_mut().fault(Fault::Ppm, (fast - 1.0) * 1e6);
    let mut samples = Vec::new();
    for _ in 0..3000 {
        samples.extend(poll(&board, &mut source, 100_000.0).expect("a poll"));
    }
    let given = samples.iter().map(|raw| (raw.accel, raw.gyro));
    let first = (0..).find(|tick| generated(*tick) == (samples[0].accel, samples[0].gyro)).expect("a tick");
    assert!(given.eq((first..).take(samples.len()).map(generated)));
    // a few more arrived while the last ones were read
    assert!(board.borrow().tick() + 1 - first - samples.len() as u64 <= 4);
    // only the first temperature is a few samples late
    assert!(samples.iter().skip(17).all(|raw| raw.faults.is_empty() && raw.skipped == 0));
    let counts = source.counts();
    assert_eq!((counts.bus, counts.damaged, counts.overruns, counts.gaps, counts.resets), (0, 0, 0, 0, 0));
}

#[test]
fn no_sample_is_lost_in_five_minutes_for_any_clock_error() {
    for fast in [0.97, 1.0, 1.03] {
        for_every_part!(assert_no_loss(fast));
    }
}

/// Polls whenever the interrupt pin is high, for five minutes: every poll gives the same number of samples, and then the pin is low.
fn assert_interrupts<P: Simulated>(with_interrupt: impl FnOnce(P) -> P) {
    let board = Board::new::<P>();
    let mut source = SampleSource::new(with_interrupt(P::new(&board)));
    // until the part has started
    board.borrow_mut().pass(100_000.0);
    let mut polls = 0;
    while board.borrow().now_us() < 300e6 {
        let is_high = board.borrow().interrupt();
        // the first poll sets the part up; later the pin calls for each
        if polls == 0 || is_high {
            let now_us = board.borrow().now_us() as u64;
            let samples = poll_once(source.poll(now_us)).expect("done at once").expect("a poll").len();
            assert!(!board.borrow().interrupt(), "{}: the pin falls", P::PART);
            // the first frames have no data, and are no samples
            assert!(polls < 5 || samples == usize::from(INTERRUPT_SAMPLES), "{}: {samples} samples", P::PART);
            polls += 1;
        }
        board.borrow_mut().pass(500.0);
    }
    assert!(polls > 5900, "{}: {polls}", P::PART);
}

#[test]
fn interrupt_pin_rises_after_the_same_number_of_samples() {
    assert_interrupts(SimulatedLsm6dsv16x::with_interrupt);
    assert_interrupts(SimulatedLsm6dso::with_interrupt);
}

/// Counted and actual ticks, with pauses of `nap_ms` between polls.
fn naps<P: Simulated>(nap_ms: u32, fast: f64) -> (u64, u64) {
    let (board, mut source) = P::source();
    board.borrow_mut().fault(Fault::Ppm, (fast - 1.0) * 1e6);
    let mut samples = Vec::new();
    for _ in 0..5 {
        samples.extend(poll(&board, &mut source, f64::from(nap_ms) * 1000.0).expect("a poll"));
        while source.has_more() {
            let now_us = board.borrow().now_us() as u64;
            samples.extend(poll_once(source.poll(now_us)).expect("done at once").expect("a poll"));
        }
    }
    let counted = samples.iter().skip(1).map(|raw| u64::from(raw.skipped) + 1).sum();
    let tick = |raw: &RawSample| (0..).find(|tick| generated(*tick) == (raw.accel, raw.gyro));
    let [first, .., last] = &samples[..] else { panic!("no samples") };
    (counted, tick(last).expect("a tick") - tick(first).expect("a tick"))
}

/// Checks the count of ticks if the clocks may differ by less than half a turn of the timestamp after the pause.
fn assert_counted<P: Simulated>(nap_ms: u32, fast: f64) {
    let turn_ms = 2_f64.powi(P::CLOCK.bits as i32) * f64::from(P::CLOCK.count_ps) * 1e-9;
    if 0.05 * f64::from(nap_ms) < turn_ms / 2.0 {
        let (counted, ticks) = naps::<P>(nap_ms, fast);
        assert_eq!(counted, ticks, "{}, {nap_ms} ms", P::NAME);
    }
}

#[test]
fn pauses_are_counted_by_the_sensor_clock() {
    for nap_ms in [300, 700, 1300, 2500, 2600, 5000, 10_000, 20_000] {
        for fast in [0.97, 1.03] {
            for_every_part!(assert_counted(nap_ms, fast));
        }
    }
}

/// Checks which of 400 polls access the bus while no device answers.
fn assert_attempts<P: Simulated>(expected: &[usize]) {
    let (board, mut source) = P::source();
    board.borrow_mut().fail(u32::MAX);
    let attempted = |poll_index: &usize| {
        let before = board.borrow().transfers;
        assert!(poll(&board, &mut source, 50_000.0).is_err(), "poll {poll_index}");
        let transfers = board.borrow().transfers - before;
        assert!(transfers <= 3, "{transfers} transfers");
        transfers > 0
    };
    assert_eq!((0..400).filter(attempted).collect::<Vec<_>>(), expected);
}

#[test]
fn dead_sensor_is_accessed_with_increasing_intervals() {
    let mut expected = vec![0, 1, 3, 7, 15, 31, 63];
    expected.extend((1..6).map(|more| 63 + 64 * more));
    for_every_part!(assert_attempts(&expected));
}

fn stuck<P: Simulated>() {
    let (board, mut source) = P::source();
    for _ in 0..20 {
        poll(&board, &mut source, 50_000.0).expect("a poll");
    }
    board.borrow_mut().fault(Fault::Frozen, 1.0);
    for _ in 0..2400 {
        poll(&board, &mut source, 50_000.0).expect("a poll");
    }
    // 2 min: after 1, 2, 4 … 64 polls with samples, then every 64
    let resets = source.counts().resets;
    assert!((30..=45).contains(&resets), "{resets}");
    board.borrow_mut().fault(Fault::Frozen, 0.0);
    let mut samples = Vec::new();
    for _ in 0..20 {
        samples.extend(poll(&board, &mut source, 50_000.0).expect("a poll"));
    }
    let held = samples.iter().take_while(|raw| raw.faults.contains(Faults::STUCK)).count();
    assert!(held <= 11 && !samples[held..].iter().any(|raw| raw.faults.contains(Faults::STUCK)));
}

#[test]
fn stuck_sensor_is_set_up_with_increasing_intervals() {
    for_every_part!(stuck());
}

/// Values of registers that pass the set-up: first byte on the bus, bytes read.
type Known = &'static [(u8, &'static [u8])];

const LSM6DSV16X: Known = &[
    (0x07, &[0, 0, 0x77, 0x66, 0, 0, 0, 0, 0x70, 0x17, 0x17, 0x44, 0x08, 0, 0x02, 0, 0x01, 0, 0]),
    (0x01, &[0]),
    (0x08, &[0]),
    (0x09, &[0x77]),
    (0x0a, &[0x66]),
    (0x0f, &[0x70]),
    (0x10, &[0x17]),
    (0x11, &[0x17]),
    (0x12, &[0x44]),
    (0x13, &[0x08]),
    (0x15, &[0x02]),
    (0x17, &[0x01]),
    (0x18, &[0]),
    (0x50, &[0x40]),
    (0x62, &[0x02]),
];

const LSM6DSO: Known = &[
    (0x07, &[0, 0, 0x55, 0x66, 0, 0, 0, 0, 0x6c, 0x58, 0x54, 0x44, 0x08, 0, 0, 0, 0, 0xe2, 0x20]),
    (0x01, &[0]),
    (0x08, &[0]),
    (0x09, &[0x55]),
    (0x0a, &[0x66]),
    (0x0f, &[0x6c]),
    (0x10, &[0x58]),
    (0x11, &[0x54]),
    (0x12, &[0x44]),
    (0x13, &[0x08]),
    (0x15, &[0]),
    (0x16, &[0]),
    (0x17, &[0]),
    (0x18, &[0xe2]),
    (0x19, &[0x20]),
];

const BMI323: Known = &[
    (0x80, &[0, 0x43, 0]),
    (0x81, &[0, 0, 0]),
    (0xa0, &[0, 0x19, 0x70]),
    (0xa1, &[0, 0x29, 0x70]),
    (0xb5, &[0, 0, 0]),
    (0xb6, &[0, 0, 0x0f]),
];

const ICM42688: Known = &[
    (0xf5, &[0x47]),
    (0xcc, &[0x33, 0x91, 0x0f, 0x47, 0x47, 0x16, 0x11, 0x0d, 0x29]),
    (0xcf, &[0x47]),
    (0xd0, &[0x47]),
    (0xd4, &[0x29]),
    (0xe2, &[0]),
    (0xdf, &[0x0f]),
    (0xce, &[0x0f]),
    (0xe0, &[0]),
    (0x96, &[0x40]),
];

/// A bus with random answers, or none.
struct Nonsense {
    state: u64,
    known: Known,
}

impl Nonsense {
    fn next(&mut self) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state
    }

    /// Returns true most of the time.
    fn mostly(&mut self) -> bool {
        !self.next().is_multiple_of(50)
    }

    fn fill(&mut self, bytes: &mut [u8], address: u8) -> Result<(), NoAnswer> {
        for byte in bytes.iter_mut() {
            *byte = (self.next() >> 32) as u8;
        }
        let known =
            self.known.iter().find(|(known, _)| *known == address).map_or(&[][..], |(_, known)| known);
        if self.mostly() {
            for (byte, known) in bytes.iter_mut().zip(known) {
                *byte = *known;
            }
        }
        // tags of the batched sensors, headers of packets
        let (item, tags): (_, &[u8]) = match address {
            0x78 => (7, &[0x08, 0x10, 0x18, 0x20]),
            0xb0 => (16, &[0x68]),
            _ => (usize::MAX, &[]),
        };
        for word in bytes.chunks_mut(item).filter(|_| !tags.is_empty()) {
            let tag = tags[self.next() as usize % tags.len()];
            word[0] =
                if self.mostly() { if item == 7 { tag | word[0] & 3 << 1 } else { tag } } else { word[0] };
        }
        if self.next().is_multiple_of(20) { Err(NoAnswer) } else { Ok(()) }
    }
}

impl i2c::ErrorType for Nonsense {
    type Error = NoAnswer;
}

impl I2c for Nonsense {
    fn transaction(&mut self, _: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), NoAnswer> {
        match operations {
            [i2c::Operation::Write(address), i2c::Operation::Read(bytes)] => self.fill(bytes, address[0]),
            _ => Ok(()),
        }
    }
}

impl spi::ErrorType for Nonsense {
    type Error = NoAnswer;
}

impl SpiDevice for Nonsense {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), NoAnswer> {
        match operations {
            [spi::Operation::Write(address), spi::Operation::Read(bytes)] => self.fill(bytes, address[0]),
            _ => Ok(()),
        }
    }
}

struct NoTime;

impl DelayNs for NoTime {
    fn delay_ns(&mut self, _: u32) {}
}

fn accepts_any_answers<P: Imu>(part: P) {
    let mut source = SampleSource::new(part);
    let mut random = Nonsense { state: 7, known: &[] };
    let mut now_us = 0;
    for _ in 0..20_000 {
        now_us = match random.next() % 1000 {
            0 => random.next(),
            step => u64::wrapping_add(now_us, step * 200),
        };
        if let Ok(samples) = poll_once(source.poll(now_us)).expect("done at once") {
            assert!(samples.len() <= MAX_SAMPLES);
            let flagged = samples.iter().filter(|raw| raw.skipped > 0);
            assert!(flagged.clone().all(|raw| raw.faults.contains(Faults::GAP)));
        }
    }
    let counts = source.counts();
    assert!(counts.samples > 100 && counts.damaged > 100 && counts.resets > 100, "{}: {counts:?}", P::NAME);
}

#[test]
fn accepts_any_bytes_and_any_clock() {
    let bus = |known| Blocking(Nonsense { state: 1, known });
    accepts_any_answers(Lsm6dsv16x::new(bus(LSM6DSV16X), Address::Low, Blocking(NoTime)));
    accepts_any_answers(Lsm6dso::new(bus(LSM6DSO), Address::Low, Blocking(NoTime)));
    accepts_any_answers(Bmi323::new(bus(BMI323), Blocking(NoTime)));
    accepts_any_answers(Icm42688::new(bus(ICM42688), Blocking(NoTime)));
}
