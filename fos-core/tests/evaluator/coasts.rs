//! Parallel coasts predict the same bits as single coasts.
#![cfg(feature = "coasts")]

use std::sync::atomic::{AtomicUsize, Ordering};

use fos_core::{Coasts, Real, Sample};
use fos_testkit::models::{Draw, OwnedModel, cases, models};
use proptest::prelude::*;

const LANES: usize = 4;

/// Samples tracked before the first coast, and between the starts of coasts; the longest lag is 12.
const BEFORE: usize = 20;
const APART: usize = 3;

/// Samples of a coast.
const LONG: usize = 60;

/// A sample: six axes in scaled units and three quantities, of which any may be missing.
type Row = ([f64; 6], [f64; 3]);

fn rows() -> impl Strategy<Value = Vec<Row>> {
    let quantity = || prop_oneof![4 => -2.5..2.5_f64, 1 => Just(f64::NAN)];
    let row = (prop::array::uniform6(-0.5..0.5_f64), prop::array::uniform3(quantity()));
    prop::collection::vec(row, BEFORE + LANES * APART + LONG)
}

/// Number of models whose coasts were compared.
static COMPARED: AtomicUsize = AtomicUsize::new(0);

/// Number of models whose lanes differ at the end, so that swapped lanes would be detected.
static APART_AT_END: AtomicUsize = AtomicUsize::new(0);

fn compare<R: Real>(model: &OwnedModel<R>, rows: &[Row]) -> Result<(), TestCaseError> {
    let Ok(mut predictor) = model.predictor() else { return Ok(()) };
    let measured = |row: usize| -> Vec<R> {
        let lifted = model.axes.iter().zip(rows[row].0).map(|(axis, x)| {
            R::from_f64(x) * axis.parameters.scale + axis.parameters.reference + axis.parameters.offset
        });
        lifted.collect()
    };
    let quantities = |row: usize| rows[row].1.map(R::from_f64);
    let begin = |lane: usize| BEFORE + lane * APART;
    let mut begun = Vec::new();
    for row in 0..begin(LANES) {
        if (0..LANES).any(|lane| begin(lane) == row) {
            begun.push(predictor.clone());
        }
        let _ = predictor.track(&Sample { measured: &measured(row), quantities: &quantities(row) });
    }
    let mut alone: [_; LANES] = begun.try_into().expect("as many as lanes");
    // earlier computations must leave no trace
    let Some(mut coasts) = Coasts::<_, LANES, _, _, _, _>::new(&alone[1]) else { return Ok(()) };
    for _ in 0..7 {
        let _ = coasts.step(&[[R::ONE; LANES]; 3]);
    }
    let begun = alone.iter().enumerate().all(|(lane, predictor)| match lane {
        0 => coasts.begin_all(predictor),
        _ => coasts.begin(lane, predictor),
    });
    if !begun {
        return Ok(());
    }
    COMPARED.fetch_add(1, Ordering::Relaxed);
    let mut last = [0.0; LANES];
    for ahead in 0..LONG {
        let now: [[R; 3]; LANES] = std::array::from_fn(|lane| quantities(begin(lane) + ahead));
        let in_lanes: [[R; LANES]; 3] = std::array::from_fn(|quantity| now.map(|values| values[quantity]));
        let found = coasts.step(&in_lanes);
        for (lane, predictor) in alone.iter_mut().enumerate() {
            let measured = measured(begin(lane) + ahead);
            let expected = predictor.coast(&Sample { measured: &measured, quantities: &now[lane] });
            prop_assert_eq!(found.len(), expected.len());
            for (axis, (found, expected)) in found.iter().zip(expected).enumerate() {
                let (found, expected) = (found[lane].to_f64(), expected.predicted.to_f64());
                last[lane] = found;
                prop_assert_eq!(
                    found.to_bits(),
                    expected.to_bits(),
                    "axis {}, lane {}, {}",
                    axis,
                    lane,
                    ahead
                );
            }
        }
    }
    let is_apart = last.windows(2).all(|pair| pair[0] != pair[1]);
    APART_AT_END.fetch_add(usize::from(is_apart), Ordering::Relaxed);
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    fn each_lane_equals_a_single_coast(model in models(Draw::Contracting), rows in rows()) {
        compare(&model, &rows)?;
        compare(&model.convert::<f32>(), &rows)?;
    }
}

#[test]
fn parallel_coasts_equal_single_coasts() {
    each_lane_equals_a_single_coast();
    // the other models are rejected, or their history does not consist of measurements only
    let compared = COMPARED.load(Ordering::Relaxed);
    assert!(compared > 200, "{compared} of 600");
    let apart = APART_AT_END.load(Ordering::Relaxed);
    assert!(2 * apart > compared, "{apart} of {compared}");
}
