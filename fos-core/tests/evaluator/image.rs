//! The stored model: written images read back, and everything else is rejected.

mod layout;

use fos_core::image::{HEADER_LENGTH, encode};
use fos_core::{
    Axis, AxisParameters, Calibration, FittedOn, Image, ImageError, Info, InnovationStatistics, Input,
    ModelError, Quantity, Range, Sample, Source, StillnessLimits, Term, Transform, TriadCalibration, u, y,
};
use fos_testkit::models::{Draw, OwnedAxis, OwnedModel, Roomy, cases, models};
use fos_testkit::noise::Noise;
use layout::{INFO, assemble, bytes, crc_32, sealed};
use proptest::prelude::*;

fn encoded(model: &OwnedModel<f32>, info: &Info<'_>) -> Vec<u8> {
    let mut buffer = [0; 65536];
    model.borrow(|model| encode(model, info, &mut buffer).unwrap().to_vec())
}

fn example() -> Vec<u8> {
    encoded(&layout::model(), &INFO)
}

type Device<'a> = Result<fos_core::Predictor<f32, 2, 4, 16, 2048>, ImageError>;

fn on_device(image: &[u8]) -> Device<'_> {
    Image::parse(image)?.predictor()
}

fn refusal(image: &[u8]) -> ImageError {
    let error = Image::parse(image).unwrap_err();
    assert!(!error.to_string().is_empty());
    error
}

// ---- writing ----

#[test]
fn encoder_follows_the_format() {
    let expected = assemble(&bytes(&layout::body()), &bytes(&layout::information()));
    assert_eq!(example(), expected);
}

#[test]
fn document_shows_the_encoded_image() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/MODEL_FORMAT.md");
    let document = std::fs::read_to_string(path).unwrap();
    let begin = "<!-- dump -->\n```text\n";
    let (_, rest) = document.split_once(begin).expect("the document has a dump");
    let (shown, _) = rest.split_once("```").unwrap();
    let now = layout::dump();
    assert!(shown == now, "docs/MODEL_FORMAT.md shows another image; it is now\n\n{now}");
}

#[test]
fn checksum_is_crc_32_of_ethernet() {
    // the check value of CRC-32/ISO-HDLC in Williams' catalogue
    assert_eq!(crc_32(b"123456789"), 0xcbf4_3926);
}

#[test]
fn calibration_follows_the_head() {
    let number = |n: u8| 0.125 * f32::from(n);
    let triad = |first: u8| TriadCalibration {
        matrix: [0, 3, 6].map(|row| [0, 1, 2].map(|column| number(first + row + column))),
        bias: [9, 10, 11].map(|n| number(first + n)),
    };
    let calibration = Calibration { accel: triad(1), gyro: triad(13) };
    let model = OwnedModel { calibration: Some(calibration), ..layout::model() };
    let image = encoded(&model, &INFO);
    let mut body = bytes(&layout::body());
    let head = body.split_off(38);
    body.extend((1..=24).flat_map(|n| number(n).to_le_bytes()));
    body.extend(head);
    let mut expected = assemble(&body, &bytes(&layout::information()));
    expected[6] = 1;
    assert_eq!(image, sealed(expected));
    let parsed = Image::parse(&image).unwrap();
    assert_eq!(parsed.calibration(), Some(calibration));
    assert!(parsed.quantities().eq(model.quantities.iter().copied()));
    assert_eq!(Image::parse(&example()).unwrap().calibration(), None);
    assert!(on_device(&image).is_ok());

    for wrong in [f32::NAN, f32::INFINITY, 4.1] {
        let mut accel = triad(1);
        accel.matrix[1][2] = wrong;
        let model = OwnedModel { calibration: Some(Calibration { accel, ..calibration }), ..layout::model() };
        let error = on_device(&encoded(&model, &INFO)).unwrap_err();
        assert_eq!(error, ImageError::Model(ModelError::Calibration), "{wrong}");
    }
    let mut cut = image;
    cut[6] = 3;
    assert_eq!(refusal(&sealed(cut)), ImageError::UnknownFlags(3));
}

#[test]
fn rejects_every_buffer_that_is_too_small() {
    let image = example();
    for length in 0..image.len() {
        let mut buffer = vec![0; length];
        let result = layout::model().borrow(|model| encode(model, &INFO, &mut buffer).map(|_| ()));
        assert_eq!(result, Err(ImageError::TooLarge), "{length}");
    }
    let mut buffer = vec![0xaa; image.len() + 3];
    layout::model().borrow(|model| assert_eq!(encode(model, &INFO, &mut buffer).unwrap(), image));
    assert_eq!(buffer[image.len()..], [0xaa; 3]);
}

#[test]
fn rejects_more_than_255_of_anything() {
    let changes: [fn(&mut OwnedModel<f32>); 5] = [
        |model| model.quantities = vec![Quantity::Other; 256],
        |model| model.inputs = vec![model.inputs[0]; 256],
        |model| model.axes = vec![model.axes[0].clone(); 256],
        |model| model.axes[0].physical = vec![Term::new(1.0, &[u(0, 0)]); 256],
        |model| model.axes[0].stochastic = vec![Term::new(1.0, &[y(1)]); 256],
    ];
    for change in changes {
        let mut model = layout::model();
        change(&mut model);
        let mut buffer = vec![0; 100_000];
        let result = model.borrow(|model| encode(model, &INFO, &mut buffer).map(|_| ()));
        assert_eq!(result, Err(ImageError::TooLarge));
    }
}

// ---- reading ----

/// Runs both over the same series and compares the bits.
fn assert_same(mut a: Roomy<f32>, mut b: Roomy<f32>, n_axes: usize, seed: u64) -> Result<(), TestCaseError> {
    let mut noise = Noise::new(seed);
    for n in 0..200 {
        let measured: Vec<f32> = (0..n_axes).map(|_| noise.normal() as f32).collect();
        let quantities = [0; 3].map(|_| noise.normal() as f32);
        let sample = Sample { measured: &measured, quantities: &quantities };
        let (a, b) = if n % 50 < 30 {
            (a.track(&sample), b.track(&sample))
        } else {
            (a.coast(&sample), b.coast(&sample))
        };
        prop_assert_eq!(a, b, "{}", n);
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn model_from_its_image_gives_the_same_bits(model in models(Draw::Contracting), seed in any::<u64>()) {
        let model = model.convert::<f32>();
        let image = encoded(&model, &INFO);
        let read = Image::parse(&image).unwrap();
        assert_same(read.predictor().unwrap(), model.predictor().unwrap(), model.axes.len(), seed)?;
        // in f64 the model has exactly the numbers of f32
        let wide: Roomy<f64> = read.predictor().unwrap();
        let same: Roomy<f64> = model.convert::<f64>().predictor().unwrap();
        prop_assert_eq!(format!("{wide:?}"), format!("{same:?}"));
        // reading and writing again gives the same image
        prop_assert_eq!(encoded(&owned(&read), &read.info()), image);
    }

    #[test]
    fn rejects_random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(Image::parse(&bytes).is_err());
    }

    #[test]
    fn random_body_is_rejected_or_runs(body in prop::collection::vec(any::<u8>(), 0..300)) {
        run_if_read(&assemble(&body, &bytes(&layout::information())));
    }

    #[test]
    fn randomly_changed_image_is_rejected_or_runs(
        changes in prop::collection::vec((20_usize..400, any::<u8>()), 1..6)
    ) {
        let mut image = example();
        let length = image.len();
        for (place, byte) in changes {
            image[HEADER_LENGTH + place % (length - HEADER_LENGTH)] = byte;
        }
        run_if_read(&sealed(image));
    }
}

/// Every accepted image can be inspected and run, with finite output.
fn run_if_read(image: &[u8]) {
    let Ok(read) = Image::parse(image) else { return };
    let _ = (owned(&read), read.info(), read.fitted_on());
    let Ok(mut predictor) = read.predictor::<f32, 2, 4, 16, 2048>() else { return };
    for n in 0..20 {
        let sample = Sample { measured: &[0.01, 9.8], quantities: &[30.0, n as f32] };
        for correction in predictor.track(&sample) {
            assert!(correction.predicted.is_finite() && correction.corrected.is_finite());
        }
    }
}

/// The model in an image, read through its iterators.
fn owned(image: &Image<'_>) -> OwnedModel<f32> {
    let axes = image.axes().map(|axis| OwnedAxis {
        parameters: axis.parameters,
        physical: axis.physical.collect(),
        stochastic: axis.stochastic.collect(),
    });
    OwnedModel {
        period_s: image.period_s(),
        stillness: image.stillness(),
        calibration: None,
        quantities: image.quantities().collect(),
        inputs: image.inputs().collect(),
        axes: axes.collect(),
    }
}

// ---- rejection ----

#[test]
fn detects_truncation_at_every_length() {
    let image = example();
    for length in 0..image.len() {
        let needed = if length < HEADER_LENGTH { HEADER_LENGTH } else { image.len() };
        assert_eq!(refusal(&image[..length]), ImageError::Truncated { needed, found: length });
    }
}

#[test]
fn rejects_every_single_bit_flip() {
    let image = example();
    for bit in 0..8 * image.len() {
        let mut flipped = image.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Image::parse(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn rejects_other_magic_version_and_flags() {
    let with = |place: usize, byte: u8| {
        let mut image = example();
        image[place] = byte;
        refusal(&sealed(image))
    };
    assert_eq!(with(0, b'G'), ImageError::Magic);
    assert_eq!(with(4, 2), ImageError::UnknownVersion(2));
    assert_eq!(with(4, 0), ImageError::UnknownVersion(0));
    assert_eq!(with(5, 1), ImageError::UnknownVersion(257));
    assert_eq!(with(6, 2), ImageError::UnknownFlags(2));
    assert_eq!(with(7, 0x80), ImageError::UnknownFlags(0x8000));
}

#[test]
fn lengths_that_overflow_are_truncated() {
    let mut image = example();
    image[8..16].fill(0xff);
    assert!(matches!(refusal(&sealed(image)), ImageError::Truncated { .. }));
}

#[test]
fn wrong_checksum_reports_both_values() {
    let mut image = example();
    let computed = u32::from_le_bytes(image[16..20].try_into().unwrap());
    image[16] ^= 0x10;
    assert_eq!(refusal(&image), ImageError::Checksum { stored: computed ^ 0x10, computed });
}

#[test]
fn rejects_trailing_bytes_everywhere() {
    let (body, information) = (bytes(&layout::body()), bytes(&layout::information()));
    let longer = |bytes: &[u8]| [bytes, &[0, 0][..]].concat();
    let too_many = ImageError::TrailingBytes { count: 2 };
    assert_eq!(refusal(&longer(&example())), too_many);
    assert_eq!(refusal(&assemble(&longer(&body), &information)), too_many);
    assert_eq!(refusal(&assemble(&body, &longer(&information))), too_many);
    assert!(Image::parse(&assemble(&body, &information)).is_ok());
}

#[test]
fn truncated_body_or_information_is_malformed() {
    let (body, information) = (bytes(&layout::body()), bytes(&layout::information()));
    for length in 0..body.len() {
        assert_eq!(refusal(&assemble(&body[..length], &information)), ImageError::Malformed, "{length}");
    }
    for length in 0..information.len() {
        assert_eq!(refusal(&assemble(&body, &information[..length])), ImageError::Malformed, "{length}");
    }
    // a byte moved from one to the other
    let (first, rest) = information.split_first().unwrap();
    assert!(Image::parse(&assemble(&[&body[..], &[*first]].concat(), rest)).is_err());
}

/// The example with the n-th field of this meaning replaced.
fn replaced(meaning: &str, nth: usize, bytes_instead: &[u8]) -> Vec<u8> {
    let (mut body, mut information) = (layout::body(), layout::information());
    let fields = body.iter_mut().chain(&mut information);
    let field = fields.filter(|field| field.meaning.trim() == meaning).nth(nth).expect(meaning);
    field.bytes = bytes_instead.to_vec();
    assemble(&bytes(&body), &bytes(&information))
}

#[test]
fn unknown_enum_variant_is_malformed() {
    for (meaning, first_unknown) in [
        ("fitted_on: Raw", 2),
        ("stillness: Some", 2),
        ("quantity 0: Temperature", 9),
        ("axis: Az", 7),
        ("input 0: source: Quantity", 3),
        ("transform: LowPass", 10),
        ("axis 0: Gz", 7),
        ("channel: Input", 2),
    ] {
        for unknown in [first_unknown, 0x7f] {
            assert_eq!(
                refusal(&replaced(meaning, 0, &[unknown])),
                ImageError::Malformed,
                "{meaning} {unknown}"
            );
        }
    }
}

#[test]
fn number_beyond_its_type_is_malformed() {
    // 65536 and a varint that never ends, for 16 bits
    for too_large in [&[0x80, 0x80, 0x04][..], &[0xff, 0xff, 0xff]] {
        assert_eq!(refusal(&replaced("lag", 0, too_large)), ImageError::Malformed);
        assert_eq!(refusal(&replaced("window: 100", 0, too_large)), ImageError::Malformed);
    }
    assert!(Image::parse(&replaced("window: 100", 0, &[0xff, 0xff, 0x03])).is_ok());
}

#[test]
fn text_other_than_utf_8_is_malformed() {
    assert_eq!(refusal(&replaced("sensor", 0, b"exampl\xff")), ImageError::Malformed);
}

#[test]
fn rejects_invalid_terms_by_index() {
    let refused = |term| ImageError::Term { axis: 0, term };
    // degree 0: the bytes of the factor would belong to the next term, so they are removed too
    let mut body = layout::body();
    let degree = body.iter().position(|field| field.meaning.trim() == "degree").unwrap();
    body[degree].bytes = vec![0];
    body.drain(degree + 1..degree + 4);
    let information = bytes(&layout::information());
    assert_eq!(refusal(&assemble(&bytes(&body), &information)), refused(0));
    // more than three
    assert_eq!(refusal(&replaced("degree", 1, &[4])), refused(1));
    assert_eq!(refusal(&replaced("degree", 2, &[255])), refused(2));
    // an output at lag 0: the lag after the first channel: Output
    assert_eq!(refusal(&replaced("lag", 1, &[0])), refused(1));
    assert_eq!(refusal(&replaced("lag", 2, &[0])), refused(2));
}

#[test]
fn building_a_predictor_rejects_unusable_models() {
    let refused = |change: fn(&mut OwnedModel<f32>)| {
        let mut model = layout::model();
        change(&mut model);
        let image = encoded(&model, &INFO);
        // the form is correct
        assert!(Image::parse(&image).is_ok());
        match on_device(&image).map(|_| ()) {
            Err(ImageError::Model(error)) => error,
            other => panic!("{other:?}"),
        }
    };
    let (axis, term) = (0, 0);
    assert_eq!(refused(|model| model.period_s = 0.0), ModelError::Period);
    assert_eq!(refused(|model| model.axes.clear()), ModelError::NoAxis);
    assert_eq!(
        refused(|model| model.axes = vec![model.axes[0].clone(); 3]),
        ModelError::TooManyAxes { found: 3, capacity: 2 }
    );
    assert_eq!(
        refused(|model| model.inputs = vec![model.inputs[0]; 5]),
        ModelError::TooManyInputs { found: 5, capacity: 4 }
    );
    assert_eq!(
        refused(|model| model.axes[0].stochastic = vec![Term::new(0.01, &[y(1)]); 16]),
        ModelError::TooManyTerms { capacity: 16 }
    );
    assert_eq!(
        refused(|model| model.axes[0].stochastic[0] = Term::new(0.5, &[y(683)])),
        ModelError::LagTooDeep { axis, needed: 2049, capacity: 2048 }
    );
    assert_eq!(
        refused(|model| model.axes[0].physical[0] = Term::new(f32::NAN, &[u(0, 0)])),
        ModelError::CoefficientNotFinite { axis, term }
    );
    assert_eq!(refused(|model| model.axes[0].parameters.scale = 0.0), ModelError::AxisParameter { axis });
    assert_eq!(
        refused(|model| model.axes[0].physical[0] = Term::new(1.0, &[u(2, 0)])),
        ModelError::UnknownInput { axis, term }
    );
    assert_eq!(
        refused(|model| model.axes[0].physical[0] = Term::new(1.0, &[y(1)])),
        ModelError::OutputInPhysicalPart { axis, term }
    );
    assert_eq!(refused(|model| model.inputs[1].scale = -1.0), ModelError::InputParameter { input: 1 });
    assert_eq!(
        refused(|model| model.inputs[1].source = Source::Quantity(0)),
        ModelError::InputSource { input: 1 }
    );
    assert_eq!(
        refused(|model| model.axes[0].stochastic[0] = Term::new(1e30, &[y(1)])),
        ModelError::Unbounded { axis }
    );
    assert_eq!(
        refused(|model| model.stillness.as_mut().unwrap().gyro_variance = f32::INFINITY),
        ModelError::Stillness
    );
}

// ---- compatibility ----

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/model_v1.fosm");

const FIXTURE_INFO: Info<'_> = Info {
    sensor: "fixture of format version 1",
    quantities: "temp_c °C\nsupply_v V",
    effects: "thermal_lag\nwarmup_exp",
    provenance: "fos-core/tests/image.rs",
};

/// The model in tests/fixtures/model_v1.fosm: an accelerometer's and a gyro's axis.
fn fixture() -> OwnedModel<f32> {
    let accelerometer = AxisParameters {
        axis: Axis::Az,
        reference: 9.81,
        offset: 0.031,
        scale: 0.004,
        constant: 0.02,
        range: Range::new(-4.5, 4.25),
        physical_range: Range::new(-3.5, 1.5),
        full_scale: 39.2,
        stuck_after_repeats: 300,
        gap_limit_samples: 20,
        coast_limit_s: 30.0,
        innovation: InnovationStatistics { mean: 0.001, variance: 0.8, lag_1_correlation: 0.01 },
    };
    let gyro = AxisParameters {
        axis: Axis::Gx,
        reference: 0.0,
        offset: -0.0123,
        scale: 0.0007,
        constant: -0.01,
        full_scale: 4.36,
        stuck_after_repeats: 0,
        gap_limit_samples: 255,
        coast_limit_s: 12.5,
        ..accelerometer
    };
    let input = |source, transform, centre, scale| Input {
        source,
        transform,
        centre,
        scale,
        source_range: Range::new(-1.5, 2.0),
        range: Range::new(-1.25, 1.75),
    };
    OwnedModel {
        period_s: 0.005,
        stillness: Some(StillnessLimits {
            window: 200,
            accel_variance: 0.0015,
            gyro_variance: 7.25e-6,
            gyro_at_rest: [-0.0123, 0.002, 0.001],
            gyro_deviation: 0.0087,
        }),
        calibration: None,
        quantities: vec![Quantity::Temperature, Quantity::Supply],
        inputs: vec![
            input(Source::Quantity(0), Transform::LowPass { tau_s: 60.0 }, 31.5, 12.0),
            input(Source::Clock, Transform::Decay { tau_s: 240.0 }, 0.0, 1.0),
            input(Source::Remainder(1), Transform::LowPass { tau_s: 10.0 }, 0.0, 1.0),
        ],
        axes: vec![
            OwnedAxis {
                parameters: accelerometer,
                physical: vec![Term::new(1.25, &[u(0, 0)]), Term::new(-0.4, &[u(0, 0), u(0, 0)])],
                stochastic: vec![
                    Term::new(0.9, &[y(1)]),
                    Term::new(-0.2, &[y(2)]),
                    Term::new(0.01, &[y(1), y(3)]),
                    Term::new(-0.003, &[y(1), y(1), u(0, 2)]),
                ],
            },
            OwnedAxis {
                parameters: gyro,
                physical: vec![Term::new(0.7, &[u(1, 0)]), Term::new(0.1, &[u(0, 10), u(1, 0)])],
                stochastic: vec![Term::new(0.6, &[y(1)]), Term::new(0.25, &[u(2, 0)])],
            },
        ],
    }
}

/// FNV-1a (Fowler, Noll, Vo) of the bits of the output over 1000 samples.
fn digest(predictor: &mut Roomy<f32>) -> u64 {
    let mut noise = Noise::new(1);
    let mut digest = 0xcbf2_9ce4_8422_2325_u64;
    for n in 0..1000_u16 {
        // only sums and products, so that every machine draws the same samples
        let mut wobble = || (2.0 * noise.uniform() - 1.0) as f32;
        let measured = [9.841 + 0.008 * wobble(), -0.0123 + 0.0014 * wobble()];
        let quantities = [25.0 + f32::from(n) * 0.01, 3.3];
        let sample = Sample { measured: &measured, quantities: &quantities };
        let corrections = match n {
            0..400 | 700.. => predictor.track(&sample),
            400..690 => predictor.coast(&sample),
            _ => predictor.skip(u32::from(n)),
        };
        for correction in corrections {
            let innovation = correction.innovation.unwrap_or(0.0);
            for value in [correction.predicted, correction.corrected, innovation] {
                for byte in value.to_bits().to_le_bytes() {
                    digest = (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                }
            }
        }
    }
    digest
}

/// To write the fixture of a new version, set FOS_WRITE_FIXTURE and run this test; keep the old file.
#[test]
fn fixture_of_this_version_still_reads() {
    let model = fixture();
    let image = encoded(&model, &FIXTURE_INFO);
    if std::env::var_os("FOS_WRITE_FIXTURE").is_some() {
        std::fs::write(FIXTURE, &image).unwrap();
    }
    let stored = std::fs::read(FIXTURE).unwrap();
    let read = Image::parse(&stored).unwrap();

    assert_eq!(read.period_s(), 0.005);
    assert_eq!(read.fitted_on(), FittedOn::Raw);
    assert_eq!(read.info(), FIXTURE_INFO);
    let found = owned(&read);
    assert_eq!(found.stillness, model.stillness);
    assert_eq!(found.quantities, model.quantities);
    assert_eq!(found.inputs, model.inputs);
    assert_eq!(found.axes.len(), 2);
    for (found, expected) in found.axes.iter().zip(&model.axes) {
        assert_eq!(found.parameters, expected.parameters);
        assert_eq!(found.physical, expected.physical);
        assert_eq!(found.stochastic, expected.stochastic);
    }
    assert_eq!((stored.len(), crc_32(&stored)), (LENGTH, CHECKSUM), "the file was changed");
    let digest = digest(&mut read.predictor().unwrap());
    assert!(digest == DIGEST, "the numbers that come out have changed: digest {digest:#x}");
    assert!(stored == image, "the same model is written as other bytes");
}

const LENGTH: usize = 453;
const CHECKSUM: u32 = 3_875_512_380;
/// Digest of the output of this model, the same on every machine and after every change of the code.
const DIGEST: u64 = 0xb83a_d05c_fc4c_c6a5;
