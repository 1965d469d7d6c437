//! A case before its noise is drawn: device, surroundings, logged columns, log to explain, and shapes of planted
//! effects.

use super::axis::Axis;
use super::disturbance::Character;
use super::effect::Effect;
use super::part::{Part, true_rate};
use super::plan::{CasePlan, Kind, PlanError};
use super::plant::Plant;
use super::random::{LOG, Stream, chance, random};
use super::recorder::{Logged, Unit};
use super::setup::{Scene, Setup, Wants};
use super::shape::Shape;
use super::world::World;

/// Complete description of a case before its noise is drawn.
pub(super) struct Draft {
    pub(super) unit: Unit,
    pub(super) scene: Scene,
    pub(super) logged: Logged,
    pub(super) field: World,
    pub(super) shapes: Vec<Shape>,
}

/// Draws device, surroundings, columns, log to explain and shapes.
pub(super) fn draft(plan: &CasePlan) -> Result<Draft, PlanError> {
    let part = Part::named(&plan.part).ok_or_else(|| PlanError::Part(plan.part.clone()))?;
    let durations = [plan.durations.reference_s, plan.durations.log_s, plan.durations.evaluation_s];
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
    let rate_hz = true_rate(plan.nominal_rate_hz(), random_unit);
    let unit = Unit {
        part,
        noise: Axis::ALL.map(|axis| part.draw_noise(axis, rate_hz, random_unit)),
        bias: Axis::ALL.map(|axis| part.draw_bias(axis, random_unit)),
        character: Character::draw(plan.disturbance, &mut random(plan.seed, Stream::Disturbance(0))),
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
    let field = scene.log(plan.durations.log_s, false, &mut random(plan.seed, Stream::World(LOG)));
    let shortest_s = plan.durations.log_s.min(plan.durations.evaluation_s);
    let draw = |(number, plant): (usize, &Plant)| {
        Shape::draw(plant, number as u64, (plan.setup, plan.target), (&field, shortest_s), plan.seed)
    };
    let shapes = plan.planted.iter().enumerate().map(draw).collect();
    Ok(Draft { unit, scene, logged, field, shapes })
}
