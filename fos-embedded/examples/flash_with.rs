//! The smallest firmware that corrects a sensor: it decodes a stored model, then tracks or coasts, sample by sample.
//!
//! Its size less that of `flash_without.rs`, the same without fos-core, is what the code takes of a device's flash. The
//! stored model comes on top. For the target; on the host there is nothing to see.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod firmware {
    use core::hint::black_box;

    use fos_core::{Image, Sample};

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let image = Image::parse(black_box(&[0; 64])).ok();
        let predictor = image.and_then(|image| image.predictor::<f32, 6, 16, 128, 256>().ok());
        let Some(mut predictor) = predictor else { loop {} };
        loop {
            let (measured, quantities, still) = black_box(([0.0; 6], [0.0; 2], true));
            let sample = Sample { measured: &measured, quantities: &quantities };
            black_box(if still { predictor.track(&sample) } else { predictor.coast(&sample) });
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("for the target: its size is what is looked at");
}
