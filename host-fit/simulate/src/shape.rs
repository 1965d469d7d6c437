//! Shape of a planted effect, drawn unless the plan states it.

use super::axis::Axis;
use super::effect::{Effect, Outside};
use super::plant::Plant;
use super::random::{Random, Stream, between, chance, direction, log_between, random, sign};
use super::regressors::Anchor;
use super::setup::Setup;
use super::world::World;

/// Shape of a planted effect: all of it but the size.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    pub(super) effect: Effect,
    pub(super) parameter: f64,
    pub(super) weights: Vec<f64>,
    pub(super) anchor: Anchor,
    /// Phase of a wiggle, position of a dip or threshold: 0 … 2π.
    pub(super) phase: f64,
    covariate: Covariate,
    pub(super) target: Axis,
    pub(super) number: u64,
}

/// Covariate that controls a noise level or a threshold.
#[derive(Debug, Clone, Copy)]
enum Covariate {
    Temperature,
    Supply,
    Load,
}

impl Shape {
    /// Draws the values that the plan does not state.
    pub(super) fn draw(
        plant: &Plant,
        number: u64,
        (setup, target): (Setup, Axis),
        (field, shortest_s): (&World, f64),
        seed: u64,
    ) -> Self {
        let random = &mut random(seed, Stream::Plant(number));
        let range = match plant.effect {
            // well inside the log
            Effect::BiasStep => [0.25 * shortest_s, 0.75 * shortest_s],
            effect => effect.description().parameter.map_or([1.0; 2], |(_, range)| range),
        };
        let drawn = log_between(random, range[0], range[1]);
        let phase = between(random, 0.0, std::f64::consts::TAU);
        let covariate = match setup {
            Setup::Desk if chance(random, 0.5) => Covariate::Load,
            _ if chance(random, 0.5) || plant.effect == Effect::Outside(Outside::NoiseLevel) => {
                Covariate::Supply
            }
            _ => Covariate::Temperature,
        };
        let anchor = Anchor::of(field, target);
        let parameter = plant.parameter.unwrap_or(drawn);
        let weights = weights(plant.effect, phase, random);
        Self { effect: plant.effect, parameter, weights, anchor, phase, covariate, target, number }
    }

    /// Temperature relative to the middle of its range in the log to explain, in halves of that range.
    pub(super) fn temp(&self, world: &World) -> Vec<f64> {
        scaled(&world.temp_c, self.anchor.temp)
    }

    /// Supply on the same relative scale.
    pub(super) fn supply(&self, world: &World) -> Vec<f64> {
        scaled(&world.supply_v, self.anchor.supply)
    }

    /// Load on the same relative scale.
    pub(super) fn load(&self, world: &World) -> Vec<f64> {
        scaled(&world.load_pct, self.anchor.load)
    }

    /// Controlling covariate of a threshold or a noise level on the same relative scale.
    pub(super) fn source(&self, world: &World) -> Vec<f64> {
        match self.covariate {
            Covariate::Temperature => self.temp(world),
            Covariate::Supply => self.supply(world),
            Covariate::Load => self.load(world),
        }
    }

    /// Name of the controlling covariate, if there is a choice.
    pub(super) fn source_name(&self) -> Option<&'static str> {
        matches!(self.effect, Effect::Outside(Outside::Threshold | Outside::NoiseLevel)).then_some(match self
            .covariate
        {
            Covariate::Temperature => "temp_c",
            Covariate::Supply => "supply_v",
            Covariate::Load => "load_pct",
        })
    }
}

/// Weights of the columns of an effect, before its size.
fn weights(effect: Effect, phase: f64, random: &mut Random) -> Vec<f64> {
    match effect {
        Effect::MagSensitivity | Effect::GSensitivity | Effect::LeverArm => direction(random).to_vec(),
        // curved for certain: otherwise it is temp_linear
        Effect::TempPoly => {
            let curved = [between(random, 0.4, 1.0), between(random, 0.3, 1.0)];
            vec![between(random, -1.0, 1.0), sign(random) * curved[0], sign(random) * curved[1]]
        }
        Effect::SfNonlinearity | Effect::CrossAxis => {
            let angle = between(random, 0.0, std::f64::consts::TAU);
            vec![angle.cos(), angle.sin()]
        }
        Effect::SpectralLine | Effect::DriftingLine => vec![phase.cos(), phase.sin()],
        _ => vec![sign(random)],
    }
}

fn scaled(values: &[f64], [middle, half]: [f64; 2]) -> Vec<f64> {
    values.iter().map(|x| (x - middle) / half).collect()
}
