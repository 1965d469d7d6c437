//! Any bytes as a model image: refused, or a model with finite, bounded outputs and finite monitor values.
#![no_main]

use fos_core::image::{UNIT_HEADER_LENGTH, encode_unit, for_unit};
use fos_core::{Image, Monitor, Predictor, Sample};
use fos_fuzz::{sealed_image, split};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    run(bytes);
    let (information, body) = split(bytes);
    let image = sealed_image(body, information);
    run(&image);
    // One half as the record of a unit, the other as the image of its part.
    let mut unit = vec![0; image.len()];
    if let Ok(unit) = for_unit(&image, bytes, &mut unit) {
        run(unit);
    }
    let Ok(part) = Image::parse(&image) else { return };
    let values: Vec<f32> = part
        .axes()
        .flat_map(|axis| std::iter::repeat_n(axis.parameters.reference, 1 + axis.physical.count()))
        .collect();
    let mut record = vec![0; UNIT_HEADER_LENGTH + 4 * values.len()];
    let record = encode_unit(&image, "", values.into_iter(), &mut record).expect("as many values as it has");
    run(for_unit(&image, record, &mut unit).expect("its own record"));
});

fn run(bytes: &[u8]) {
    let Ok(image) = Image::parse(bytes) else { return };
    let _ = (
        image.info(),
        image.stillness(),
        image.fitted_on(),
        image.quantities().count(),
        image.inputs().count(),
    );
    for axis in image.axes() {
        let _ = (axis.physical.count(), axis.stochastic.count());
    }
    let Ok(mut predictor) = image.predictor::<f32, 6, 32, 256, 1024>() else { return };
    let of_axis = |axis: fos_core::image::AxisImage<'_>| Monitor::new(&axis.parameters, image.period_s());
    let mut monitors: Vec<Monitor<f32>> = image.axes().map(of_axis).collect();
    // Extreme inputs, with quiet periods between them.
    let hostile =
        [0.0, 1.0, f32::NAN, -f32::MAX, f32::INFINITY, 1e-40, 9.81, f32::MAX, -0.0, f32::NEG_INFINITY];
    for n in 0..400_usize {
        let value = |k: usize| {
            if n % 50 < 25 { 0.01 * ((n * 7 + k) % 13) as f32 } else { hostile[(n + k) % hostile.len()] }
        };
        let (measured, quantities) = ([0, 1, 2, 3, 4, 5].map(value), [6, 7, 8, 9].map(value));
        let sample = Sample { measured: &measured, quantities: &quantities };
        let found = match n % 7 {
            0..4 => predictor.track(&sample),
            4 => predictor.coast(&sample),
            5 => predictor.track_against(&sample, &quantities),
            _ => predictor.skip(n as u32 * 5),
        };
        for (axis, monitor) in found.iter().zip(&mut monitors) {
            let _ = monitor.update(axis);
            let statistics = monitor.statistics();
            assert!(
                statistics.mean.is_finite()
                    && statistics.variance.is_finite()
                    && statistics.lag_1_correlation.is_finite()
                    && monitor.mean_in_unit().is_finite()
                    && monitor.deviation_in_unit().is_finite(),
                "{n}: {monitor:?}"
            );
            // Models that could exceed this are refused.
            assert!(axis.predicted.abs() <= 1e30, "{n}: {axis:?}");
            assert!(
                axis.corrected.is_finite() && axis.innovation.is_none_or(f32::is_finite),
                "{n}: {axis:?}"
            );
        }
    }
    predictor.reset();
    let mut other: Predictor<f32, 1, 1, 1, 2> = Predictor::empty();
    let _ = image.load(&mut other);
}
