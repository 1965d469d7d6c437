//! A hub in fixed point compared with one in f32.

use crate::models::{self, MADE, Made, Random, SCALES, SPREAD, TestHub, image, limits};
use fos_core::{
    Axis, AxisModel, CheckedModel, FittedOn, Fixed, Input, Model, ModelError, Quantity, Scalar, Validity,
};
use fos_embedded::hub::{AXES, Hub, HubError, Motion, Output};
use fos_embedded::raw::{Faults, RawSample, Scales, SiSample};
use fos_embedded::telemetry::Snapshot;

type FixedHub = Hub<8, 64, 128, Fixed>;

/// Hubs in f32 and in fixed point with the same model.
fn both(made: &Made<'_>) -> (TestHub, FixedHub) {
    let image = image(made);
    let (mut single, mut fixed) = (Hub::new(SCALES), Hub::new(SCALES));
    single.load(&image).expect("a model for this sensor");
    fixed.load(&image).expect("it fits");
    single.give(Quantity::Supply, 3.3);
    fixed.give(Quantity::Supply, 3.3);
    (single, fixed)
}

/// Largest difference, in steps of 2⁻²³ of the axis' unit.
fn steps_apart(a: &[f32; AXES], b: &[f32; AXES]) -> f32 {
    let steps =
        |(a, b): (&f32, &f32)| if a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() * 8_388_608.0 };
    a.iter().zip(b).map(steps).fold(0.0, f32::max)
}

/// Twice the rounding of f32 (24 bits) at 39 m/s², the full scale of the accelerometers, in steps of 2⁻²³.
const FEW: f32 = 64.0;

#[test]
fn output_agrees_with_f32() {
    let (mut single, mut fixed) = both(&Made { stillness: Some(limits()), ..MADE });
    let mut random = Random(7);
    let (mut still, mut otherwise, mut furthest) = (0, 0, 0.0_f32);
    for n in 0..60_000_u32 {
        let mut raw = random.at_rest();
        if n % 5000 > 4000 {
            raw.gyro[1] += (3000.0 * random.next()) as i16;
        }
        if random.next() > 0.999 {
            raw.skipped = 1 + (40.0 * (1.0 + random.next())) as u32;
        }
        if random.next() > 0.99 {
            raw.temperature = None;
        }
        if random.next() > 0.999 {
            raw.accel[0] = i16::MAX;
        }
        let (a, b) = (*single.update(&raw), *fixed.update(&raw));
        still += u32::from(a.still);
        assert_eq!((a.still, a.faults, a.drift, a.tick), (b.still, b.faults, b.drift, b.tick), "sample {n}");
        // a remainder on the edge of its range may be inside it in only one of the two
        otherwise += u32::from(a.validity() != b.validity());
        furthest = furthest.max(steps_apart(&a.corrected(), &b.corrected()));
        assert_eq!(a.innovation().map(f32::is_nan), b.innovation().map(f32::is_nan), "sample {n}");
    }
    println!("still {still} of 60000, decided differently {otherwise}, furthest {furthest} steps");
    assert!((20_000..59_000).contains(&still), "{still}");
    assert!(otherwise < 3, "{otherwise}");
    assert!(furthest > 0.0 && furthest < FEW, "{furthest}");
    for axis in models::SIX {
        let (a, b) = (single.statistics(axis).expect("modelled"), fixed.statistics(axis).expect("modelled"));
        assert!((a.variance - b.variance).abs() < 1e-4 * a.variance, "{axis:?}: {a:?} {b:?}");
        assert!((a.mean - b.mean).abs() < 1e-4 && (a.lag_1_correlation - b.lag_1_correlation).abs() < 1e-4);
        let (a, b) =
            (single.deviation_ratio(axis).expect("modelled"), fixed.deviation_ratio(axis).expect("modelled"));
        assert!((a - b).abs() < 1e-4 * a);
    }
    let (a, b): (Snapshot<4>, Snapshot<4>) =
        (Snapshot::new(single.output(), &single.logged()), Snapshot::new(fixed.output(), &fixed.logged()));
    let (a, b) = (a.frame(), b.frame());
    assert_eq!((a.tick, a.still, a.validity), (b.tick, b.still, b.validity));
    assert_eq!(a.quantities, b.quantities);
}

#[test]
fn drift_is_detected_in_the_same_sample() {
    let (mut single, mut fixed) = both(&Made { axes: &[Axis::Gx], ..MADE });
    single.set_motion(Some(Motion::Still));
    fixed.set_motion(Some(Motion::Still));
    let mut random = Random(9);
    let mut alarm = None;
    for n in 0..20_000 {
        let mut raw = random.at_rest();
        if n > 8000 {
            raw.gyro[0] += (2.0 * SPREAD[3] / SCALES.gyro_rads) as i16;
        }
        let (a, b) = (single.update(&raw).drift, fixed.update(&raw).drift);
        assert_eq!(a, b, "sample {n}");
        if a && alarm.is_none() {
            alarm = Some(n);
        }
    }
    assert!(alarm.is_some_and(|n| n > 8000), "{alarm:?}");
    assert_eq!(single.drift(Axis::Gx), fixed.drift(Axis::Gx));
}

#[test]
fn accepts_and_flags_any_values() {
    let (mut single, mut fixed) = both(&Made { stillness: Some(limits()), ..MADE });
    let mut random = Random(3);
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 256.0, -256.0, 255.9, 0.0, 1e-30];
    let pick = |usual: f32, random: &mut Random| match (random.next() * 100.0) as i32 {
        99 => wild[((random.next() + 1.0) * 4.99) as usize],
        _ => usual,
    };
    for n in 0..40_000 {
        let raw = random.at_rest();
        let usual = SCALES.measured(&raw);
        let measured = usual.map(|usual| pick(usual, &mut random));
        let [ax, ay, az, gx, gy, gz] = measured;
        let temperature_c = pick(25.0, &mut random);
        let sample = SiSample {
            skipped: 0,
            accel: [ax, ay, az],
            gyro: [gx, gy, gz],
            temperature_c,
            faults: Faults::empty(),
        };
        let (a, b) = (*single.update_si(&sample), *fixed.update_si(&sample));
        finite(&b);
        for ((a, b), value) in a.validity().iter().zip(b.validity()).zip(measured) {
            // an infinite value is at full scale in fixed point, and not finite in f32
            if value.is_nan() || value.is_finite() {
                assert_eq!(
                    a.contains(Validity::NOT_FINITE),
                    b.contains(Validity::NOT_FINITE),
                    "sample {n}: {value}"
                );
                assert_eq!(
                    a.contains(Validity::SATURATED),
                    b.contains(Validity::SATURATED),
                    "sample {n}: {value}"
                );
            } else {
                assert!(
                    b.intersects(Validity::NOT_FINITE | Validity::SATURATED),
                    "sample {n}: {value} {b:?}"
                );
            }
        }
    }
}

fn finite(output: &Output<Fixed>) {
    assert!(output.corrected().iter().all(|value| value.is_finite()), "{output:?}");
    assert!(output.predicted().iter().all(|value| value.is_finite()), "{output:?}");
    assert!(output.corrections.iter().all(|axis| axis.innovation.is_none_or(Fixed::is_finite)), "{output:?}");
}

#[test]
fn passes_measured_values_without_a_model() {
    let mut hub: FixedHub = Hub::new(SCALES);
    let mut random = Random(1);
    let raw = random.at_rest();
    let output = *hub.update(&raw);
    assert!(steps_apart(&output.corrected(), &SCALES.measured(&raw)) <= 1.0);
    assert!(output.validity().iter().all(|validity| *validity == Validity::NOT_MODELLED));
    // with a sensor of 32 g or more, full scale is the end of the fixed-point range
    let wide = Scales { accel_mps2: 0.0098, ..SCALES };
    let mut hub: FixedHub = Hub::new(wide);
    let output = *hub.update(&RawSample { accel: [26_400, 0, -26_400], ..raw });
    let [x, y, z, ..] = output.validity();
    assert!(x.contains(Validity::SATURATED) && z.contains(Validity::SATURATED), "{output:?}");
    assert!(!y.contains(Validity::SATURATED), "{output:?}");
    finite(&output);
}

#[test]
fn rejected_model_leaves_the_hub_without_a_model() {
    let (_, mut hub) = both(&MADE);
    let [temperature, supply] = models::inputs();
    let axes = models::SIX.map(|axis| AxisModel {
        parameters: models::parameters(axis),
        physical: &models::PHYSICAL,
        stochastic: &models::STOCHASTIC,
    });
    let (fits, pressure) = ([temperature, supply], [temperature, Input { centre: 1013.0, ..supply }]);
    assert_eq!(hub.load_model(&model(&fits, &axes)), Ok(()));
    // a pressure in hPa exceeds the range
    let refused = ModelError::InputNotInFixedPoint { input: 1 };
    assert_eq!(hub.load_model(&model(&pressure, &axes)), Err(HubError::Image(refused.into())));
    assert_eq!(TestHub::new(SCALES).load_model(&model(&pressure, &axes)), Ok(()), "f32 has it");
    let output = hub.update(&Random(1).at_rest());
    assert!(output.validity().iter().all(|validity| *validity == Validity::NOT_MODELLED));
}

#[test]
fn checked_model_runs_to_the_bits_of_the_same_model() {
    fn agrees<R: Scalar<Stored = f32>>(model: &Model<'_, f32>) {
        let (mut checked, mut other): (Hub<8, 64, 128, R>, Hub<8, 64, 128, R>) =
            (Hub::new(SCALES), Hub::new(SCALES));
        assert_eq!(checked.load_checked(&CheckedModel::new(*model)), other.load_model(model));
        let mut random = Random(11);
        for _ in 0..2000 {
            let raw = random.at_rest();
            let (a, b) = (checked.update(&raw), other.update(&raw));
            assert_eq!(a.corrected().map(f32::to_bits), b.corrected().map(f32::to_bits));
            assert_eq!(a.validity(), b.validity());
        }
    }
    let [temperature, supply] = models::inputs();
    let axes = models::SIX.map(|axis| AxisModel {
        parameters: models::parameters(axis),
        physical: &models::PHYSICAL,
        stochastic: &models::STOCHASTIC,
    });
    // in hPa it exceeds the range of fixed point
    for supply in [supply, Input { centre: 1013.0, ..supply }] {
        let inputs = [temperature, supply];
        agrees::<f32>(&model(&inputs, &axes));
        agrees::<Fixed>(&model(&inputs, &axes));
    }
}

fn model<'a>(inputs: &'a [Input<f32>], axes: &'a [AxisModel<'a, f32>]) -> Model<'a, f32> {
    Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[Quantity::Temperature, Quantity::Other],
        inputs,
        axes,
    }
}
