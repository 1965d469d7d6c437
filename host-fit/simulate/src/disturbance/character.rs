//! What a part makes of its own noise, in all logs alike, and no data sheet says.

use super::Disturbance;
use super::distribution::Distribution;
use super::filter::Filter;
use crate::random::Random;

/// How the noise of a part differs from coloured normal noise.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Character {
    /// It goes through the part's digital filter.
    Filtered(Filter),
    Scattered(Distribution),
}

impl Character {
    /// That of a part in this world, if it has one.
    pub(crate) fn draw(disturbance: Disturbance, random: &mut Random) -> Option<Self> {
        match disturbance {
            Disturbance::Filter => Some(Self::Filtered(Filter::draw(random))),
            Disturbance::Noise => Some(Self::Scattered(Distribution::draw(random))),
            _ => None,
        }
    }

    pub(crate) fn apply(&self, noise: &[f64], random: &mut Random) -> Vec<f64> {
        match self {
            Self::Filtered(filter) => filter.apply(noise),
            Self::Scattered(distribution) => distribution.apply(noise, random),
        }
    }
}
