//! Panic handler of an archive for a device. No code can reach a panic, which `.ci/c panic` verifies.

#[cfg(all(target_os = "none", not(fos_panic_check)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Archive for the check: a C program in which a panic can be reached does not link.
#[cfg(fos_panic_check)]
mod check {
    unsafe extern "C" {
        /// Undefined on purpose.
        safe fn a_panic_can_be_reached() -> !;
    }

    #[cfg(target_os = "none")]
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        a_panic_can_be_reached()
    }

    /// Counter-check: a program that calls this must not link.
    #[unsafe(no_mangle)]
    pub(super) extern "C" fn fos_panic_on_purpose(index: usize) -> i32 {
        [1, 2, 3][index]
    }
}
