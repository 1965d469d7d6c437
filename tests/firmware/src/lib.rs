//! What the programs in `bin/` need of the machine they run on: the emulated board, or the host.
//!
//! Each is the same source on both, begins in its `run`, and says so by [`firmware!`]. Those that show by linking, or
//! by their size, need nothing of this.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub use board::*;
#[cfg(not(all(target_arch = "arm", target_os = "none")))]
pub use host::*;
use io::{Read as _, Write as _};

/// The program begins in this function, on the board and on the host.
#[macro_export]
macro_rules! firmware {
    ($run:path) => {
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        #[$crate::entry]
        fn entry() -> ! {
            $run();
            $crate::done()
        }

        #[cfg(not(all(target_arch = "arm", target_os = "none")))]
        fn main() {
            $run();
        }
    };
}

/// How many instructions something took, again and again.
pub struct Tally {
    /// By steps of [`Tally::STEP`].
    counts: [u32; 16_384],
    sum: f64,
    n: u32,
    worst: f64,
}

impl Default for Tally {
    fn default() -> Self {
        Self { counts: [0; 16_384], sum: 0.0, n: 0, worst: 0.0 }
    }
}

impl Tally {
    /// The timer counts in steps of 1.25 instructions or so: finer is of no use.
    const STEP: usize = 4;

    /// Once more, so many.
    pub fn add(&mut self, instructions: f64) {
        let step = (instructions as usize / Self::STEP).min(self.counts.len() - 1);
        self.counts[step] += 1;
        self.sum += instructions;
        self.n += 1;
        self.worst = self.worst.max(instructions);
    }

    /// Instructions, on average; 0 of nothing.
    pub fn mean(&self) -> f64 {
        self.sum / f64::from(self.n.max(1))
    }

    /// Instructions, to the step below; 0 of nothing.
    pub fn median(&self) -> usize {
        let mut left = self.n / 2;
        for (step, count) in self.counts.iter().enumerate() {
            if *count > left {
                return step * Self::STEP;
            }
            left -= count;
        }
        0
    }

    /// Instructions, at most.
    pub fn worst(&self) -> usize {
        self.worst as usize
    }
}

impl core::fmt::Display for Tally {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if self.n == 0 {
            return f.write_str("none");
        }
        write!(f, "median {}, mean {:.0}, worst {}", self.median(), self.mean(), self.worst())
    }
}

/// A file of the host.
pub struct File(fs::File);

impl File {
    /// For reading; the program ends if it cannot be.
    pub fn open(path: &core::ffi::CStr) -> Self {
        match fs::File::open(as_path(path)) {
            Ok(file) => Self(file),
            Err(error) => fail(format_args!("{path:?}: {error}")),
        }
    }

    /// For writing, anew; the program ends if it cannot be.
    pub fn create(path: &core::ffi::CStr) -> Self {
        match fs::File::create(as_path(path)) {
            Ok(file) => Self(file),
            Err(error) => fail(format_args!("{path:?}: {error}")),
        }
    }

    /// All of it, or the program ends.
    pub fn write(&mut self, bytes: &[u8]) {
        if let Err(error) = self.0.write_all(bytes) {
            fail(format_args!("cannot write: {error}"));
        }
    }

    /// Fills as much of `buffer` as the file has left; how much.
    pub fn read(&mut self, buffer: &mut [u8]) -> usize {
        let mut filled = 0;
        while filled < buffer.len() {
            match self.0.read(&mut buffer[filled..]) {
                Ok(0) => break,
                Ok(read) => filled += read,
                Err(error) => fail(format_args!("cannot read: {error}")),
            }
        }
        filled
    }
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod board {
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m::peripheral::{Peripherals, SYST};

    pub use semihosting::println;
    pub(super) use semihosting::{fs, io};

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        println!("{info}");
        semihosting::process::exit(101)
    }

    #[cortex_m_rt::exception]
    unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
        println!("hard fault");
        semihosting::process::exit(102)
    }

    pub use cortex_m_rt::entry;

    /// Ends the program: all is well.
    pub fn done() -> ! {
        semihosting::process::exit(0)
    }

    /// Ends the program with an error.
    pub fn fail(reason: core::fmt::Arguments<'_>) -> ! {
        println!("{reason}");
        semihosting::process::exit(1)
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

    /// A path as files are opened by.
    pub(super) fn as_path(path: &core::ffi::CStr) -> &core::ffi::CStr {
        path
    }

    /// So many bytes below the stack pointer are looked at.
    const STACK: usize = 32_768;

    const PAINT: u8 = 0xa5;

    /// Bytes of stack that `work` takes: what it overwrites of a painted stack.
    #[inline(never)]
    pub fn stack_of(work: impl FnOnce()) -> usize {
        // nothing below the stack pointer is in use, and neither loop calls anything
        let top = cortex_m::register::msp::read() as usize;
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

    /// Counts instructions by SysTick: with `-icount shift=5` the emulator takes 32 ns an instruction, and the timer
    /// of the mps2 boards runs at 25 MHz, other boards' at another rate: 2000 instructions at the start tell.
    pub struct Instructions {
        timer: SYST,
        a_tick: f64,
        /// What counting itself costs.
        overhead: f64,
    }

    /// A function of its own, or constants of its caller would lie too far away.
    #[inline(never)]
    fn two_thousand() {
        // SAFETY: it does nothing
        unsafe { core::arch::asm!(".rept 2000", "nop", ".endr") }
    }

    impl Instructions {
        /// Takes the timer, and finds out how fast it goes.
        pub fn start() -> Self {
            let mut timer = match Peripherals::take() {
                Some(peripherals) => peripherals.SYST,
                None => fail(format_args!("the timer is taken")),
            };
            timer.set_clock_source(SystClkSource::Core);
            timer.set_reload(0x00ff_ffff);
            timer.clear_current();
            timer.enable_counter();
            let mut counting = Self { timer, a_tick: 1.0, overhead: 0.0 };
            let empty = counting.of(|| {});
            let ticks = counting.of(two_thousand);
            counting.a_tick = 2000.0 / (ticks - empty);
            counting.overhead = counting.of(|| {});
            counting
        }

        /// Instructions that `work` takes; it must take fewer than 10 million.
        pub fn of(&mut self, work: impl FnOnce()) -> f64 {
            self.timer.clear_current();
            let before = SYST::get_current();
            work();
            let ticks = before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
            (f64::from(ticks) * self.a_tick - self.overhead).max(0.0)
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
mod host {
    pub use std::println;
    pub(super) use std::{fs, io};

    /// Ends the program with an error.
    pub fn fail(reason: core::fmt::Arguments<'_>) -> ! {
        println!("{reason}");
        std::process::exit(1)
    }

    /// Argument `index` of the program, copied into `buffer`; 0 is the program's name.
    pub fn argument(index: usize, buffer: &mut [u8; 1024]) -> Option<&core::ffi::CStr> {
        let argument = std::env::args().nth(index)?;
        buffer.get_mut(..argument.len())?.copy_from_slice(argument.as_bytes());
        *buffer.get_mut(argument.len())? = 0;
        core::ffi::CStr::from_bytes_until_nul(buffer).ok()
    }

    /// A path as files are opened by.
    pub(super) fn as_path(path: &core::ffi::CStr) -> &std::path::Path {
        std::path::Path::new(path.to_str().unwrap_or_else(|error| fail(format_args!("{path:?}: {error}"))))
    }

    /// The stack is looked at on the emulated board only.
    pub fn stack_of(work: impl FnOnce()) -> usize {
        work();
        0
    }

    /// Instructions are counted on the emulated board only.
    pub struct Instructions;

    impl Instructions {
        /// There is nothing to start.
        pub fn start() -> Self {
            Self
        }

        /// Runs `work`; there is no count.
        pub fn of(&mut self, work: impl FnOnce()) -> f64 {
            work();
            f64::NAN
        }
    }
}
