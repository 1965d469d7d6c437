//! The host in place of a board: the same source runs without counting.

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

/// Path in the form that opens files.
pub(super) fn as_path(path: &core::ffi::CStr) -> &std::path::Path {
    std::path::Path::new(path.to_str().unwrap_or_else(|error| fail(format_args!("{path:?}: {error}"))))
}

/// Runs `work`; the stack is measured on the emulated board only.
pub fn stack_of(work: impl FnOnce()) -> usize {
    work();
    0
}

/// Placeholder; instructions are counted on the emulated board only.
pub struct Instructions;

impl Instructions {
    /// Returns the placeholder.
    pub fn start() -> Self {
        Self
    }

    /// Runs `work`; returns NaN.
    pub fn of(&mut self, work: impl FnOnce()) -> f64 {
        work();
        f64::NAN
    }
}
