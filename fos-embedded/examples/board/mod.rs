//! The emulated board: where a program begins and ends there, and how it says something.
//!
//! On a board of your own, the start-up of its HAL takes this place.

pub(crate) use semihosting::println;

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn entry() -> ! {
    crate::run();
    semihosting::process::exit(0)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    println!("{info}");
    semihosting::process::exit(101)
}
