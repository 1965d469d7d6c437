//! The test vector of an exported model detects its possible errors.

use crate::exported_model::model;
use fos_core::{Axis, Transform, Validity};
use fos_embedded::hub::{HubError, Motion};
use fos_export::test_vector;
use fos_fit::model::UnitModel;

/// A change of a model, with its name.
type Change = (String, Box<dyn Fn(&mut UnitModel)>);

fn change(name: impl Into<String>, change: impl Fn(&mut UnitModel) + 'static) -> Change {
    (name.into(), Box::new(change))
}

/// Factor by which a number is changed: a thousandth, far above rounding and too small to notice in the output.
const BY: f64 = 1.001;

fn changes(model: &UnitModel) -> Vec<Change> {
    let mut changes = Vec::new();
    for axis in 0..model.axes.len() {
        let name = &model.axes[axis].column;
        changes.extend([
            change(format!("{name}: reference"), move |m| m.axes[axis].parameters.reference += 0.01),
            change(format!("{name}: offset"), move |m| m.axes[axis].parameters.offset *= BY),
            change(format!("{name}: scale"), move |m| m.axes[axis].parameters.scale *= BY),
            change(format!("{name}: constant"), move |m| m.axes[axis].parameters.constant *= BY),
            change(format!("{name}: low end of the range"), move |m| m.axes[axis].parameters.range.low *= BY),
            change(format!("{name}: high end of the range"), move |m| {
                m.axes[axis].parameters.range.high *= BY
            }),
            change(format!("{name}: full scale"), move |m| m.axes[axis].parameters.full_scale *= BY),
            change(format!("{name}: gap limit"), move |m| m.axes[axis].parameters.gap_limit_samples = 2),
            change(format!("{name}: which axis"), move |m| m.axes[axis].parameters.axis = Axis::Ay),
        ]);
        for term in 0..model.axes[axis].stochastic.len() {
            changes.push(change(format!("{name}: without stochastic term {term}"), move |m| {
                m.axes[axis].stochastic.remove(term);
            }));
        }
        for term in 0..model.axes[axis].physical.len() {
            changes.push(change(format!("{name}: without physical term {term}"), move |m| {
                m.axes[axis].physical.remove(term);
            }));
        }
    }
    for input in 0..model.inputs.len() {
        let transform = model.inputs[input].input.transform;
        let name = format!("u{input} {transform:?}");
        changes.push(change(format!("{name}: parameter"), move |m| {
            let transform = &mut m.inputs[input].input.transform;
            *transform = match *transform {
                Transform::LowPass { tau_s } => Transform::LowPass { tau_s: BY * tau_s },
                Transform::Rate { tau_s } => Transform::Rate { tau_s: BY * tau_s },
                Transform::Variance { tau_s } => Transform::Variance { tau_s: BY * tau_s },
                Transform::Backlash { half_width } => Transform::Backlash { half_width: BY * half_width },
                Transform::Decay { tau_s } => Transform::Decay { tau_s: BY * tau_s },
                Transform::Sine { frequency_hz } => Transform::Sine { frequency_hz: BY * frequency_hz },
                Transform::Cosine { frequency_hz } => Transform::Cosine { frequency_hz: BY * frequency_hz },
                Transform::Identity => Transform::Absolute,
                Transform::Absolute => Transform::Identity,
                Transform::Time => Transform::Decay { tau_s: 1.0 },
            };
        }));
        if !transform.is_clock() || matches!(transform, Transform::Time) {
            // a backlash follows its input from any centre in the same way
            if !matches!(transform, Transform::Backlash { .. }) {
                changes
                    .push(change(format!("{name}: centre"), move |m| m.inputs[input].input.centre += 0.01));
            }
            changes.push(change(format!("{name}: scale"), move |m| m.inputs[input].input.scale *= BY));
        }
        if matches!(transform, Transform::Identity) {
            changes.push(change(format!("{name}: range"), move |m| m.inputs[input].input.range.high /= 1.1));
            changes.push(change(format!("{name}: range"), move |m| m.inputs[input].input.range.low /= 1.1));
        }
    }
    changes
}

#[test]
fn detects_a_change_of_every_relevant_number() {
    let model = model();
    let vector = test_vector(&model).expect("a hub takes it");
    assert!(vector.is_met_by(&model));
    let changes = changes(&model);
    assert!(changes.len() > 60, "{}", changes.len());
    let unnoticed: Vec<String> = changes
        .into_iter()
        .filter(|(_, change)| {
            let mut changed = model.clone();
            change(&mut changed);
            assert_ne!(changed, model);
            vector.is_met_by(&changed)
        })
        .map(|(name, _)| name)
        .collect();
    assert!(unnoticed.is_empty(), "{unnoticed:#?}");
}

#[test]
fn covers_every_condition_of_a_device() {
    let vector = test_vector(&model()).expect("a hub takes it");
    let vector = vector.vector();
    let seen = vector.expected.iter().fold(0, |seen, expected| seen | expected.validity);
    let all = Validity::WARMING_UP
        | Validity::OWN_HISTORY
        | Validity::OUTPUT_OUT_OF_RANGE
        | Validity::INPUT_OUT_OF_RANGE
        | Validity::INPUT_NOT_FINITE
        | Validity::SATURATED;
    assert_eq!(seen, all.bits());
    let n = vector.samples.len();
    assert!((60..80).contains(&n), "{n}");
    let count = |what: fn(&fos_embedded::test_vector::TestSample) -> bool| {
        vector.samples.iter().filter(|sample| what(sample)).count()
    };
    assert_eq!(count(|sample| sample.motion == Motion::Moving), 8);
    assert_eq!(count(|sample| sample.skipped > 0), 2);
    assert_eq!(count(|sample| sample.temperature.is_none()), 1);
    let given: Vec<f32> = vector.given_bits.iter().map(|bits| f32::from_bits(*bits)).collect();
    assert_eq!(given.iter().filter(|value| value.is_nan()).count(), 1);
    // most of the samples are plain, since the model itself is tested
    for axis in 0..vector.channels.len() {
        let plain = vector.expected.iter().skip(axis).step_by(vector.channels.len());
        let plain = plain.filter(|expected| expected.validity == 0).count();
        assert!(2 * plain > n, "axis {axis}: {plain} of {n}");
    }
}

#[test]
fn a_model_of_another_series_has_none() {
    let mut model = model();
    model.axes[1].parameters.axis = Axis::Other;
    assert_eq!(test_vector(&model).err(), Some(HubError::Axis(1)));
    let source = fos_export::rust_source(&model, "");
    assert!(source.contains("pub static MODEL") && source.contains("There is no test vector"), "{source}");
}
