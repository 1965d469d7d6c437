//! How a program ends.

use semihosting::println;

/// What should not happen ends the program, or it would hang.
pub(super) fn fault() -> ! {
    println!("hard fault");
    semihosting::process::exit(102)
}

/// Ends the program: all is well.
pub fn done() -> ! {
    semihosting::process::exit(0)
}

/// Ends the program with an error.
pub fn fail(reason: core::fmt::Arguments<'_>) -> ! {
    println!("{reason}");
    semihosting::process::exit(1)
}
