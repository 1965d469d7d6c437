//! A bus that loses, damages and invents data of a sensor, against the sample sources and the hub behind them: every
//! poll ends and gives finite values; after the bus is intact again, the samples are those of the sensor, without a
//! fault.
//!
//! The input has the part first, then the events: before a poll the time since the last one, at a transfer its fault.
#![no_main]
#![allow(dead_code, unused_macros, unused_imports, reason = "the simulated parts have more for others")]

#[path = "../../fos-embedded/tests/device/sample_source/simulated.rs"]
mod simulated;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_hal::i2c::{self, I2c};
use embedded_hal::spi::{self, SpiDevice};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::hub::Hub;
use fos_embedded::raw::RawSample;
use fos_embedded::sample_source::{
    Address, Bmi323, Icm42688, Imu, Lsm6dso, Lsm6dsv16x, MAX_SAMPLES, SampleSource,
};
use fos_parts::{Fault, generated};
use libfuzzer_sys::fuzz_target;
use simulated::{Board, Delay, I2cBus, NoAnswer, Shared, Simulated, SpiBus};

/// Polls until recovery: a source that has given up retries after 64 polls at most, and the sensor starts within two.
const RECOVERED_AFTER: usize = 80;

/// Number of polls then compared with the sensor.
const COMPARED: usize = 10;

/// Transfers per poll: three attempts that find it not set up take both checks, and setting it up takes 40.
const TRANSFERS_A_POLL: u64 = 150;

/// Remaining faults.
type Script = Rc<RefCell<VecDeque<u8>>>;

fn next(script: &Script) -> Option<u8> {
    script.borrow_mut().pop_front()
}

/// A faulty bus.
struct Hostile<B> {
    bus: B,
    script: Script,
}

impl<B> Hostile<B> {
    /// Performs a transfer, or not; `damage` changes the data read from a given position.
    fn transfer<T>(
        &mut self,
        transfer: &mut T,
        sound: impl Fn(&mut B, &mut T) -> Result<(), NoAnswer>,
        damage: impl Fn(&mut T, usize, u8),
    ) -> Result<(), NoAnswer> {
        match next(&self.script) {
            Some(0) => return Err(NoAnswer),
            Some(1) => sound(&mut self.bus, transfer).and(Err(NoAnswer)),
            // The transfer is lost without an error.
            Some(2) => return Ok(()),
            Some(wrong @ 3..64) => {
                sound(&mut self.bus, transfer)?;
                let place = usize::from(next(&self.script).unwrap_or(0));
                for byte in place..place + usize::from(wrong) - 2 {
                    damage(transfer, byte, next(&self.script).unwrap_or(0));
                }
                Ok(())
            }
            _ => sound(&mut self.bus, transfer),
        }
    }
}

impl<B> i2c::ErrorType for Hostile<B> {
    type Error = NoAnswer;
}

impl I2c for Hostile<I2cBus> {
    fn transaction(&mut self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), NoAnswer> {
        self.transfer(
            &mut &mut *operations,
            |bus, operations| bus.transaction(address, operations),
            |operations, place, byte| {
                if let Some(i2c::Operation::Read(read)) = operations.last_mut() {
                    read.get_mut(place).into_iter().for_each(|read| *read = byte);
                }
            },
        )
    }
}

/// Faulty bus over SPI.
struct HostileSpi(Hostile<SpiBus>);

impl spi::ErrorType for HostileSpi {
    type Error = NoAnswer;
}

impl SpiDevice for HostileSpi {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), NoAnswer> {
        self.0.transfer(
            &mut &mut *operations,
            |bus, operations| bus.transaction(operations),
            |operations, place, byte| {
                if let Some(spi::Operation::Read(read)) = operations.last_mut() {
                    read.get_mut(place).into_iter().for_each(|read| *read = byte);
                }
            },
        )
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((part, script)) = bytes.split_first() else { return };
    let script = Rc::new(RefCell::new(script.iter().copied().collect()));
    let i2c = |board: &Shared| Blocking(Hostile { bus: I2cBus(board.clone()), script: script.clone() });
    let spi = |board: &Shared| {
        Blocking(HostileSpi(Hostile { bus: SpiBus(board.clone()), script: script.clone() }))
    };
    let delay = |board: &Shared| Blocking(Delay(board.clone()));
    match part % 4 {
        0 => {
            let board = Board::new::<simulated::SimulatedLsm6dsv16x>();
            follow(&board, &script, Lsm6dsv16x::new(i2c(&board), Address::High, delay(&board)));
        }
        1 => {
            let board = Board::new::<simulated::SimulatedBmi323>();
            follow(&board, &script, Bmi323::new(spi(&board), delay(&board)));
        }
        2 => {
            let board = Board::new::<simulated::SimulatedLsm6dso>();
            follow(&board, &script, Lsm6dso::new(i2c(&board), Address::High, delay(&board)));
        }
        _ => {
            let board = Board::new::<simulated::SimulatedIcm42688>();
            follow(&board, &script, Icm42688::new(spi(&board), delay(&board)));
        }
    }
});

/// Polls as long as there are faults, and until the source must have recovered.
fn follow<P: Imu>(board: &Shared, script: &Script, part: P) {
    let mut hub: Hub<8, 64, 128> = Hub::new(P::scales());
    let mut source = SampleSource::new(part);
    let mut poll = |after_ms: u8| -> Vec<RawSample> {
        board.borrow_mut().pass(f64::from(after_ms) * 1000.0);
        let (now_us, transfers) = (board.borrow().now_us() as u64, board.borrow().transfers);
        let samples =
            poll_once(source.poll(now_us)).expect("done at once").map(<[_]>::to_vec).unwrap_or_default();
        assert!(samples.len() <= MAX_SAMPLES);
        assert!(board.borrow().transfers - transfers <= TRANSFERS_A_POLL, "a poll has no end");
        for sample in &samples {
            let output = hub.update(sample);
            assert!(output.corrected().iter().all(|value| value.is_finite()));
        }
        if !samples.is_empty() && !source.has_more() {
            hub.clock(now_us);
        }
        samples
    };
    while let Some(after_ms) = next(script) {
        if after_ms == 255 {
            board.borrow_mut().fault(Fault::Reset, 1.0);
        }
        poll(after_ms);
    }
    for _ in 0..RECOVERED_AFTER {
        poll(50);
    }
    for _ in 0..COMPARED {
        let samples = poll(50);
        assert!(samples.len() >= 9, "{} samples in 50 ms: the source does not recover", samples.len());
        let tick = board.borrow().tick() + 1;
        let first = (0..tick).rev().take(64).find(|n| generated(*n) == (samples[0].accel, samples[0].gyro));
        let first = first.expect("a sample that the sensor has not given");
        for (n, sample) in (first..).zip(&samples) {
            assert_eq!((sample.accel, sample.gyro), generated(n), "a sample that the sensor has not given");
            assert_eq!((sample.skipped, sample.faults.bits()), (0, 0), "{sample:?}");
        }
    }
}
