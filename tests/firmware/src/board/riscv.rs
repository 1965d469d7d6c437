//! RISC-V, on QEMU's virt board.

pub use riscv_rt::entry;

/// Handler of riscv-rt for exceptions and interrupts without a handler of their own.
#[unsafe(no_mangle)]
extern "C" fn abort() -> ! {
    super::end::fault()
}

#[inline(always)]
pub(super) fn stack_pointer() -> usize {
    let pointer;
    // SAFETY: it only reads the register
    unsafe { core::arch::asm!("mv {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}

/// Counter of retired instructions, which QEMU 7 reports in ns of its clock.
pub(super) struct Timer;

impl Timer {
    pub(super) fn start() -> Self {
        Self
    }

    /// Number of ticks while `work` runs, modulo 2³².
    #[inline(always)]
    pub(super) fn of(&mut self, work: impl FnOnce()) -> u32 {
        let before = riscv::register::minstret::read();
        work();
        riscv::register::minstret::read().wrapping_sub(before) as u32
    }
}
