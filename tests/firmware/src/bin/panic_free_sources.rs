//! The same check as `panic_free`, for the sources of samples and the drivers under them, over blocking buses.
//!
//! An `async fn` contains a panic for being polled again after completion. No `await` does that, but the optimiser can
//! prove it only if everything is in one function:
//!
//! ```text
//! DEVICE_RUSTFLAGS='-C opt-level=3 -C llvm-args=-inline-threshold=1000000' \
//!   device_build thumbv7em-none-eabihf --package fos-firmware --bin panic_free_sources
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use core::hint::black_box;

    use embedded_hal::delay::DelayNs;
    use embedded_hal::{i2c, spi};
    use fos_embedded::blocking::{Blocking, poll_once};
    use fos_embedded::sample_source::{Address, Bmi323, Icm42688, Imu, Lsm6dso, Lsm6dsv16x, SampleSource};

    unsafe extern "C" {
        /// Defined nowhere: an image in which a panic can be reached does not link.
        safe fn a_panic_can_be_reached() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        a_panic_can_be_reached()
    }

    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
    fn main() -> ! {
        run(Lsm6dsv16x::new(Blocking(Bus), Address::Low, Blocking(Wait)));
        run(Lsm6dso::new(Blocking(Bus), Address::Low, Blocking(Wait)));
        run(Bmi323::new(Blocking(Bus), Blocking(Wait)));
        run(Icm42688::new(Blocking(Bus), Blocking(Wait)));
        loop {}
    }

    fn run<P: Imu>(part: P) {
        let mut source = SampleSource::new(part);
        for _ in 0..black_box(5) {
            if let Some(Ok(samples)) = poll_once(source.poll(black_box(7))) {
                for raw in samples {
                    black_box(raw);
                }
            }
            black_box((source.has_more(), source.counts()));
        }
    }

    /// A bus unknown to the compiler: any bytes, any error.
    struct Bus;

    #[inline(never)]
    fn any(bytes: &mut [u8]) {
        for byte in bytes {
            *byte = black_box(0);
        }
    }

    impl i2c::ErrorType for Bus {
        type Error = i2c::ErrorKind;
    }

    impl i2c::I2c for Bus {
        fn transaction(
            &mut self,
            _: u8,
            operations: &mut [i2c::Operation<'_>],
        ) -> Result<(), i2c::ErrorKind> {
            for operation in operations {
                match operation {
                    i2c::Operation::Read(bytes) => any(bytes),
                    i2c::Operation::Write(bytes) => _ = black_box(bytes),
                }
            }
            black_box(Ok(()))
        }
    }

    impl spi::ErrorType for Bus {
        type Error = spi::ErrorKind;
    }

    impl spi::SpiDevice for Bus {
        fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
            for operation in operations {
                match operation {
                    spi::Operation::Read(bytes) => any(bytes),
                    spi::Operation::Write(bytes) => _ = black_box(bytes),
                    _ => {}
                }
            }
            black_box(Ok(()))
        }
    }

    struct Wait;

    impl DelayNs for Wait {
        fn delay_ns(&mut self, ns: u32) {
            black_box(ns);
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("checked on the target: the image links only if no panic can be reached");
}
