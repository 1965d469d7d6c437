//! End of a program.

use semihosting::println;

/// Ends the program on a fault, which would otherwise hang.
pub(super) fn fault() -> ! {
    println!("hard fault");
    semihosting::process::exit(102)
}

/// Ends the program successfully.
pub fn done() -> ! {
    semihosting::process::exit(0)
}

/// Ends the program with an error.
pub fn fail(reason: core::fmt::Arguments<'_>) -> ! {
    println!("{reason}");
    semihosting::process::exit(1)
}
