//! A stored model: written, read back, and rejected when one bit is wrong.
//!
//! ```text
//! cargo run -p fos-core --example image
//! ```
//!
//! `fos export --image` writes such images of fitted models; docs/MODEL_FORMAT.md describes the format.

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Image, ImageError, Info, InnovationStatistics, Model,
    Predictor, Range, Sample, Term, y,
};

fn main() -> Result<(), ImageError> {
    let parameters = AxisParameters {
        axis: Axis::Gz,
        reference: 0.0,
        offset: 0.01,
        scale: 0.002,
        constant: 0.0,
        range: Range::new(-4.0, 4.0),
        physical_range: Range::new(0.0, 0.0),
        full_scale: 8.7,
        stuck_after_repeats: 50,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.2, lag_1_correlation: 0.0 },
    };
    let stochastic = [Term::new(1.2, &[y(1)]), Term::new(-0.3, &[y(2)])];
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[],
        inputs: &[],
        axes: &[AxisModel { parameters, physical: &[], stochastic: &stochastic }],
    };
    let mut buffer = [0; 512];
    let bytes = encode(&model, &Info { sensor: "a gyro", ..Info::default() }, &mut buffer)?;

    // on the device; `image.load` fills a predictor in place, for example in a `static`
    let image = Image::parse(bytes)?;
    println!("{} bytes of {}: {} axis", bytes.len(), image.info().sensor, image.axes().count());
    let mut predictor: Predictor<f32, 1, 0, 2, 4> = image.predictor()?;
    let correction = predictor.track(&Sample { measured: &[0.012], quantities: &[] })[0];
    assert!(correction.corrected.abs() < 0.0025);

    let mut damaged = bytes.to_vec();
    damaged[40] ^= 1;
    let refused = Image::parse(&damaged).err();
    println!("with one bit changed: {refused:?}");
    assert!(matches!(refused, Some(ImageError::Checksum { .. })));
    Ok(())
}
