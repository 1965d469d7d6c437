//! What a panic does in an archive for a device: nothing can reach one, which `.ci/c panic` shows.

#[cfg(all(target_os = "none", not(fos_panic_check)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// An archive for the check: a C program in which a panic can be reached does not link.
#[cfg(fos_panic_check)]
mod check {
    unsafe extern "C" {
        /// Defined nowhere.
        safe fn a_panic_can_be_reached() -> !;
    }

    #[cfg(target_os = "none")]
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        a_panic_can_be_reached()
    }

    /// The counter-check: a program that calls this must not link.
    #[unsafe(no_mangle)]
    pub(super) extern "C" fn fos_panic_on_purpose(index: usize) -> i32 {
        [1, 2, 3][index]
    }
}
