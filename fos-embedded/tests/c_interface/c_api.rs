//! The C interface from Rust: every status of loading, the same numbers as the hub, frames that the host reads.
//! Errors that only C can make are in c/check.c.

use core::ffi::{CStr, c_char};
use core::ptr::null_mut;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Info, InnovationStatistics, Input, Model, Quantity, Range,
    Source, Term, Transform, Validity, u, y,
};
use fos_embedded::c_api::*;
use fos_embedded::hub::Hub;
use fos_embedded::raw::{Faults, RawSample, Scales, SiSample};
use fos_embedded::telemetry::{self, Frame};

const SCALES: fos_scales = fos_scales {
    accel_mps2: 0.001_197,
    gyro_rads: 0.000_305,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FOS_VALUES_RAW,
};

const TEMPERATURE: Input<f32> = Input {
    source: Source::Quantity(0),
    transform: Transform::Identity,
    centre: 25.0,
    scale: 5.0,
    source_range: Range::new(-4.0, 4.0),
    range: Range::new(-4.0, 4.0),
};

fn parameters(axis: Axis) -> AxisParameters<f32> {
    AxisParameters {
        axis,
        reference: 0.0,
        offset: 0.001,
        scale: 0.003,
        constant: 0.01,
        range: Range::new(-4.0, 4.0),
        physical_range: Range::unlimited(),
        full_scale: 0.0,
        stuck_after_repeats: 0,
        gap_limit_samples: 3,
        coast_limit_s: 2.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.5, lag_1_correlation: 0.0 },
    }
}

/// An image of gyro axes with these terms, over these inputs.
fn image(axes: &[Axis], terms: &[Term<f32>], quantities: &[Quantity], inputs: &[Input<f32>]) -> Vec<u8> {
    let axes: Vec<_> = axes
        .iter()
        .map(|axis| AxisModel { parameters: parameters(*axis), physical: &[], stochastic: terms })
        .collect();
    encode_model(axes.as_slice(), quantities, inputs)
}

fn encode_model(axes: &[AxisModel<'_, f32>], quantities: &[Quantity], inputs: &[Input<f32>]) -> Vec<u8> {
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities,
        inputs,
        axes,
    };
    let info = Info { quantities: "temp_c °C\nsupply_v V\nhumidity_pct %", ..Info::default() };
    encode(&model, &info, &mut [0; 32_768]).expect("an image").to_vec()
}

fn small() -> Vec<u8> {
    let terms = [Term::new(0.4, &[y(1)]), Term::new(0.1, &[u(0, 0)])];
    let quantities = [Quantity::Temperature, Quantity::Supply, Quantity::Other];
    image(&[Axis::Gx, Axis::Gz], &terms, &quantities, &[TEMPERATURE])
}

/// A hub with its memory.
struct Held {
    hub: *mut fos_hub,
    _memory: Vec<u64>,
}

fn made(scales: &fos_scales) -> Held {
    let mut memory = vec![u64::MAX; FOS_HUB_BYTES / 8];
    let mut hub = null_mut();
    // SAFETY: the memory has the stated length
    let status = unsafe { fos_hub_init(memory.as_mut_ptr().cast(), FOS_HUB_BYTES, scales, &mut hub) };
    assert_eq!(status, fos_status::Ok);
    Held { hub, _memory: memory }
}

fn load(held: &Held, image: &[u8]) -> fos_status {
    // SAFETY: a hub, and an image of the stated length
    unsafe { fos_hub_load(held.hub, image.as_ptr(), image.len()) }
}

#[test]
fn loading_returns_the_fault_of_the_model() {
    let good = small();
    let term = Term::new(0.1, &[y(1)]);
    let changed = |place: usize, value: u8| {
        let mut image = good.clone();
        image[place] = value;
        image
    };
    let more = [good.clone(), vec![0]].concat();
    let all = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];
    let seventeen = [Quantity::Supply; 17];
    let unbounded = Term::new(f32::MAX, &[y(1), y(2)]);
    let cases = [
        (good.clone(), fos_status::Ok),
        (good[..19].to_vec(), fos_status::Truncated),
        (good[..good.len() - 1].to_vec(), fos_status::Truncated),
        (changed(0, b'G'), fos_status::NotAnImage),
        (changed(4, good[4] + 1), fos_status::OtherVersion),
        (changed(6, 2), fos_status::OtherVersion),
        (changed(30, 0x55), fos_status::Damaged),
        (more, fos_status::TrailingBytes),
        (image(&[Axis::Gx], &[unbounded], &[], &[]), fos_status::Unusable),
        (image(&[], &[], &[], &[]), fos_status::Unusable),
        (image(&all, &[term; 22], &[], &[]), fos_status::TooLarge),
        (
            image(
                &[Axis::Gx],
                &[Term::new(0.1, &[y(200), y(255)])],
                &[Quantity::Temperature],
                &[TEMPERATURE],
            ),
            fos_status::TooLarge,
        ),
        (image(&[Axis::Gx], &[term], &[Quantity::Temperature], &[TEMPERATURE; 17]), fos_status::TooLarge),
        (image(&[Axis::Gx], &[term], &seventeen, &[]), fos_status::TooLarge),
        (image(&[Axis::Other], &[term], &[], &[]), fos_status::OtherAxis),
        (image(&[Axis::Gx, Axis::Gx], &[term], &[], &[]), fos_status::OtherAxis),
        (image(&[Axis::Gx], &[term], &[Quantity::Measured(Axis::Other)], &[]), fos_status::OtherQuantity),
    ];
    let held = made(&SCALES);
    for (n, (image, expected)) in cases.iter().enumerate() {
        assert_eq!(load(&held, image), *expected, "case {n}");
    }
    for (scales, expected) in [
        (fos_scales { values: FOS_VALUES_FACTORY_CORRECTED, ..SCALES }, fos_status::OtherValues),
        (fos_scales { period_s: 0.0057, ..SCALES }, fos_status::OtherPeriod),
        (fos_scales { period_s: 0.0044, ..SCALES }, fos_status::OtherPeriod),
        (fos_scales { period_s: 0.0053, ..SCALES }, fos_status::Ok),
    ] {
        assert_eq!(load(&made(&scales), &good), expected);
    }
}

#[test]
fn output_in_c_equals_the_output_of_the_hub() {
    let image = small();
    let held = made(&SCALES);
    assert_eq!(load(&held, &image), fos_status::Ok);
    let mut hub: Hub<FOS_MAX_INPUTS, FOS_MAX_TERMS, FOS_MAX_HISTORY> = Hub::new(Scales {
        accel_mps2: SCALES.accel_mps2,
        gyro_rads: SCALES.gyro_rads,
        temperature_k: SCALES.temperature_k,
        temperature_zero_c: SCALES.temperature_zero_c,
        period_s: SCALES.period_s,
        values: FittedOn::Raw,
    });
    hub.load(&image).expect("a model");
    let mut frame = [0; FOS_TELEMETRY_BYTES];
    for n in 0..200_i16 {
        let accel = [n, -n, 8192];
        let gyro = [n % 7, n % 5, if n == 90 { i16::MAX } else { -n }];
        let temperature = (n != 60).then_some(n);
        let raw = RawSample { accel, gyro, temperature, skipped: u32::from(n == 50), ..RawSample::default() };
        let in_c = fos_raw_sample {
            skipped: raw.skipped,
            accel,
            gyro,
            temperature: temperature.unwrap_or(0),
            faults: 0,
            has_temperature: u8::from(temperature.is_some()),
        };
        let motion = if n < 100 { FOS_MOTION_STILL } else { FOS_MOTION_MOVING };
        let mut output = core::mem::MaybeUninit::<fos_output>::uninit();
        let mut used = 0;
        // SAFETY: a hub, and places of the stated size
        let output = unsafe {
            assert_eq!(fos_hub_give(held.hub, FOS_QUANTITY_SUPPLY_V, 3.3), fos_status::Ok);
            assert_eq!(fos_hub_give_application(held.hub, 1, f32::from(n)), fos_status::Ok);
            assert_eq!(fos_hub_set_motion(held.hub, motion), fos_status::Ok);
            assert_eq!(fos_hub_update(held.hub, &in_c, output.as_mut_ptr()), fos_status::Ok);
            let status = fos_telemetry_sample(held.hub, frame.as_mut_ptr(), frame.len(), &mut used);
            assert_eq!(status, fos_status::Ok);
            output.assume_init()
        };
        hub.give_application(0, 3.3);
        hub.give_application(2, f32::from(n));
        hub.set_motion(Some(if n < 100 {
            fos_embedded::hub::Motion::Still
        } else {
            fos_embedded::hub::Motion::Moving
        }));
        let expected = *hub.update(&raw);
        let bits = |values: [f32; 6]| values.map(f32::to_bits);
        assert_eq!(output.tick, expected.tick);
        assert_eq!(bits(output.measured), bits(expected.measured));
        assert_eq!(bits(output.corrected), bits(expected.corrected()));
        assert_eq!(bits(output.innovation), bits(expected.innovation()));
        assert_eq!(output.temperature_c.to_bits(), expected.temperature_c.to_bits());
        assert_eq!(output.validity, expected.validity().map(|validity| validity.bits()));
        assert_eq!(output.faults, expected.faults.bits());
        assert_eq!((output.still, output.drift), (u8::from(expected.still), u8::from(expected.drift)));

        let decoded: Frame<String, Vec<f32>, Vec<u16>> =
            telemetry::decode(&mut frame[..used]).expect("a frame");
        let Frame::Sample(sample) = decoded else { panic!("not a sample") };
        assert_eq!((sample.tick, sample.still), (expected.tick, expected.still));
        assert_eq!(sample.measured, expected.measured);
        assert_eq!(sample.validity, output.validity);
        assert_eq!(sample.quantities[1..], [3.3, f32::from(n)]);
    }
}

#[test]
fn values_in_c_equal_the_values_of_the_hub() {
    let image = small();
    let mut scales = SCALES;
    // SAFETY: scales to write to
    let status = unsafe { fos_scales_of_full_scale(78.4, 34.9, 0.005, FOS_VALUES_RAW, &mut scales) };
    assert_eq!(status, fos_status::Ok);
    let of_full_scale = Scales::of_full_scale(78.4, 34.9, 0.005, FittedOn::Raw);
    let in_c = [scales.accel_mps2, scales.gyro_rads, scales.temperature_k, scales.temperature_zero_c];
    let in_rust = &of_full_scale;
    let in_rust = [in_rust.accel_mps2, in_rust.gyro_rads, in_rust.temperature_k, in_rust.temperature_zero_c];
    assert_eq!(in_c.map(f32::to_bits), in_rust.map(f32::to_bits));
    let held = made(&scales);
    assert_eq!(load(&held, &image), fos_status::Ok);
    let mut hub: Hub<FOS_MAX_INPUTS, FOS_MAX_TERMS, FOS_MAX_HISTORY> = Hub::new(of_full_scale);
    hub.load(&image).expect("a model");
    for n in 0..200_u16 {
        let x = f32::from(n);
        let sample = SiSample {
            skipped: u32::from(n == 50),
            accel: [x * 0.001, f32::NAN, if n == 90 { 80.0 } else { 9.8 }],
            gyro: [0.001 * x, if n == 91 { f32::INFINITY } else { 0.0 }, -0.0003 * x],
            temperature_c: if n == 60 { f32::NAN } else { 25.0 + 0.01 * x },
            faults: Faults::from_bits_truncate(u16::from(n == 70)),
        };
        let in_c = fos_si_sample {
            skipped: sample.skipped,
            accel: sample.accel,
            gyro: sample.gyro,
            temperature_c: sample.temperature_c,
            // an unknown bit is ignored
            faults: sample.faults.bits() | 0x8000,
        };
        let mut output = core::mem::MaybeUninit::<fos_si_output>::uninit();
        // SAFETY: a hub, and a place of the stated size
        let found = unsafe {
            assert_eq!(fos_hub_set_motion(held.hub, FOS_MOTION_STILL), fos_status::Ok);
            assert_eq!(fos_hub_update_si(held.hub, &in_c, output.as_mut_ptr()), fos_status::Ok);
            output.assume_init()
        };
        hub.set_motion(Some(fos_embedded::hub::Motion::Still));
        let expected = *hub.update_si(&sample);
        let bits = |values: [f32; 6]| values.map(f32::to_bits);
        let output = found.output;
        assert_eq!(bits(output.measured), bits(expected.measured));
        assert_eq!(bits(output.corrected), bits(expected.corrected()));
        assert_eq!(bits(output.innovation), bits(expected.innovation()));
        assert_eq!(output.temperature_c.to_bits(), expected.temperature_c.to_bits());
        assert_eq!(output.validity, expected.validity().map(|validity| validity.bits()));
        assert_eq!((output.tick, output.faults), (expected.tick, expected.faults.bits()));
        assert_eq!(bits(found.predicted), bits(expected.predicted()));
        assert!(n == 0 || found.predicted[FOS_GX] != 0.0, "the model predicts something");
    }
}

#[test]
fn telemetry_start_names_the_columns() {
    let image = small();
    let held = made(&SCALES);
    assert_eq!(load(&held, &image), fos_status::Ok);
    let mut frame = [0; FOS_TELEMETRY_BYTES];
    let mut used = 0;
    // SAFETY: a hub, an image and a buffer of the stated lengths
    let status = unsafe {
        fos_telemetry_start(held.hub, image.as_ptr(), image.len(), frame.as_mut_ptr(), frame.len(), &mut used)
    };
    assert_eq!(status, fos_status::Ok);
    let decoded: Frame<&str, (), ()> = telemetry::decode(&mut frame[..used]).expect("a frame");
    let Frame::Start(start) = decoded else { panic!("not a start") };
    assert_eq!(start.period_s, 0.005);
    assert_eq!(start.axes, "ax_mps2\nay_mps2\naz_mps2\ngx_rads\ngy_rads\ngz_rads");
    assert_eq!(start.quantities, "temp_c\nsupply_v\nhumidity_pct");
}

/// A static text of the interface.
fn text(text: *const c_char) -> &'static str {
    // SAFETY: it is never NULL, ends with a zero, and is static
    unsafe { CStr::from_ptr(text) }.to_str().unwrap()
}

#[test]
fn every_status_has_its_own_number_and_text() {
    let texts: Vec<_> =
        (0..=fos_status::OtherPart as i32).map(|status| text(fos_status_text(status))).collect();
    for (number, of_this) in texts.iter().enumerate() {
        assert!(!texts[..number].contains(of_this), "{number}: {of_this}");
        assert_ne!(*of_this, "unknown status");
    }
    for unknown in [-1, texts.len() as i32] {
        assert_eq!(text(fos_status_text(unknown)), "unknown status");
    }
}

#[test]
fn validity_has_the_same_name_in_c_and_rust() {
    for validity in Validity::all().iter() {
        let names: Vec<_> = validity.names().collect();
        assert_eq!(names, [text(fos_validity_text(validity.bits()))]);
    }
    assert_eq!(Validity::all().bits(), 2 * FOS_VALIDITY_AWAY_FROM_GRAVITY - 1, "one for every bit");
    assert_eq!(text(fos_validity_text(3)), "unknown validity");
    assert_eq!(text(fos_validity_text(4096)), "unknown validity");
}

#[test]
fn version_is_that_of_the_crate() {
    // SAFETY: a static text
    let version = unsafe { CStr::from_ptr(fos_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}
