//! A case: the logs of one unit, an effect planted in two of them, and the truth.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::effect::Effect;
use super::part::{PARTS, Part, true_rate};
use super::plant::{Plant, Shape};
use super::planting::{self, Planted};
use super::random::{Stream, chance, random};
use super::recorder::{self, Faults, Logged, Unit};
use super::regressors::Column;
use super::setup::{Path, Scene, Setup, Wants};
use super::world::World;
use crate::case::{CaseFiles, CaseMeta, Datasheet};

/// Nominal sample rate, Hz.
pub const NOMINAL_RATE_HZ: f64 = 200.0;

/// How long the logs are, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Durations {
    /// The quiet log.
    pub baseline_s: f64,
    /// The log to be explained.
    pub field_s: f64,
    /// The log to be corrected.
    pub eval_s: f64,
}

impl Default for Durations {
    fn default() -> Self {
        Self { baseline_s: 600.0, field_s: 1500.0, eval_s: 900.0 }
    }
}

/// What a case is for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing is missing.
    Nothing,
    /// One effect.
    Single(Level),
    /// Two effects that can be told apart.
    Pair,
    /// One of two effects that this log cannot tell apart.
    Inseparable(Effect, Effect),
    /// Something that no library has.
    Outside,
}

/// How clear an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Of size 10 to 16.
    Weak,
    /// Of size 22 to 45.
    Medium,
    /// Of size 80 to 300.
    Strong,
}

/// A case to simulate. The same plan gives the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CasePlan {
    /// Of every random number.
    pub seed: u64,
    /// Name of the part, as in [`PARTS`].
    pub part: String,
    /// How the unit is used.
    pub setup: Setup,
    /// Course of the covariates.
    pub path: Path,
    /// The axis to be explained.
    pub target: Axis,
    /// What is planted in field and evaluation.
    pub planted: Vec<Plant>,
    /// How long the logs are.
    pub durations: Durations,
    /// What the case is for.
    pub kind: Kind,
}

impl CasePlan {
    /// A plan with nothing planted.
    pub fn new(seed: u64, part: &str, setup: Setup, target: Axis) -> Self {
        Self {
            seed,
            part: part.to_owned(),
            setup,
            path: Path::Drawn,
            target,
            planted: Vec::new(),
            durations: Durations::default(),
            kind: Kind::Nothing,
        }
    }
}

/// A plan that cannot be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// No such part.
    #[error("there is no part {0:?}; choose from {parts}", parts = PARTS.map(|part| part.name).join(", "))]
    Part(String),
    /// The set-up cannot show the effect on this axis.
    #[error("{effect} does not show on {} in the set-up {setup:?}{}", .target.column(), places(*.effect))]
    Unsuited {
        /// The effect.
        effect: Effect,
        /// The set-up.
        setup: Setup,
        /// The axis.
        target: Axis,
    },
    /// The effect is nothing on this log: a parameter out of reach, or a log too short.
    #[error("{effect} with parameter {parameter} makes no error in a field of this length")]
    Nothing {
        /// The effect.
        effect: Effect,
        /// Its parameter.
        parameter: f64,
    },
    /// A log is too short.
    #[error("a log must last 60 s or more")]
    Short,
    /// A size is not positive, a parameter is no number.
    #[error("size and parameter of {0} must be positive numbers")]
    Size(Effect),
}

fn places(effect: Effect) -> String {
    let all = Setup::ALL.iter().flat_map(|setup| [(*setup, Axis::Ax), (*setup, Axis::Gx)]);
    let shown = all.filter(|(setup, axis)| effect.suits(*setup, *axis)).map(|(setup, axis)| {
        format!("{} of {setup:?}", if axis.is_gyro() { "a gyro" } else { "an accelerometer" })
    });
    format!("; choose from {}", shown.collect::<Vec<_>>().join(", "))
}

/// The logs of a case and the truth behind them.
#[derive(Debug, Clone)]
pub struct SimulatedCase {
    /// What the user is told.
    pub meta: CaseMeta,
    /// The quiet log.
    pub baseline: Vec<Column>,
    /// The log to be explained.
    pub field: Vec<Column>,
    /// The log to be corrected.
    pub eval: Vec<Column>,
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
    pub noise: super::coloured::AxisNoise,
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
    pub regressors: Vec<Column>,
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
        let mut regressors: Vec<Column> = columns
            .into_iter()
            .enumerate()
            .flat_map(|(k, columns): (usize, Vec<Column>)| {
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

fn meta(plan: &CasePlan, part: &Part) -> CaseMeta {
    CaseMeta {
        schema: "fos-case/1".to_owned(),
        case: "case".to_owned(),
        target: plan.target.column().to_owned(),
        device: format!("{}-like", part.name),
        setup: plan.setup.words().to_owned(),
        nominal_rate_hz: NOMINAL_RATE_HZ,
        accel_full_scale_mps2: Some(part.full_scale(Axis::Ax)),
        gyro_full_scale_rads: Some(part.full_scale(Axis::Gx)),
        accel_lsb_mps2: Some(part.lsb(Axis::Ax)),
        gyro_lsb_rads: Some(part.lsb(Axis::Gx)),
        datasheet: Datasheet {
            gyro_noise_density_dps_rthz: Some(part.gyro_noise_density_dps_rthz),
            accel_noise_density_ug_rthz: Some(part.accel_noise_density_ug_rthz),
            gyro_bias_instability_dph: Some(part.gyro_bias_instability_dph),
            accel_bias_instability_ug: Some(part.accel_bias_instability_ug),
            gyro_tco_dps_per_k: Some(part.gyro_tco_dps_per_k),
            accel_tco_mg_per_k: Some(part.accel_tco_mg_per_k),
        },
        files: CaseFiles {
            baseline: Some("baseline".to_owned()),
            field: Some("field".to_owned()),
            eval: Some("eval".to_owned()),
        },
        note: "baseline: quiet log of the same unit, nothing missing. field: explain its target channel. eval: apply the final model, nothing to fit.".to_owned(),
    }
}
