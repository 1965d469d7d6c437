//! An image with every kind of input, quantity and axis: the numbers that encode them in an image must never be
//! swapped.

use std::fmt::Write;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Image, Info, InnovationStatistics, Input, Model, Quantity,
    Range, Source, StillnessLimits, Term, Transform, u, y,
};

use super::formats::of_image;

const QUANTITIES: [Quantity; 10] = [
    Quantity::Temperature,
    Quantity::Other,
    Quantity::Supply,
    Quantity::Load,
    Quantity::MagneticX,
    Quantity::MagneticY,
    Quantity::MagneticZ,
    Quantity::Measured(Axis::Gy),
    Quantity::Reference(Axis::Az),
    Quantity::Reference(Axis::Other),
];

const AXES: [Axis; 6] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

/// Every transform, over every possible source.
const INPUTS: [(Source, Transform<f32>); 11] = [
    (Source::Quantity(0), Transform::Identity),
    (Source::Quantity(0), Transform::LowPass { tau_s: 0.3 }),
    (Source::Quantity(0), Transform::Rate { tau_s: 0.3 }),
    (Source::Quantity(7), Transform::Variance { tau_s: 0.2 }),
    (Source::Quantity(0), Transform::Backlash { half_width: 0.01 }),
    (Source::Quantity(7), Transform::Absolute),
    (Source::Clock, Transform::Decay { tau_s: 0.7 }),
    (Source::Clock, Transform::Time),
    (Source::Clock, Transform::Sine { frequency_hz: 16.37 }),
    (Source::Clock, Transform::Cosine { frequency_hz: 16.37 }),
    (Source::Remainder(3), Transform::LowPass { tau_s: 0.1 }),
];

/// Six axes, each over every input.
pub(crate) fn image() -> Vec<u8> {
    let inputs = INPUTS.map(|(source, transform)| Input {
        source,
        transform,
        centre: if source == Source::Quantity(0) { 25.0 } else { 0.0 },
        scale: if source == Source::Quantity(7) { 0.01 } else { 2.0 },
        source_range: Range::new(-4.0, 4.0),
        range: Range::new(-4.0, 4.0),
    });
    let physical: Vec<Term<f32>> =
        (0..10).map(|input| Term::new(0.05 + 0.01 * f32::from(input), &[u(input, 0)])).collect();
    let stochastic = [
        Term::new(0.4, &[y(1)]),
        Term::new(0.02, &[y(1), y(3)]),
        Term::new(0.1, &[u(10, 0)]),
        Term::new(0.03, &[y(2), u(1, 1), u(8, 0)]),
    ];
    let axes = AXES.map(|axis| {
        let (reference, offset, scale) = match axis {
            Axis::Az => (9.81, 0.05, 0.01),
            Axis::Ax | Axis::Ay => (0.0, 0.02, 0.01),
            _ => (0.0, 0.004, 0.002),
        };
        let innovation = InnovationStatistics { mean: 0.01, variance: 1.2, lag_1_correlation: -0.3 };
        let parameters = AxisParameters {
            axis,
            reference,
            offset,
            scale,
            constant: 0.1,
            range: Range::new(-5.0, 6.0),
            physical_range: Range::new(-2.5, 3.0),
            full_scale: 30.0,
            stuck_after_repeats: 12,
            gap_limit_samples: 7,
            coast_limit_s: 9.0,
            innovation,
        };
        AxisModel { parameters, physical: &physical, stochastic: &stochastic }
    });
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: Some(StillnessLimits {
            window: 40,
            accel_variance: 0.001,
            gyro_variance: 5e-5,
            gyro_at_rest: [0.004, 0.004, 0.004],
            gyro_deviation: 0.01,
        }),
        calibration: None,
        quantities: &QUANTITIES,
        inputs: &inputs,
        axes: &axes,
    };
    let quantities = QUANTITIES.map(|quantity| format!("{quantity:?}")).join("\n");
    let info = Info { sensor: "every kind", quantities: &quantities, effects: "none", provenance: "by hand" };
    encode(&model, &info, &mut [0; 4096]).expect("it fits").to_vec()
}

/// Outputs of an image, and its description of itself.
pub(crate) fn outputs(bytes: &[u8]) -> Result<String, String> {
    let mut outputs = of_image(bytes)?;
    let image = Image::parse(bytes).map_err(|error| error.to_string())?;
    for quantity in image.quantities() {
        let _ = writeln!(outputs, "quantity {quantity:?}");
    }
    for input in image.inputs() {
        let _ = writeln!(outputs, "input {:?} of {:?}", input.transform, input.source);
    }
    for axis in image.axes() {
        let _ = writeln!(outputs, "axis {:?}", axis.parameters.axis);
    }
    Ok(outputs)
}
