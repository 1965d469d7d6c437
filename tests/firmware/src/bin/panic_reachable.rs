//! Counter-check of `panic_free`: one index may be out of bounds, so that this must not link on the target.
//!
//! The only reason for the failure must be the missing `a_panic_can_be_reached`, which the panic handler calls.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "panic_free/image.rs"]
mod image;

#[cfg(target_os = "none")]
#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    use core::hint::black_box;

    image::exercise();
    black_box(black_box([1, 2, 3])[black_box(1_usize)]);
    loop {}
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("checked on the target: this must not link, for one index may be out of bounds");
}
