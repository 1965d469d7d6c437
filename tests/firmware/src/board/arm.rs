//! Cortex-M, on QEMU's mps2 and mps3 boards.

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};

pub use cortex_m_rt::entry;

#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    super::end::fault()
}

#[inline(always)]
pub(super) fn stack_pointer() -> usize {
    cortex_m::register::msp::read() as usize
}

/// SysTick: on the mps2 boards it runs at 25 MHz, on others at another rate.
pub(super) struct Timer(SYST);

impl Timer {
    pub(super) fn start() -> Self {
        let mut timer = match Peripherals::take() {
            Some(peripherals) => peripherals.SYST,
            None => super::end::fail(format_args!("the timer is taken")),
        };
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        Self(timer)
    }

    /// Number of ticks while `work` runs; the timer has 24 bits.
    #[inline(always)]
    pub(super) fn of(&mut self, work: impl FnOnce()) -> u32 {
        self.0.clear_current();
        let before = SYST::get_current();
        work();
        before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff
    }
}
