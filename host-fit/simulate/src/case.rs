//! A case: the logs of one device, an effect planted in two of them, and the truth.

use serde::Serialize;

use super::case_meta::meta;
use super::coloured::AxisNoise;
use super::disturbance::{self, Disturbance, Disturbed, Motion};
use super::draft::{Draft, draft};
use super::plan::{CasePlan, PlanError};
use super::planting::{self, Planted};
use super::random::{EVALUATION, LOG, REFERENCE, Stream, random};
use super::recorder::{self, Faults};
use super::regressors::NamedSeries;
use super::streams::split;
use fos_data::case::CaseMeta;
use fos_data::recording::{LoadOptions, Recording, RecordingError, Source};

/// Logs of a case and the truth behind them.
#[derive(Debug, Clone)]
pub struct SimulatedCase {
    /// Metadata known to the user.
    pub meta: CaseMeta,
    /// Columns of the reference log.
    pub reference: Vec<NamedSeries>,
    /// Columns of the log to explain.
    pub log: Vec<NamedSeries>,
    /// Columns of the evaluation log.
    pub evaluation: Vec<NamedSeries>,
    /// Truth unknown to the user.
    pub truth: Truth,
}

/// The truth behind a case.
#[derive(Debug, Clone, Serialize)]
pub struct Truth {
    pub plan: CasePlan,
    /// Planted effects, in the order of the plan.
    pub planted: Vec<Planted>,
    /// True if a planted effect is outside the library.
    pub outside: bool,
    /// True sampling rate, Hz.
    pub rate_hz: f64,
    /// Bias of the target, in its unit.
    pub bias: f64,
    /// Spectral level of the target's fast noise at zero frequency, one-sided, unit/√Hz.
    pub white_density: f64,
    pub noise: AxisNoise,
    /// Disturbed stretches of the log to explain.
    pub disturbed_field: Vec<Disturbed>,
    /// Disturbed stretches of the evaluation log.
    pub disturbed_eval: Vec<Disturbed>,
    /// Error that a perfect model subtracts from the log to explain, and its parts; in truth_log.parquet.
    #[serde(skip)]
    pub log: LogTruth,
    /// The same of the evaluation log; in truth_evaluation.parquet.
    #[serde(skip)]
    pub evaluation: LogTruth,
}

/// Planted error of a log, row by row.
#[derive(Debug, Clone, Default)]
pub struct LogTruth {
    /// Sum of all planted effects on the target, in its unit: the error that a perfect model subtracts.
    pub error: Vec<f64>,
    /// Effect of the disturbances on the axis, in its unit: true motion and outliers, which no model subtracts.
    pub motion: Vec<f64>,
    /// Regressors of all planted effects, named `planted.k.name` with k from 0.
    pub regressors: Vec<NamedSeries>,
}

impl SimulatedCase {
    /// Logs as read by a user: reference, log to explain, evaluation. Streams with separate clocks are resampled. A
    /// simulated log is never invalid.
    pub fn recordings(&self) -> Result<[Recording; 3], RecordingError> {
        let read = |name: &str, columns: &[NamedSeries], log: u64| {
            let options = LoadOptions { rate_hz: Some(self.meta.nominal_rate_hz), ..LoadOptions::default() };
            let source = Source::made_by(name);
            match self.truth.plan.disturbance {
                Disturbance::Streams => {
                    Recording::from_streams(source, split(columns, (self.truth.plan.seed, log)), &options)
                }
                _ => Recording::from_columns(source, columns.to_vec(), &options),
            }
        };
        Ok([
            read("reference", &self.reference, REFERENCE)?,
            read("log", &self.log, LOG)?,
            read("evaluation", &self.evaluation, EVALUATION)?,
        ])
    }
}

/// Simulates a case.
pub fn simulate_case(plan: &CasePlan) -> Result<SimulatedCase, PlanError> {
    let Draft { unit, scene, logged, field, shapes } = draft(plan)?;
    let seed = plan.seed;
    let part = unit.part;
    let target = plan.target;
    let noise = &unit.noise[target as usize];
    let reference = scene.reference(plan.durations.reference_s, &mut random(seed, Stream::World(REFERENCE)));
    let evaluation =
        scene.log(plan.durations.evaluation_s, true, &mut random(seed, Stream::World(EVALUATION)));

    let nothing_moves = Motion::default();
    let quiet = recorder::analog(
        &unit,
        &reference,
        &nothing_moves,
        target,
        &vec![0.0; reference.len()],
        (seed, REFERENCE),
    );
    let none = Faults::default();
    let reference = recorder::record(
        &unit,
        (&reference, &nothing_moves),
        (target, &quiet),
        (&logged, &none),
        (seed, REFERENCE),
    );

    let columns = shapes.iter().map(|shape| shape.columns(&field, LOG, seed)).collect();
    let mut planted =
        planting::size(plan, &shapes, &columns, &field, &logged.names(), (noise, part.lsb(target)))?;
    let weights: Vec<Vec<f64>> = planted.iter().map(|planted| planted.coefficients.clone()).collect();
    let eval_columns = shapes.iter().map(|shape| shape.columns(&evaluation, EVALUATION, seed)).collect();
    let mut faults = Faults::default();
    let mut logs = Vec::new();
    for (world, columns, log) in [(&field, columns, LOG), (&evaluation, eval_columns, EVALUATION)] {
        let mut error = planting::sum(&weights, &columns, world.len());
        let motion = disturbance::motion(plan.disturbance, world, (seed, log));
        let mut analog = recorder::analog(&unit, world, &motion, target, &error, (seed, log));
        let sound = analog.clone();
        let wild =
            disturbance::spoil(plan.disturbance, &mut analog, (noise.white, world.period_s), (seed, log));
        let (lsb, bias) = (part.lsb(target), unit.bias[target as usize]);
        planting::add_faults(
            &mut faults,
            plan,
            &mut planted,
            (&analog, noise),
            (lsb, bias, seed, log == LOG),
        );
        for (error, value) in error.iter_mut().zip(&analog) {
            if faults.limit.is_some() || faults.step.is_some() || faults.dead_zone.is_some() {
                *error += recorder::convert(&part, target, &faults, *value)
                    - recorder::convert(&part, target, &none, *value);
            }
        }
        let record =
            recorder::record(&unit, (world, &motion), (target, &analog), (&logged, &faults), (seed, log));
        let mut regressors: Vec<NamedSeries> = columns
            .into_iter()
            .enumerate()
            .flat_map(|(k, columns): (usize, Vec<NamedSeries>)| {
                columns.into_iter().map(move |(name, values)| (format!("planted.{k}.{name}"), values))
            })
            .collect();
        let shown = |row: usize| motion.at(target as usize, row) + analog[row] - sound[row];
        let mut shown: Vec<f64> = (0..world.len()).map(shown).collect();
        for values in regressors.iter_mut().map(|(_, values)| values).chain([&mut error, &mut shown]) {
            recorder::drop_lost(values, &faults.lost);
        }
        let disturbed: Vec<Disturbed> = motion.when.iter().copied().chain(wild).collect();
        logs.push((record, LogTruth { error, motion: shown, regressors }, disturbed));
    }
    let (evaluation, evaluation_truth, disturbed_eval) = logs.pop().unwrap_or_default();
    let (log, log_truth, disturbed_field) = logs.pop().unwrap_or_default();
    let truth = Truth {
        plan: plan.clone(),
        outside: planted.iter().any(|planted| planted.effect.is_outside()),
        planted,
        rate_hz: 1.0 / noise.period_s,
        bias: unit.bias[target as usize],
        white_density: (2.0 * noise.period_s * noise.fast_density(0.0, 0.0)).sqrt(),
        noise: noise.clone(),
        disturbed_field,
        disturbed_eval,
        log: log_truth,
        evaluation: evaluation_truth,
    };
    Ok(SimulatedCase { meta: meta(plan, &part), reference, log, evaluation, truth })
}
