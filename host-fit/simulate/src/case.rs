//! A case: the logs of one unit, an effect planted in two of them, and the truth.

use serde::Serialize;

use super::case_meta::meta;
use super::coloured::AxisNoise;
use super::draft::{Draft, FIELD, draft};
use super::plan::{CasePlan, PlanError};
use super::planting::{self, Planted};
use super::random::{Stream, random};
use super::recorder::{self, Faults};
use super::regressors::NamedSeries;
use fos_data::case::CaseMeta;

/// The logs of a case and the truth behind them.
#[derive(Debug, Clone)]
pub struct SimulatedCase {
    /// What the user is told.
    pub meta: CaseMeta,
    /// The quiet log, column by column.
    pub baseline: Vec<NamedSeries>,
    /// The log to be explained.
    pub field: Vec<NamedSeries>,
    /// The log to be corrected.
    pub eval: Vec<NamedSeries>,
    /// What the user is not told.
    pub truth: Truth,
}

/// The truth behind a case.
#[derive(Debug, Clone, Serialize)]
pub struct Truth {
    /// The plan.
    pub plan: CasePlan,
    /// What was planted, in the order of the plan.
    pub planted: Vec<Planted>,
    /// Something planted is in no library.
    pub outside: bool,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// Bias of the target, its unit.
    pub bias: f64,
    /// Spectral level of the target's fast noise at zero frequency, one-sided, unit/√Hz.
    pub white_density: f64,
    /// Noise of the target.
    pub noise: AxisNoise,
    /// What a perfect model subtracts from the field, and what it is made of; in truth_field.parquet.
    #[serde(skip)]
    pub field: LogTruth,
    /// The same of the evaluation; in truth_eval.parquet.
    #[serde(skip)]
    pub eval: LogTruth,
}

/// The planted error of a log, row by row.
#[derive(Debug, Clone, Default)]
pub struct LogTruth {
    /// What all planted effects add to the target, its unit: what a perfect model subtracts.
    pub error: Vec<f64>,
    /// The regressors of all planted effects; `planted.k.name`, k counting from 0.
    pub regressors: Vec<NamedSeries>,
}

const BASELINE: u64 = 0;
const EVAL: u64 = 2;

/// Simulates a case.
///
/// # Errors
/// The part is unknown, the set-up cannot show an effect, or an effect makes no error.
pub fn simulate_case(plan: &CasePlan) -> Result<SimulatedCase, PlanError> {
    let Draft { unit, scene, logged, field, shapes } = draft(plan)?;
    let seed = plan.seed;
    let part = unit.part;
    let target = plan.target;
    let noise = &unit.noise[target as usize];
    let baseline = scene.baseline(plan.durations.baseline_s, &mut random(seed, Stream::World(BASELINE)));
    let eval = scene.log(plan.durations.eval_s, true, &mut random(seed, Stream::World(EVAL)));

    let quiet = recorder::analog(&unit, &baseline, target, &vec![0.0; baseline.len()], (seed, BASELINE));
    let none = Faults::default();
    let baseline = recorder::record(&unit, &baseline, (target, &quiet), (&logged, &none), (seed, BASELINE));

    let columns = shapes.iter().map(|shape| shape.columns(&field, FIELD, seed)).collect();
    let mut planted =
        planting::size(plan, &shapes, &columns, &field, &logged.names(), (noise, part.lsb(target)))?;
    let weights: Vec<Vec<f64>> = planted.iter().map(|planted| planted.coefficients.clone()).collect();
    let eval_columns = shapes.iter().map(|shape| shape.columns(&eval, EVAL, seed)).collect();
    let mut faults = Faults::default();
    let mut logs = Vec::new();
    for (world, columns, log) in [(&field, columns, FIELD), (&eval, eval_columns, EVAL)] {
        let mut error = planting::sum(&weights, &columns, world.len());
        let analog = recorder::analog(&unit, world, target, &error, (seed, log));
        let lsb = part.lsb(target);
        planting::add_faults(&mut faults, plan, &mut planted, (&analog, noise), (lsb, seed, log == FIELD));
        for (error, value) in error.iter_mut().zip(&analog) {
            if faults.limit.is_some() || faults.step.is_some() {
                *error += recorder::convert(&part, target, &faults, *value)
                    - recorder::convert(&part, target, &none, *value);
            }
        }
        let record = recorder::record(&unit, world, (target, &analog), (&logged, &faults), (seed, log));
        let mut regressors: Vec<NamedSeries> = columns
            .into_iter()
            .enumerate()
            .flat_map(|(k, columns): (usize, Vec<NamedSeries>)| {
                columns.into_iter().map(move |(name, values)| (format!("planted.{k}.{name}"), values))
            })
            .collect();
        for values in regressors.iter_mut().map(|(_, values)| values).chain([&mut error]) {
            recorder::drop_lost(values, &faults.lost);
        }
        logs.push((record, LogTruth { error, regressors }));
    }
    let (eval, eval_truth) = logs.pop().unwrap_or_default();
    let (field, field_truth) = logs.pop().unwrap_or_default();
    let truth = Truth {
        plan: plan.clone(),
        outside: planted.iter().any(|planted| planted.effect.is_outside()),
        planted,
        rate_hz: 1.0 / noise.period_s,
        bias: unit.bias[target as usize],
        white_density: (2.0 * noise.period_s * noise.fast_density(0.0, 0.0)).sqrt(),
        noise: noise.clone(),
        field: field_truth,
        eval: eval_truth,
    };
    Ok(SimulatedCase { meta: meta(plan, &part), baseline, field, eval, truth })
}
