//! An nRF52840 development kit with an LSM6DSV16X: sleeps until the sensor has samples, removes their bias, sends them over a
//! serial line, and receives new models over the same line.
//!
//! | pin | use |
//! |---|---|
//! | P0.06, P0.08 | UARTE0 to the debugger of the kit: telemetry out, model images in; 1,000,000 baud |
//! | P0.26, P0.27 | TWIM0 to the LSM6DSV16X: SDA, SCL; 400 kHz |
//! | P1.03 | INT1 of the LSM6DSV16X |
//! | P1.04 | high while a sample is computed, for an oscilloscope |
#![no_std]
#![no_main]

mod clock;
#[path = "../../device/mod.rs"]
mod device;
mod line;

use core::ops::Range;

use clock::Clock;
use cortex_m::singleton;
use device::Device;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_nrf::buffered_uarte::{self, BufferedUarte};
use embassy_nrf::config::{HfclkSource, LfclkSource};
use embassy_nrf::gpio::{Input, Level, Output, OutputDrive, Pull};
use embassy_nrf::gpiote::{InputChannel, InputChannelPolarity};
use embassy_nrf::nvmc::{FLASH_SIZE, Nvmc, PAGE_SIZE};
use embassy_nrf::peripherals::{TWISPI0, UARTE0};
use embassy_nrf::ppi::Ppi;
use embassy_nrf::timer::{Frequency, Timer};
use embassy_nrf::twim::{self, Twim};
use embassy_nrf::uarte::{self, Baudrate};
use embassy_nrf::wdt::{self, HaltConfig, Watchdog};
use embassy_nrf::{bind_interrupts, config};
use embassy_time::{Delay, Duration, Instant, with_deadline};
use fos_embedded::blocking::Blocking;
use fos_embedded::sample_source::{Address, INTERRUPT_SAMPLES, Imu, Lsm6dsv16x, SampleSource};
use line::Line;

bind_interrupts!(struct Irqs {
    TWISPI0 => twim::InterruptHandler<TWISPI0>;
    UARTE0 => buffered_uarte::InterruptHandler<UARTE0>;
});

/// Pages of the flash for the model images; memory.x keeps the program out of them.
const STORE: Range<u32> = (FLASH_SIZE - 4 * PAGE_SIZE) as u32..FLASH_SIZE as u32;

/// Longest time without a poll, twice the interval of the interrupts: an interrupt may be missing. The FIFO of the sensor holds
/// 0.42 s, and erasing a page of the flash takes 85 ms.
const POLL: Duration = Duration::from_millis(100);

/// A poll takes less than 0.5 s if the sensor fails, and storing an image less than 0.5 s. A transfer on I2C that never ends, because
/// the sensor holds a line low, ends here too. 32,768 ticks per second.
const WATCHDOG_TICKS: u32 = 2 * 32_768;

type Sensor = Lsm6dsv16x<Twim<'static>, Delay>;

// its future is a static, and so are the hub and the buffers in it
#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let mut clocks = config::Config::default();
    clocks.hfclk_source = HfclkSource::ExternalXtal;
    clocks.lfclk_source = LfclkSource::ExternalXtal;
    let mut board = embassy_nrf::init(clocks);

    let mut watchdog = wdt::Config::default();
    watchdog.timeout_ticks = WATCHDOG_TICKS;
    watchdog.action_during_debug_halt = HaltConfig::Pause;
    let Ok((_, [mut watchdog])) = Watchdog::try_new(board.WDT, watchdog) else {
        unreachable!("every reset but that of a pin stops it")
    };

    free_bus(
        &Input::new(board.P0_26.reborrow(), Pull::Up),
        &mut Output::new(board.P0_27.reborrow(), Level::High, OutputDrive::Standard0Disconnect1),
    );
    let mut bus = twim::Config::default();
    bus.frequency = twim::Frequency::K400;
    bus.sda_pullup = true;
    bus.scl_pullup = true;
    // settings of the sensor may lie in flash, which its DMA cannot read
    let Some(buffer) = singleton!(: [u8; 8] = [0; 8]) else { unreachable!("taken once") };
    let bus = Twim::new(board.TWISPI0, Irqs, board.P0_26, board.P0_27, bus, buffer);
    let mut source = SampleSource::new(Sensor::new(bus, Address::Low, Delay).with_interrupt());

    // the rising edge of INT1 copies the timer without the processor
    let timer = Timer::new(board.TIMER0);
    timer.set_frequency(Frequency::F1MHz);
    timer.start();
    let mut clock = Clock::new();
    let mut interrupt =
        InputChannel::new(board.GPIOTE_CH0, board.P1_03, Pull::Down, InputChannelPolarity::LoToHi);
    let (now, rose) = (timer.cc(0), timer.cc(1));
    let mut stamp = Ppi::new_one_to_one(board.PPI_CH0, interrupt.event_in(), rose.task_capture());
    stamp.enable();

    // a poll sends up to 32 samples of 80 bytes; the largest image arrives while one is stored
    let Some(send) = singleton!(: [u8; 4096] = [0; 4096]) else { unreachable!("taken once") };
    let Some(receive) = singleton!(: [u8; 4096] = [0; 4096]) else { unreachable!("taken once") };
    let mut line = uarte::Config::default();
    line.baudrate = Baudrate::Baud1m;
    let line = BufferedUarte::new(
        board.UARTE0,
        board.TIMER1,
        board.PPI_CH1,
        board.PPI_CH2,
        board.PPI_GROUP0,
        board.P0_08,
        board.P0_06,
        Irqs,
        line,
        receive,
        send,
    );
    let (mut receive, send) = line.split();

    let flash = Blocking(Nvmc::new(board.NVMC));
    let Ok(mut device) = Device::<f32, _, _>::new(Sensor::scales(), flash, STORE, Line(send)) else {
        unreachable!("whole pages, four of them")
    };
    device.load().await;

    let mut computing = Output::new(board.P1_04, Level::Low, OutputDrive::Standard);
    // time at which INT1 rose, µs
    let mut rose_us = None;
    // samples since the FIFO was empty
    let mut count = 0;
    loop {
        let now_us = clock.time_us(now.capture());
        watchdog.pet();
        // after an error no samples arrive; the next polls try again
        let mut responds = false;
        if let Ok(samples) = source.poll(now_us).await {
            responds = !samples.is_empty();
            for raw in samples {
                computing.set_high();
                device.update(raw);
                computing.set_low();
                device.send();
                count += 1;
                // the pin rose at this sample
                if count == INTERRUPT_SAMPLES
                    && let Some(at_us) = rose_us.take()
                {
                    device.clock(at_us);
                }
            }
        }
        if source.has_more() {
            continue;
        }
        count = 0;
        rose_us = None;
        let next = Instant::now() + POLL;
        loop {
            let mut bytes = [0; 64];
            let edge = async {
                // the pin may stay high after an error
                if !responds {
                    core::future::pending::<()>().await;
                }
                interrupt.wait_for_high().await;
            };
            match with_deadline(next, select(edge, receive.read(&mut bytes))).await {
                Ok(Either::First(())) => {
                    rose_us = Some(clock.time_us(rose.read()));
                    break;
                }
                // an error of the line damages a frame, which its checksum shows
                Ok(Either::Second(received)) => {
                    device.receive(bytes.get(..received.unwrap_or(0)).unwrap_or(&[])).await;
                }
                Err(_) => break,
            }
        }
    }
}

/// Clocks the sensor to the end of a byte that it was sending when the chip was reset: until then it holds SDA low for every zero,
/// and no transfer can begin.
fn free_bus(sda: &Input<'_>, scl: &mut Output<'_>) {
    // eight bits and the one for the acknowledgement
    for _ in 0..9 {
        if sda.is_high() {
            break;
        }
        // 100 kHz, at 64 cycles per µs
        scl.set_low();
        cortex_m::asm::delay(5 * 64);
        scl.set_high();
        cortex_m::asm::delay(5 * 64);
    }
}

/// A panic ends in a reset by the watchdog.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
