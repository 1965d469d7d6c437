//! The smallest firmware, to measure its size: without a hub, or with one of the features below. The difference in size
//! is the flash used by the code; a stored model comes on top.
//!
//! - `flash-hub`: decodes a stored model, then corrects, sample by sample.
//! - `flash-fixed`: the same in fixed point.
//! - `flash-compiled-in`: the model is compiled in: nothing is decoded, and nothing is checked that the compiler has checked.
//!
//! For the target; on the host it does nothing.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;

    use fos_core::{
        Axis, AxisModel, AxisParameters, CheckedModel, FittedOn, Fixed, InnovationStatistics, Model, Range,
        Scalar,
    };
    use fos_embedded::hub::{Hub, HubError};
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

    type Sized<R> = Hub<2, 72, 128, R>;

    fn with_hub<R: Scalar<Stored = f32>>(load: impl FnOnce(&mut Sized<R>) -> Result<(), HubError>) -> ! {
        let mut hub: Sized<R> = Hub::new(SCALES);
        black_box(load(&mut hub)).ok();
        loop {
            let _ = black_box(hub.update(&black_box(RawSample::default())));
            hub.clock(black_box(1));
        }
    }

    static AXES: [AxisModel<'static, f32>; 1] = [AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gz,
            reference: 0.0,
            offset: 0.01,
            scale: 0.002,
            constant: 0.0,
            range: Range::new(-4.0, 4.0),
            physical_range: Range::new(0.0, 0.0),
            full_scale: 4.36,
            stuck_after_repeats: 50,
            gap_limit_samples: 20,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics { mean: 0.0, variance: 0.2, lag_1_correlation: 0.0 },
        },
        physical: &[],
        stochastic: &[],
    }];

    static MODEL: CheckedModel<'static> = CheckedModel::new(Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[],
        inputs: &[],
        axes: &AXES,
    });

    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
    fn main() -> ! {
        if cfg!(feature = "flash-hub") {
            with_hub::<f32>(|hub| hub.load(black_box(&[0; 64])))
        } else if cfg!(feature = "flash-fixed") {
            with_hub::<Fixed>(|hub| hub.load(black_box(&[0; 64])))
        } else if cfg!(feature = "flash-compiled-in") {
            with_hub::<f32>(|hub| hub.load_checked(black_box(&MODEL)))
        } else {
            loop {
                black_box(([0.0_f32; 6], [0.0_f32; 2], true));
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("for the target: its size is what is looked at");
}
