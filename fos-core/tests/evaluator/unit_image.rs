//! One image for a part and a record for each unit: together they give the image of the unit's own model.

use fos_core::image::{
    Image, ImageError, Info, UNIT_HEADER_LENGTH, UnitError, UnitRecord, encode, encode_unit, for_unit,
};
use fos_testkit::models::{Draw, OwnedModel, cases, models};
use proptest::prelude::*;

const INFO: Info<'static> =
    Info { sensor: "part", quantities: "a\nb\nc", effects: "temp_linear", provenance: "somewhere" };

fn encoded(model: &OwnedModel<f32>) -> Vec<u8> {
    let mut buffer = [0; 65536];
    model.borrow(|model| encode(model, &INFO, &mut buffer).unwrap().to_vec())
}

/// Changes the values of a unit; returns them in the order of a record.
fn unit_values(model: &mut OwnedModel<f32>, mut change: impl FnMut(f32) -> f32) -> Vec<f32> {
    let mut values = Vec::new();
    for axis in &mut model.axes {
        axis.parameters.offset = change(axis.parameters.offset);
        values.push(axis.parameters.offset);
        for term in &mut axis.physical {
            *term = term.with_coefficient(change(term.coefficient));
            values.push(term.coefficient);
        }
    }
    values
}

fn record_of(part: &[u8], name: &str, values: &[f32]) -> Vec<u8> {
    let mut buffer = [0; 4096];
    encode_unit(part, name, values.iter().copied(), &mut buffer).unwrap().to_vec()
}

fn example() -> (Vec<u8>, OwnedModel<f32>) {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let has_terms = |model: &OwnedModel<f64>| model.axes.iter().any(|axis| !axis.physical.is_empty());
    let models = models(Draw::Contracting).prop_filter("terms", has_terms);
    let model = models.new_tree(&mut runner).unwrap().current().convert::<f32>();
    (encoded(&model), model)
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn part_and_record_give_the_image_of_the_unit(
        model in models(Draw::Contracting), by in -2.0f32..2.0, name in ".{0,40}"
    ) {
        let model = model.convert::<f32>();
        let part = encoded(&model);
        let mut unit = model.clone();
        let mut next = by;
        let values = unit_values(&mut unit, |value| {
            next *= -0.9;
            value + next
        });
        let record = record_of(&part, &name, &values);
        prop_assert_eq!(record.len(), UNIT_HEADER_LENGTH + name.len() + 4 * values.len());
        let read = UnitRecord::parse(&record).unwrap();
        prop_assert_eq!(read.name(), &name);
        prop_assert_eq!(read.values().collect::<Vec<f32>>(), values);
        let mut buffer = vec![0xaa; part.len() + 3];
        prop_assert_eq!(for_unit(&part, &record, &mut buffer).unwrap(), encoded(&unit));
        prop_assert_eq!(&buffer[part.len()..], &[0xaa; 3]);
    }

    #[test]
    fn any_record_gives_an_error_or_an_image_of_the_same_length(
        record in prop::collection::vec(any::<u8>(), 0..200), room in 0usize..4096
    ) {
        let (part, _) = example();
        let mut buffer = vec![0; room];
        if let Ok(image) = for_unit(&part, &record, &mut buffer) {
            prop_assert_eq!(image.len(), part.len());
        }
        let _ = for_unit(&record, &record, &mut buffer);
    }
}

#[test]
fn rejects_damaged_records() {
    let (part, mut model) = example();
    let record = record_of(&part, "unit 7", &unit_values(&mut model, |value| value));
    let mut buffer = vec![0; part.len()];
    assert_eq!(for_unit(&part, &record, &mut buffer).unwrap(), part, "the part's own values");
    for place in 0..record.len() {
        for bit in 0..8 {
            let mut damaged = record.clone();
            damaged[place] ^= 1 << bit;
            assert!(for_unit(&part, &damaged, &mut buffer).is_err(), "byte {place}, bit {bit}");
        }
    }
    for length in 0..record.len() {
        let error = for_unit(&part, &record[..length], &mut buffer).unwrap_err();
        assert!(matches!(error, UnitError::Truncated | UnitError::Checksum { .. }), "{length}: {error}");
    }
}

#[test]
fn rejects_records_of_other_parts_and_sizes() {
    let (part, mut model) = example();
    let values = unit_values(&mut model, |value| value + 0.5);
    let record = record_of(&part, "unit 7", &values);
    let room = part.len();
    let made = |part: &[u8], record: &[u8], room: usize| {
        let mut buffer = vec![0; room];
        let error = for_unit(part, record, &mut buffer).map(<[u8]>::to_vec).unwrap_err();
        assert!(!error.to_string().is_empty());
        error
    };
    assert_eq!(made(&part, &record, room - 1), UnitError::TooSmall { needed: room });
    assert_eq!(made(&record, &record, room), UnitError::Part(ImageError::Magic));
    assert_eq!(made(&part, &part, room), UnitError::Magic);
    // the image of the unit counts as another part
    let other = encoded(&model);
    assert!(matches!(made(&other, &record, room), UnitError::OtherPart { .. }));

    let mut buffer = [0; 4096];
    let count = UnitError::Count { needed: values.len(), found: values.len() - 1 };
    let fewer = values[1..].iter().copied();
    assert_eq!(encode_unit(&part, "unit 7", fewer, &mut buffer), Err(count));
    let needed = record.len();
    let all = values.iter().copied();
    assert_eq!(
        encode_unit(&part, "unit 7", all.clone(), &mut buffer[..needed - 1]),
        Err(UnitError::TooSmall { needed })
    );
    let long = "n".repeat(65_536);
    assert_eq!(encode_unit(&part, &long, all, &mut vec![0; 70_000]), Err(UnitError::Name));
}

#[test]
fn loading_rejects_non_finite_values() {
    let (part, mut model) = example();
    let values = unit_values(&mut model, |_| f32::NAN);
    let record = record_of(&part, "", &values);
    let mut buffer = vec![0; part.len()];
    let image = Image::parse(for_unit(&part, &record, &mut buffer).unwrap()).unwrap();
    assert!(image.predictor::<f32, 6, 8, 128, 256>().is_err());
}
