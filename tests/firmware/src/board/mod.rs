//! Emulated boards: the common part by semihosting, and the start and the timer of each core.

#[cfg(target_arch = "arm")]
mod arm;
mod end;
#[cfg(target_arch = "riscv32")]
mod riscv;

#[cfg(target_arch = "arm")]
use arm as machine;
#[cfg(target_arch = "riscv32")]
use riscv as machine;

pub use end::{done, fail};
pub use machine::entry;
use machine::{Timer, stack_pointer};
pub use semihosting::println;
pub(super) use semihosting::{fs, io};

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    println!("{info}");
    semihosting::process::exit(101)
}

/// Argument `index` of the program, copied into `buffer`; 0 is the program's name. An argument has no spaces.
pub fn argument(index: usize, buffer: &mut [u8; 1024]) -> Option<&core::ffi::CStr> {
    let arguments = match semihosting::experimental::env::args::<1024>() {
        Ok(arguments) => arguments,
        Err(error) => fail(format_args!("no arguments: {error}")),
    };
    let argument = (&arguments).nth(index)?.ok()?.as_bytes();
    buffer.get_mut(..argument.len())?.copy_from_slice(argument);
    *buffer.get_mut(argument.len())? = 0;
    core::ffi::CStr::from_bytes_until_nul(buffer).ok()
}

/// Path in the form that opens files.
pub(super) fn as_path(path: &core::ffi::CStr) -> &core::ffi::CStr {
    path
}

/// Number of bytes examined below the stack pointer.
const STACK: usize = 32_768;

const PAINT: u8 = 0xa5;

/// Stack used by `work`, bytes: the part of a painted stack that it overwrites.
#[inline(never)]
pub fn stack_of(work: impl FnOnce()) -> usize {
    // nothing below the stack pointer is in use, and neither loop calls anything
    let top = stack_pointer();
    let painted = core::ptr::with_exposed_provenance_mut::<u8>(top - STACK);
    let mut at = 0;
    while at < STACK {
        // SAFETY: nothing lies there: there are 512 KiB of RAM, and the stack is all that is so far up
        unsafe { painted.add(at).write_volatile(PAINT) };
        at += 1;
    }
    work();
    let mut untouched = 0;
    // SAFETY: as above
    while untouched < STACK && unsafe { painted.add(untouched).read_volatile() } == PAINT {
        untouched += 1;
    }
    STACK - untouched
}

/// Counts instructions by a timer: with `-icount shift=5` an instruction takes 32 ns in the emulator; 2000 instructions
/// at the start calibrate the number of instructions per tick.
pub struct Instructions {
    timer: Timer,
    a_tick: f64,
    /// Cost of counting itself, instructions.
    overhead: f64,
}

/// A separate function, since the constants of its caller would otherwise be too far away.
#[inline(never)]
fn two_thousand() {
    // SAFETY: it does nothing
    unsafe { core::arch::asm!(".rept 2000", "nop", ".endr") }
}

impl Instructions {
    /// Takes the timer, and calibrates its rate.
    pub fn start() -> Self {
        let mut counting = Self { timer: Timer::start(), a_tick: 1.0, overhead: 0.0 };
        let empty = counting.of(|| {});
        let ticks = counting.of(two_thousand);
        counting.a_tick = 2000.0 / (ticks - empty);
        counting.overhead = counting.of(|| {});
        counting
    }

    /// Number of instructions of `work`; it must be below 10 million.
    pub fn of(&mut self, work: impl FnOnce()) -> f64 {
        let ticks = self.timer.of(work);
        (f64::from(ticks) * self.a_tick - self.overhead).max(0.0)
    }
}
