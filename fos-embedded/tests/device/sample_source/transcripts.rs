//! Bus traffic, byte by byte, in blocking and asynchronous form.

mod bmi323;
mod icm42688;
mod lsm6dso;
mod lsm6dsv16x;

use core::fmt::Debug;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::{i2c, spi};
use embedded_hal_mock::eh1;
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::raw::{Faults, RawSample};
use fos_embedded::sample_source::{
    Address, Bmi323, Counts, Icm42688, Imu, Lsm6dso, Lsm6dsv16x, SampleSource, SourceError,
};

/// A bus transfer or delay.
#[derive(Debug, Clone)]
enum Step {
    /// Writes bytes from a register on.
    Write(u8, Vec<u8>),
    /// Reads bytes from a register on.
    Read(u8, Vec<u8>),
    /// A read of a number of bytes from a register on, without an answer.
    NoAnswer(u8, usize),
    /// A delay, µs.
    Wait(u32),
}
use Step::{NoAnswer, Read, Wait, Write};

const ADDRESS: u8 = 0x6a;

fn delay(steps: &[Step]) -> eh1::delay::CheckedDelay {
    let waits = steps.iter().filter_map(|step| match step {
        Wait(us) => Some(eh1::delay::Transaction::delay_us(*us)),
        _ => None,
    });
    eh1::delay::CheckedDelay::new(&waits.collect::<Vec<_>>())
}

fn i2c_bus(steps: &[Step]) -> eh1::i2c::Mock {
    use eh1::i2c::Transaction;
    let nack = i2c::ErrorKind::NoAcknowledge(i2c::NoAcknowledgeSource::Address);
    let transfers = steps.iter().filter_map(|step| match step {
        Write(register, bytes) => {
            Some(Transaction::write(ADDRESS, [vec![*register], bytes.clone()].concat()))
        }
        Read(register, bytes) => Some(Transaction::write_read(ADDRESS, vec![*register], bytes.clone())),
        NoAnswer(register, bytes) => {
            Some(Transaction::write_read(ADDRESS, vec![*register], vec![0; *bytes]).with_error(nack))
        }
        Wait(_) => None,
    });
    eh1::i2c::Mock::new(&transfers.collect::<Vec<_>>())
}

fn spi_bus(steps: &[Step]) -> eh1::spi::Mock<u8> {
    use eh1::spi::Transaction;
    let transfers = steps.iter().flat_map(|step| match step {
        Write(register, bytes) => {
            let written = [vec![*register], bytes.clone()].concat();
            vec![
                Transaction::transaction_start(),
                Transaction::write_vec(written),
                Transaction::transaction_end(),
            ]
        }
        Read(register, bytes) => vec![
            Transaction::transaction_start(),
            Transaction::write_vec(vec![0x80 | *register]),
            Transaction::read_vec(bytes.clone()),
            Transaction::transaction_end(),
        ],
        NoAnswer(..) => panic!("SPI has no acknowledge"),
        Wait(_) => vec![],
    });
    eh1::spi::Mock::new(&transfers.collect::<Vec<_>>())
}

/// A bus or delay whose operations complete at the second poll.
struct Yielding<T>(T);

async fn yield_once() {
    let mut polled = false;
    core::future::poll_fn(move |_| {
        if polled {
            return Poll::Ready(());
        }
        polled = true;
        Poll::Pending
    })
    .await;
}

impl<T: i2c::ErrorType> i2c::ErrorType for Yielding<T> {
    type Error = T::Error;
}

impl<T: embedded_hal_async::i2c::I2c> embedded_hal_async::i2c::I2c for Yielding<T> {
    async fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), T::Error> {
        yield_once().await;
        self.0.write(address, bytes).await
    }

    async fn write_read(&mut self, address: u8, out: &[u8], into: &mut [u8]) -> Result<(), T::Error> {
        yield_once().await;
        self.0.write_read(address, out, into).await
    }

    async fn transaction(&mut self, _: u8, _: &mut [i2c::Operation<'_>]) -> Result<(), T::Error> {
        unreachable!("not called by the driver")
    }
}

impl<T: spi::ErrorType> spi::ErrorType for Yielding<T> {
    type Error = T::Error;
}

impl<T: embedded_hal_async::spi::SpiDevice> embedded_hal_async::spi::SpiDevice for Yielding<T> {
    async fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), T::Error> {
        yield_once().await;
        self.0.transaction(operations).await
    }
}

impl<T: embedded_hal_async::delay::DelayNs> embedded_hal_async::delay::DelayNs for Yielding<T> {
    async fn delay_ns(&mut self, ns: u32) {
        yield_once().await;
        self.0.delay_ns(ns).await;
    }

    async fn delay_us(&mut self, us: u32) {
        yield_once().await;
        self.0.delay_us(us).await;
    }

    async fn delay_ms(&mut self, ms: u32) {
        yield_once().await;
        self.0.delay_ms(ms).await;
    }
}

/// Output of a future, and the number of polls that returned pending.
fn block_on<T>(future: impl Future<Output = T>) -> (T, usize) {
    let mut future = pin!(future);
    let mut pending = 0;
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return (output, pending);
        }
        pending += 1;
    }
}

type Polls = Vec<Result<Vec<RawSample>, SourceError<String>>>;

/// Replaces an error of the bus by its name.
fn named<E: Debug>(
    polled: Result<&[RawSample], SourceError<E>>,
) -> Result<Vec<RawSample>, SourceError<String>> {
    polled.map(<[_]>::to_vec).map_err(|error| match error {
        SourceError::Bus(error) => SourceError::Bus(format!("{error:?}")),
        SourceError::WrongPart(id) => SourceError::WrongPart(id),
        SourceError::VerifyFailed { register, written, read } => {
            SourceError::VerifyFailed { register, written, read }
        }
        SourceError::Resting(polls) => SourceError::Resting(polls),
        other => panic!("{other:?}"),
    })
}

/// Polls every 50 ms in blocking form.
fn blocking<P: Imu>(part: P, polls: usize) -> (P, Polls, Counts) {
    let mut source = SampleSource::new(part);
    let times = (1..=polls as u64).map(|poll| poll * 50_000);
    let polls = times.map(|now_us| named(poll_once(source.poll(now_us)).expect("done at once"))).collect();
    let counts = source.counts();
    (source.release(), polls, counts)
}

/// Polls every 50 ms in a form that is suspended at every transfer.
fn yielding<P: Imu>(part: P, polls: usize, steps: usize) -> (P, Polls, Counts) {
    let mut source = SampleSource::new(part);
    let mut pending = 0;
    let polls = (1..=polls as u64).map(|poll| {
        let (polled, times) = block_on(source.poll(poll * 50_000));
        pending += times;
        named(polled)
    });
    let polls = polls.collect();
    assert_eq!(pending, steps, "suspended once a step");
    let counts = source.counts();
    (source.release(), polls, counts)
}

/// Defines a function that polls a part in both forms and returns the result, which is the same.
macro_rules! in_both_forms {
    ($name:ident: $part:ident, $bus:ident $(, $address:expr)?) => {
        fn $name(polls: usize, steps: &[Step]) -> (Polls, Counts) {
            let part = $part::new(Blocking($bus(steps)), $($address,)? Blocking(delay(steps)));
            let (part, result, counts) = blocking(part, polls);
            let (Blocking(mut bus), Blocking(mut waits)) = part.release();
            bus.done();
            waits.done();
            let part = $part::new(Yielding($bus(steps)), $($address,)? Yielding(delay(steps)));
            let (part, again, counts_again) = yielding(part, polls, steps.len());
            let (Yielding(mut bus), Yielding(mut waits)) = part.release();
            bus.done();
            waits.done();
            assert_eq!((&result, counts), (&again, counts_again));
            (result, counts)
        }
    };
}

in_both_forms!(lsm6dsv16x: Lsm6dsv16x, i2c_bus, Address::Low);
in_both_forms!(lsm6dso: Lsm6dso, i2c_bus, Address::Low);
in_both_forms!(bmi323: Bmi323, spi_bus);
in_both_forms!(icm42688: Icm42688, spi_bus);

/// A sample without faults, encoded by the words below.
fn sample(n: i16) -> RawSample {
    let (skipped, faults) = (0, Faults::empty());
    RawSample { skipped, accel: [n, -2, 8192], gyro: [3, -n, -32768], temperature: Some(-256), faults }
}

fn bytes(words: &[i16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
