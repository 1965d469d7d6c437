//! A case: the logs of one unit, an effect planted in two of them, and the truth.

use serde::Serialize;

use super::axis::Axis;
use super::case_meta::meta;
use super::coloured::AxisNoise;
use super::effect::Effect;
use super::part::{Part, true_rate};
use super::plan::{CasePlan, Kind, NOMINAL_RATE_HZ, PlanError};
use super::plant::{Plant, Shape};
use super::planting::{self, Planted};
use super::random::{Stream, chance, random};
use super::recorder::{self, Faults, Logged, Unit};
use super::regressors::NamedSeries;
use super::setup::{Scene, Setup, Wants};
use super::world::World;
use fos_data::case::CaseMeta;

/// The logs of a case and the truth behind them.
#[derive(Debug, Clone)]
pub struct SimulatedCase {
    /// What the user is told.
    pub meta: CaseMeta,
    /// The quiet log.
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

/// Everything about a case before its noise is drawn.
pub(super) struct Draft {
    pub(super) unit: Unit,
    pub(super) scene: Scene,
    pub(super) logged: Logged,
    pub(super) field: World,
    pub(super) shapes: Vec<Shape>,
}

const BASELINE: u64 = 0;
const FIELD: u64 = 1;
const EVAL: u64 = 2;

/// Draws unit, surroundings, columns, field and shapes.
pub(super) fn draft(plan: &CasePlan) -> Result<Draft, PlanError> {
    let part = Part::named(&plan.part).ok_or_else(|| PlanError::Part(plan.part.clone()))?;
    let durations = [plan.durations.baseline_s, plan.durations.field_s, plan.durations.eval_s];
    if !durations.iter().all(|duration_s| *duration_s >= 60.0) {
        return Err(PlanError::Short);
    }
    for plant in &plan.planted {
        if !plant.effect.suits(plan.setup, plan.target) {
            let (effect, setup, target) = (plant.effect, plan.setup, plan.target);
            return Err(PlanError::Unsuited { effect, setup, target });
        }
        if !(plant.size > 0.0
            && plant.size.is_finite()
            && plant.parameter.is_none_or(|p| p > 0.0 && p.is_finite()))
        {
            return Err(PlanError::Size(plant.effect));
        }
    }
    let effects = || plan.planted.iter().map(|plant| plant.effect);
    let random_unit = &mut random(plan.seed, Stream::Unit);
    let rate_hz = true_rate(NOMINAL_RATE_HZ, random_unit);
    let unit = Unit {
        part,
        noise: Axis::ALL.map(|axis| part.draw_noise(axis, rate_hz, random_unit)),
        bias: Axis::ALL.map(|axis| part.draw_bias(axis, random_unit)),
    };
    let needs = |name: &str| effects().any(|effect| effect.description().needs.contains(&name));
    let other = matches!(plan.kind, Kind::Inseparable(..));
    let columns = &mut random(plan.seed, Stream::Columns);
    let logged = Logged {
        temp: chance(columns, 0.93) || needs("temp_c") || other,
        supply: chance(columns, 0.6) || needs("supply_v") || other,
        load: chance(columns, if plan.setup == Setup::Desk { 0.9 } else { 0.15 }) || needs("load_pct"),
        mag: chance(columns, 0.6) || needs("mag_x_ut") || other,
    };
    let wants = Wants {
        temperature: effects().any(Effect::moves_with_temperature),
        supply: effects().any(Effect::moves_with_supply),
        magnets: effects().any(|effect| effect == Effect::MagSensitivity),
        same_pose: effects().any(|effect| effect == Effect::Saturation),
    };
    let turns_target = match effects()
        .find(|e| e.suits(Setup::RateTable, plan.target) && !e.suits(Setup::Bench, plan.target))
    {
        Some(effect) => !matches!(effect, Effect::CrossAxis | Effect::LeverArm),
        None => plan.target.is_gyro(),
    };
    let scene = Scene::draw(
        (plan.setup, plan.path),
        wants,
        (plan.target, turns_target),
        1.0 / rate_hz,
        &mut random(plan.seed, Stream::World(9)),
    );
    let field = scene.log(plan.durations.field_s, false, &mut random(plan.seed, Stream::World(FIELD)));
    let shortest_s = plan.durations.field_s.min(plan.durations.eval_s);
    let draw = |(number, plant): (usize, &Plant)| {
        Shape::draw(plant, number as u64, (plan.setup, plan.target), (&field, shortest_s), plan.seed)
    };
    let shapes = plan.planted.iter().enumerate().map(draw).collect();
    Ok(Draft { unit, scene, logged, field, shapes })
}

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
