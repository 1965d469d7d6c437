//! Character of a part's noise, the same in all logs and stated in no data sheet.

use super::Disturbance;
use super::distribution::Distribution;
use super::filter::Filter;
use crate::random::Random;

/// Deviation of the noise of a part from coloured normal noise.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Character {
    /// Passes through the part's digital filter.
    Filtered(Filter),
    Scattered(Distribution),
}

impl Character {
    /// Character of a part under this disturbance, if any.
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
