//! An image without a panic: it links only if no call that a device makes can reach one.
//!
//! The panic handler calls a function that is defined nowhere. If the optimiser can prove that no panic is reached, the
//! handler is dropped with everything that leads to it, and the image links; otherwise the linker names the missing
//! function. `panic_reachable.rs` is the same with one index that may be out of bounds, and must not link.
//!
//! It requires the release profile of the device: link-time optimisation in one unit. On the host it does nothing.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(target_os = "none")]
#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    image::exercise();
    loop {}
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("checked on the target: the image links only if no panic can be reached");
}
