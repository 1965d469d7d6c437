//! The firmware of `flash_with.rs` without a model: what a device has anyway.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod firmware {
    use core::hint::black_box;

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        loop {
            black_box(([0.0_f32; 6], [0.0_f32; 2], true));
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("for the target: its size is what is looked at");
}
