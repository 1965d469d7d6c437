//! The smallest firmware with a hub: it decodes a stored model, then corrects, sample by sample.
//!
//! Its size less that of `flash_without.rs`, the same without a hub, is what the code takes of a device's flash; the
//! stored model comes on top. For the target; on the host there is nothing to see.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;

    use fos_core::FittedOn;
    use fos_embedded::hub::Hub;
    use fos_embedded::raw::{RawSample, Scales};

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }

    const SCALES: Scales = Scales {
        accel_mps2: 0.001_197,
        gyro_rads: 0.000_305,
        temperature_k: 1.0 / 256.0,
        temperature_zero_c: 25.0,
        period_s: 0.005,
        values: FittedOn::Raw,
    };

    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
    fn main() -> ! {
        let mut hub: Hub<2, 72, 128> = Hub::new(SCALES);
        black_box(hub.load(black_box(&[0; 64]))).ok();
        loop {
            let _ = black_box(hub.update(&black_box(RawSample::default())));
            hub.clock(black_box(1));
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("for the target: its size is what is looked at");
}
