//! The firmware of `flash_with.rs` without a model: what a device has anyway.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }

    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
    fn main() -> ! {
        loop {
            black_box(([0.0_f32; 6], [0.0_f32; 2], true));
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("for the target: its size is what is looked at");
}
