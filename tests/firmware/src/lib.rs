//! Common interface of the programs in `bin/` to their machine: an emulated board, or the host.
//!
//! Each program has the same source on both, and starts in its `run`, given to [`firmware!`]. Programs that are tested
//! by linking, or by their size, do not use this.
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

/// Defines the entry point of the program on the board and on the host.
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

/// Statistics of the number of instructions over repeated runs.
pub struct Tally {
    /// Histogram with steps of [`Tally::STEP`].
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
    /// Step of the histogram; the timer of the Arm boards has a resolution of about 1.25 instructions.
    const STEP: usize = 4;

    /// Adds one run.
    pub fn add(&mut self, instructions: f64) {
        let step = (instructions as usize / Self::STEP).min(self.counts.len() - 1);
        self.counts[step] += 1;
        self.sum += instructions;
        self.n += 1;
        self.worst = self.worst.max(instructions);
    }

    /// Mean number of instructions; 0 without runs.
    pub fn mean(&self) -> f64 {
        self.sum / f64::from(self.n.max(1))
    }

    /// Median number of instructions, rounded down to the step; 0 without runs.
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

    /// Largest number of instructions.
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
    /// Opens a file for reading; ends the program on failure.
    pub fn open(path: &core::ffi::CStr) -> Self {
        match fs::File::open(as_path(path)) {
            Ok(file) => Self(file),
            Err(error) => fail(format_args!("{path:?}: {error}")),
        }
    }

    /// Creates or truncates a file for writing; ends the program on failure.
    pub fn create(path: &core::ffi::CStr) -> Self {
        match fs::File::create(as_path(path)) {
            Ok(file) => Self(file),
            Err(error) => fail(format_args!("{path:?}: {error}")),
        }
    }

    /// Writes all bytes; ends the program on failure.
    pub fn write(&mut self, bytes: &[u8]) {
        if let Err(error) = self.0.write_all(bytes) {
            fail(format_args!("cannot write: {error}"));
        }
    }

    /// Fills `buffer` as far as the file reaches; returns the number of bytes.
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
