//! What the programs in `bin/` need of the machine they run on: an emulated board, or the host.
//!
//! Each is the same source on both, begins in its `run`, and says so by [`firmware!`]. Those that show by linking, or
//! by their size, need nothing of this.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(target_os = "none")]
mod board;
#[cfg(not(target_os = "none"))]
mod host;

#[cfg(target_os = "none")]
pub use board::*;
#[cfg(not(target_os = "none"))]
pub use host::*;
use io::{Read as _, Write as _};

/// The program begins in this function, on the board and on the host.
#[macro_export]
macro_rules! firmware {
    ($run:path) => {
        #[cfg(target_os = "none")]
        #[$crate::entry]
        fn entry() -> ! {
            $run();
            $crate::done()
        }

        #[cfg(not(target_os = "none"))]
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
    /// The timer of the Arm boards counts in steps of 1.25 instructions or so: finer is of no use.
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
