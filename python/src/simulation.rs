//! Logs with known truth.

use fos_data::recording::LoadOptions;
use fos_simulate::{Axis, CasePlan, Disturbance, Durations, Effect, Plant, Setup, Simulation};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::sync::Arc;

use crate::error::{py_error, raised};
use crate::recording::{Recording, of_columns};
use crate::work;

/// Log of a six-axis device with a temperature sensor.
#[pyfunction]
pub(crate) fn simulate(
    py: Python<'_>,
    minutes: f64,
    rate_hz: f64,
    seed: u64,
    temperature: f64,
    motion: bool,
    truth: bool,
) -> PyResult<Recording> {
    let plan = Simulation { duration_s: minutes * 60.0, rate_hz, seed, temperature, motion };
    let name = format!("simulated, seed {seed}");
    let log = work::run(py, || {
        let log = fos_simulate::simulate(&plan);
        let truth = if truth { log.truth } else { Vec::new() };
        let columns = log.columns.into_iter().chain(truth).collect();
        of_columns(&name, columns, &LoadOptions::default())
    })?;
    Ok(Recording { log: Arc::new(log.map_err(raised(py))?), read: LoadOptions::default() })
}

/// A simulated effect: identifier, size, parameter.
type Planted = (String, f64, Option<f64>);

/// Logs of a case (reference log, log to explain, evaluation log) of one device, and the truth as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of `fos_imu.simulate_case`")]
pub(crate) fn simulate_case(
    py: Python<'_>,
    planted: Vec<Planted>,
    setup: &str,
    part: &str,
    axis: &str,
    seed: u64,
    world: &str,
    durations_s: [f64; 3],
) -> PyResult<(Recording, Recording, Recording, String)> {
    let plan = plan(&planted, setup, part, axis, seed, world, durations_s);
    let plan = plan.map_err(|wrong| py_error(py, "SimulationError", &wrong))?;
    let case = work::run(py, || fos_simulate::simulate_case(&plan))?;
    let case = case.map_err(|error| py_error(py, "SimulationError", &error.to_string()))?;
    let log = |which: &str, columns: Vec<(String, Vec<f64>)>| -> PyResult<Recording> {
        let name = format!("{which} of a simulated case, seed {seed}");
        let read = LoadOptions::default();
        let log = work::run(py, || of_columns(&name, columns, &read))?.map_err(raised(py))?;
        Ok(Recording { log: Arc::new(log), read })
    };
    let truth = json!(case.truth).to_string();
    Ok((log("reference", case.reference)?, log("field", case.log)?, log("later", case.evaluation)?, truth))
}

fn plan(
    planted: &[Planted],
    setup: &str,
    part: &str,
    axis: &str,
    seed: u64,
    world: &str,
    [reference_s, log_s, evaluation_s]: [f64; 3],
) -> Result<CasePlan, String> {
    let target =
        Axis::named(axis).ok_or_else(|| format!("there is no axis {axis:?}\nhelp: choose from ax … gz"))?;
    let setup: Setup = serde_json::from_value(Value::from(setup.replace('-', "_"))).map_err(|_| {
        format!("there is no set-up {setup:?}\nhelp: bench, desk, pose_rig, shaker or rate_table")
    })?;
    let mut plan = CasePlan::new(seed, part, setup, target);
    plan.durations = Durations { reference_s, log_s, evaluation_s };
    plan.disturbance = Disturbance::named(world).ok_or_else(|| {
        let names = Disturbance::ALL.map(Disturbance::name).join(", ");
        format!("there is no world {world:?}\nhelp: choose from {names}")
    })?;
    for (effect, size, parameter) in planted {
        let effect = Effect::try_from(effect.clone())?;
        plan.plant([Plant { effect, parameter: *parameter, size: *size }]);
    }
    Ok(plan)
}
