//! RISC-V, on QEMU's virt board.

pub use riscv_rt::entry;

/// Of riscv-rt: where exceptions and interrupts go that nobody has asked for.
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

/// The count of instructions retired, which QEMU 7 gives in ns of its clock.
pub(super) struct Timer;

impl Timer {
    pub(super) fn start() -> Self {
        Self
    }

    /// Ticks while `work` runs, to 32 bits.
    #[inline(always)]
    pub(super) fn of(&mut self, work: impl FnOnce()) -> u32 {
        let before = riscv::register::minstret::read();
        work();
        riscv::register::minstret::read().wrapping_sub(before) as u32
    }
}
