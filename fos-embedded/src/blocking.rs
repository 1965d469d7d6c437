//! Adapter from blocking to asynchronous peripherals, so that drivers need one source only.
//!
//! ```
//! use embedded_hal_async::i2c::I2c;
//! use fos_embedded::blocking::{Blocking, poll_once};
//!
//! async fn identity<B: I2c>(bus: &mut B) -> Result<u8, B::Error> {
//!     let mut id = [0];
//!     bus.write_read(0x6a, &[0x0f], &mut id).await?;
//!     Ok(id[0])
//! }
//!
//! fn identity_blocking<B: embedded_hal::i2c::I2c>(bus: B) -> Option<u8> {
//!     poll_once(identity(&mut Blocking(bus)))?.ok()
//! }
//! ```

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::{i2c, spi};
#[cfg(feature = "store")]
use embedded_storage::nor_flash;

/// A blocking bus, delay or flash as an asynchronous one, whose operations complete at the first poll.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Blocking<T>(pub T);

/// Polls a future once and returns its output; `None` if it is pending. Futures over [`Blocking`] complete at the first
/// poll.
pub fn poll_once<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}

impl<T: i2c::ErrorType> i2c::ErrorType for Blocking<T> {
    type Error = T::Error;
}

// every operation is forwarded: a HAL may implement it better than by its general transaction
impl<A: i2c::AddressMode, T: i2c::I2c<A>> embedded_hal_async::i2c::I2c<A> for Blocking<T> {
    async fn read(&mut self, address: A, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read(address, bytes)
    }

    async fn write(&mut self, address: A, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write(address, bytes)
    }

    async fn write_read(&mut self, address: A, out: &[u8], into: &mut [u8]) -> Result<(), Self::Error> {
        self.0.write_read(address, out, into)
    }

    async fn transaction(
        &mut self,
        address: A,
        operations: &mut [i2c::Operation<'_>],
    ) -> Result<(), Self::Error> {
        self.0.transaction(address, operations)
    }
}

impl<T: spi::ErrorType> spi::ErrorType for Blocking<T> {
    type Error = T::Error;
}

impl<W: Copy + 'static, T: spi::SpiDevice<W>> embedded_hal_async::spi::SpiDevice<W> for Blocking<T> {
    async fn transaction(&mut self, operations: &mut [spi::Operation<'_, W>]) -> Result<(), Self::Error> {
        self.0.transaction(operations)
    }
}

impl<T: embedded_hal::delay::DelayNs> embedded_hal_async::delay::DelayNs for Blocking<T> {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.delay_ns(ns);
    }

    async fn delay_us(&mut self, us: u32) {
        self.0.delay_us(us);
    }

    async fn delay_ms(&mut self, ms: u32) {
        self.0.delay_ms(ms);
    }
}

#[cfg(feature = "store")]
impl<T: nor_flash::ErrorType> nor_flash::ErrorType for Blocking<T> {
    type Error = T::Error;
}

#[cfg(feature = "store")]
impl<T: nor_flash::ReadNorFlash> embedded_storage_async::nor_flash::ReadNorFlash for Blocking<T> {
    const READ_SIZE: usize = T::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

#[cfg(feature = "store")]
impl<T: nor_flash::NorFlash> embedded_storage_async::nor_flash::NorFlash for Blocking<T> {
    const WRITE_SIZE: usize = T::WRITE_SIZE;
    const ERASE_SIZE: usize = T::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write(offset, bytes)
    }
}
