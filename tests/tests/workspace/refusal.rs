//! Predictions of `export` about the hubs agree with the hubs.

use crate::exported_model::model;
use fos_core::{Axis, Model};
use fos_embedded::hub::{CHub, HubError};
use fos_embedded::raw::Scales;
use fos_export::{ExportError, Refusal, Room, c_source, image};
use fos_fit::model::UnitModel;

/// Response of the hub of the C interface to the image, for the sensor that the model was fitted to.
fn c_hub_takes(model: &UnitModel) -> Result<(), HubError> {
    let scales = Scales {
        accel_mps2: 0.0012,
        gyro_rads: 0.0003,
        temperature_k: 1.0 / 256.0,
        temperature_zero_c: 25.0,
        period_s: model.period_s,
        values: model.fitted_on,
    };
    CHub::new(scales).load(&image(model, "", "").expect("an image"))
}

#[test]
fn accepted_model_loads_and_one_more_term_does_not() {
    let mut model = model();
    let spare = 128 - model.n_terms();
    let term = model.axes[0].physical[0].clone();
    model.axes[0].physical.extend(vec![term.clone(); spare]);
    assert_eq!((Refusal::of(&model), c_hub_takes(&model)), (None, Ok(())));

    model.axes[0].physical.push(term);
    let refusal = Refusal::of(&model).expect("too large");
    assert!(matches!(refusal, Refusal::TooLargeForC(Room { terms: 129, .. })), "{refusal:?}");
    assert!(c_hub_takes(&model).is_err());
    let message = refusal.to_string();
    assert!(!message.contains("history"), "{message}");
    for part in ["fos.h", "129 terms (room for 128)", "\nhelp:", "--max-terms", "Hub<13, 129, 64>"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    // a header that none of our libraries could load is not written
    let refused = c_source(&model, "unit", "", "").expect_err("too large");
    assert!(matches!(refused, ExportError::Refused(Refusal::TooLargeForC(_))), "{refused:?}");
}

#[test]
fn reports_excess_history_and_inputs_each_with_a_remedy() {
    let mut deep = model();
    let longest = |model: &mut UnitModel, lag| model.axes[0].stochastic[0].factors[0].lag = lag;
    // with this many lags of 13 inputs and 2 axes, 255 values fit and 270 do not
    longest(&mut deep, 17);
    assert_eq!((Refusal::of(&deep), c_hub_takes(&deep)), (None, Ok(())));
    let header = c_source(&deep, "unit", "", "").expect("it fits");
    assert!(header.contains("FOS_MAX_HISTORY < 256"), "a header that compiles");
    longest(&mut deep, 18);
    let message = Refusal::of(&deep).expect("too deep").to_string();
    assert!(
        message.contains("512 values of history (room for 256)") && message.contains("--max-lag"),
        "{message}"
    );
    assert!(c_hub_takes(&deep).is_err());

    let mut many = model();
    let clock = many.inputs[6].clone();
    many.inputs.resize(17, clock);
    let message = Refusal::of(&many).expect("too many").to_string();
    assert!(message.contains("17 inputs (room for 16)") && message.contains("--memory"), "{message}");
    assert!(c_hub_takes(&many).is_err());
}

#[test]
fn names_quantities_without_a_source_by_column() {
    let mut other = model();
    other.axes[1].parameters.axis = Axis::Other;
    other.axes[1].column = "pressure_pa".to_owned();
    let message = Refusal::of(&other).expect("no axis of a sensor").to_string();
    assert!(
        message.contains("no hub") && message.contains("pressure_pa") && message.contains("\nhelp:"),
        "{message}"
    );
    assert_eq!(c_hub_takes(&other), Err(HubError::Axis(1)));
}

/// Period and values depend on the sensor, not only on the model: for the sensor of the fit no hub refuses them.
#[test]
fn assumes_the_sensor_of_the_fit() {
    let slow = UnitModel { period_s: 0.02, ..model() };
    assert_eq!(Refusal::of(&slow), None);
    let at_200_hz = Scales {
        accel_mps2: 0.0012,
        gyro_rads: 0.0003,
        temperature_k: 0.01,
        temperature_zero_c: 25.0,
        period_s: 0.005,
        values: slow.fitted_on,
    };
    let mut hub = CHub::new(at_200_hz);
    let refused = slow.with::<f32, _>(|slow: &Model<'_, f32>| hub.load_model(slow));
    assert!(matches!(refused, Err(HubError::Period { .. })), "{refused:?}");
}
