//! Bias, sensitivity and cross-axis from a log of hand-turned orientations or of a turntable.

use std::sync::Arc;

use fos_calibrate::export::{ArduPilot, ImuTk, Kalibr, Px4};
use fos_calibrate::{CalibrateError, Calibration, Gravity, Imu, Options, Parameter, RestResidual, shown};
use fos_data::recording::Recording as Log;
use fos_figures::rests::residual_of_each_rest;
use pyo3::prelude::*;
use serde_json::{Map, Value, json};

use crate::error::raised;
use crate::recording::Recording;
use crate::work;

/// Calibration by hand, as JSON. `place` is the latitude, °, and the height above sea level, m.
#[pyfunction]
pub(crate) fn calibrate(
    py: Python<'_>,
    log: &Recording,
    place: Option<(f64, f64)>,
    accuracy_mps2: Option<f64>,
) -> PyResult<String> {
    let log = Arc::clone(&log.log);
    let gravity = place.map_or_else(Gravity::assumed, |(latitude, height)| Gravity::at(latitude, height));
    let options = Options { gravity, accuracy_mps2 };
    let found = work::run(py, || -> Result<Calibration, CalibrateError> {
        fos_calibrate::calibrate(&Imu::of(&log)?, &options)
    })?;
    Ok(by_hand(&found.map_err(raised(py))?, &log).to_string())
}

/// Calibration of a gyro on a turntable at these rates, rad/s, as JSON.
#[pyfunction]
pub(crate) fn calibrate_on_turntable(
    py: Python<'_>,
    log: &Recording,
    rates_rads: Vec<f64>,
) -> PyResult<String> {
    let log = Arc::clone(&log.log);
    let found = work::run(py, || fos_calibrate::calibrate_on_turntable(&Imu::of(&log)?, &rates_rads))?;
    let found = found.map_err(raised(py))?;
    let (matrix, bias) = found.model.correction(found.model.reference_c);
    Ok(json!({
        "parameters": parameters(&found.parameters),
        "gyro": { "matrix": matrix, "bias": bias },
        "rates_rads": found.rates_rads,
        "plateaus": found.plateaus,
        "rms": found.rms,
    })
    .to_string())
}

fn by_hand(found: &Calibration, log: &Log) -> Value {
    let accelerometer = &found.accelerometer;
    let (matrix, bias) = accelerometer.model.correction(accelerometer.model.reference_c);
    let gyro = found.gyro.as_ref();
    let all = gyro.iter().flat_map(|gyro| gyro.parameters.iter().chain(&gyro.derived));
    json!({
        "parameters": parameters(accelerometer.parameters.iter().chain(all)),
        "accelerometer": { "matrix": matrix, "bias": bias },
        "gyro": gyro.and_then(|gyro| Some(json!({ "matrix": gyro.matrix?, "bias": gyro.bias }))),
        "gravity_mps2": accelerometer.gravity.mps2,
        "reference_c": accelerometer.temperature_c.map(|_| accelerometer.model.reference_c),
        "figure": residual_of_each_rest(&accelerometer.rests),
        "rests": accelerometer.rests.iter().map(rest).collect::<Vec<_>>(),
        "orientations": accelerometer.orientations,
        "unseen": accelerometer.unseen,
        "rms_mps2": accelerometer.rms_mps2,
        "rms_deg": gyro.map_or([None; 2], |gyro| gyro.rms_deg),
        "worst_mps2": accelerometer.worst_mps2,
        "next": accelerometer.next,
        "is_accurate": accelerometer.accuracy.map(|(_, is_reached)| is_reached),
        "plan": accelerometer.plan,
        "cautions": found.cautions(true),
        "files": files(found, log),
    })
}

fn parameters<'a>(all: impl IntoIterator<Item = &'a Parameter>) -> Vec<Value> {
    let one = |parameter: &Parameter| {
        let shown = shown(parameter, true);
        let text = format!("{} {}", shown.both(), shown.unit);
        let mut value = json!(parameter);
        value["text"] = json!(text.trim_end());
        value
    };
    all.into_iter().map(one).collect()
}

fn rest(one: &RestResidual) -> Value {
    json!({
        "start_s": one.rest.start_s,
        "duration_s": one.rest.duration_s,
        "temperature_c": one.rest.temperature_c,
        "up": one.up,
        "residual_mps2": one.residual_mps2,
        "deviation_mps2": one.deviation_mps2,
        "excluded": one.rest.excluded.as_ref().map(ToString::to_string),
    })
}

/// The calibration as the files of other programs; those that cannot hold it are absent.
fn files(found: &Calibration, log: &Log) -> Map<String, Value> {
    let name = fos_data::file::name_of(&log.paths());
    let imu_tk = ImuTk::of(found);
    let all = [
        ("px4", Px4::of(found).ok().map(|px4| px4.file(&name, 0, [0; 2]))),
        ("ardupilot", ArduPilot::of(found).ok().map(|ardupilot| ardupilot.file(&name, 0))),
        ("kalibr", Some(Kalibr::of(found).file(&name))),
        ("imu_tk_acc", Some(imu_tk.accelerometer.file())),
        ("imu_tk_gyro", imu_tk.gyro.map(|gyro| gyro.file())),
    ];
    all.into_iter().filter_map(|(name, text)| Some((name.to_owned(), json!(text?)))).collect()
}
