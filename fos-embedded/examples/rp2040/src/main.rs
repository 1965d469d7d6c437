//! A Raspberry Pi Pico with a BMI323: reads the sensor, removes its bias, sends every sample over a serial line, and receives
//! new models over the same line.
//!
//! | pin | use |
//! |---|---|
//! | GPIO0, GPIO1 | UART0: telemetry out, model images in; 921,600 baud |
//! | GPIO16 to GPIO19 | SPI0 to the BMI323: MISO, chip select, clock, MOSI |
//! | GPIO15 | high while a sample is computed, for an oscilloscope |
#![no_std]
#![no_main]

#[path = "../../device/mod.rs"]
mod device;

use core::ops::Range;

use cortex_m::singleton;
use device::Device;
use embassy_executor::Spawner;
use embassy_rp::flash::{self, ERASE_SIZE, Flash};
use embassy_rp::gpio::{Level, Output};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, FLASH, SPI0, UART0};
use embassy_rp::spi::{self, Spi};
use embassy_rp::uart::{self, BufferedInterruptHandler, BufferedUart};
use embassy_rp::watchdog::Watchdog;
use embassy_rp::{bind_interrupts, config, dma};
use embassy_time::{Delay, Duration, Instant, with_deadline};
use embedded_hal_bus::spi::ExclusiveDevice;
use embedded_io_async::Read as _;
use fos_core::Fixed;
use fos_embedded::blocking::Blocking;
use fos_embedded::sample_source::{Bmi323, Imu, SampleSource};

bind_interrupts!(struct Irqs {
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>, dma::InterruptHandler<DMA_CH1>;
    UART0_IRQ => BufferedInterruptHandler<UART0>;
});

/// Flash of the board. Its last four sectors hold the model images; memory.x keeps the program out of them.
const FLASH_BYTES: usize = 2 * 1024 * 1024;
const STORE: Range<u32> = (FLASH_BYTES - 4 * ERASE_SIZE) as u32..FLASH_BYTES as u32;

/// Interval of the polls. The FIFO of the sensor holds 0.64 s, and erasing a sector of the flash takes up to 0.4 s.
const POLL: Duration = Duration::from_millis(50);

/// A poll takes less than 0.5 s, also if the sensor fails, and storing an image less than 1.5 s.
const WATCHDOG: Duration = Duration::from_secs(2);

type Sensor = Bmi323<ExclusiveDevice<Spi<'static, SPI0, spi::Async>, Output<'static>, Delay>, Delay>;

// its future is a static, and so are the hub and the buffers in it
#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let board = embassy_rp::init(config::Config::default());
    let mut watchdog = Watchdog::new(board.WATCHDOG);
    watchdog.start(WATCHDOG);

    let mut bus = spi::Config::default();
    bus.frequency = 10_000_000;
    let (clock, mosi, miso) = (board.PIN_18, board.PIN_19, board.PIN_16);
    let bus = Spi::new(board.SPI0, clock, mosi, miso, board.DMA_CH0, board.DMA_CH1, Irqs, bus);
    let Ok(sensor) = ExclusiveDevice::new(bus, Output::new(board.PIN_17, Level::High), Delay);
    let mut source = SampleSource::new(Bmi323::new(sensor, Delay));

    // a poll sends up to 32 samples of 80 bytes; the largest image arrives while one is stored
    let Some(send) = singleton!(: [u8; 4096] = [0; 4096]) else { unreachable!("taken once") };
    let Some(receive) = singleton!(: [u8; 4096] = [0; 4096]) else { unreachable!("taken once") };
    let mut line = uart::Config::default();
    line.baudrate = 921_600;
    let (tx, rx) = (board.PIN_0, board.PIN_1);
    let line = BufferedUart::new(board.UART0, tx, rx, Irqs, send, receive, line);
    let (send, mut receive) = line.split();

    let flash = Blocking(Flash::<FLASH, flash::Blocking, FLASH_BYTES>::new_blocking(board.FLASH));
    // in fixed point, since the chip has no FPU
    let Ok(mut device) = Device::<Fixed, _, _>::new(Sensor::scales(), flash, STORE, send) else {
        unreachable!("whole sectors, four of them")
    };
    device.load().await;

    let mut computing = Output::new(board.PIN_15, Level::Low);
    loop {
        let now = Instant::now();
        watchdog.feed(WATCHDOG);
        // after an error no samples arrive; the next polls try again
        if let Ok(samples) = source.poll(now.as_micros()).await {
            for raw in samples {
                computing.set_high();
                device.update(raw);
                computing.set_low();
                device.send();
            }
            if !samples.is_empty() && !source.has_more() {
                device.clock(now.as_micros());
            }
        }
        let next = if source.has_more() { now } else { now + POLL };
        let mut bytes = [0; 64];
        while let Ok(received) = with_deadline(next, receive.read(&mut bytes)).await {
            // an error of the line damages a frame, which its checksum shows
            device.receive(bytes.get(..received.unwrap_or(0)).unwrap_or(&[])).await;
        }
    }
}

/// A panic ends in a reset by the watchdog.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
