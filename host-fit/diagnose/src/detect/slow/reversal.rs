//! Steps of the bias where the temperature has just reversed, and warm-ups while it falls: there hysteresis or a lag
//! explains what a clock seems to.
//!
//! A package that sticks lets go after the temperature has come back by a few kelvin, and then often at once; on the
//! next loop it does so again, which no step does.

use super::candidates::Candidate;
use super::model::{SlowSearch, State};
use crate::detect::hypothesis::span;
use crate::detect::shape::TEMPERATURE;
use crate::effects::{Detector, Effect};

/// The temperature has turned where it comes back by this share of its span.
const TURN: f64 = 0.1;

/// Stress is released while the temperature comes back by this share of its span.
const RELEASE: f64 = 0.05;

/// A step at a reversal is one if it explains so many times as much as hysteresis does.
const OUTWEIGHS: f64 = 5.0;

/// An environment that cools the sensor by more than this in one time constant is what its bias follows: self-heating is
/// a few kelvin, upwards. K.
const COOLING: f64 = 2.0;

impl SlowSearch<'_> {
    /// Removes steps at reversals of the temperature unless they outweigh hysteresis, and warm-ups while it falls.
    pub(super) fn without_thermal_steps(&self, state: &State, candidates: &mut Vec<Candidate>) {
        let Some(temperature) = self.hypotheses.logged_means(TEMPERATURE) else { return };
        let reversing = reversing(&temperature);
        let hysteresis = candidates.iter().filter(|candidate| is_hysteresis(&candidate.hypothesis.effect));
        let best = hysteresis.map(|candidate| candidate.score).fold(0.0, f64::max);
        let is_explained = state.accepted.iter().any(|accepted| is_hysteresis(&accepted.effect));
        candidates.retain(|candidate| {
            let (effect, value) = (&candidate.hypothesis.effect, candidate.hypothesis.value);
            match value {
                Some(time_s) if effect.search == Detector::Step => {
                    let is_thermal = is_explained || candidate.score < OUTWEIGHS * best;
                    !(is_thermal && reversing[self.blocks_at(time_s)].contains(&true))
                }
                Some(tau_s) if is_warm_up(effect) => {
                    let last = self.blocks_at(tau_s).start.min(temperature.len() - 1);
                    temperature[0] - temperature[last] < COOLING
                }
                _ => true,
            }
        });
    }

    /// The blocks before and after a time, s after the first sample.
    fn blocks_at(&self, time_s: f64) -> std::ops::Range<usize> {
        let index = (time_s / self.blocks.length_s).round() as u64;
        let after = self.blocks.blocks.partition_point(|block| block.index < index);
        after.saturating_sub(1)..(after + 1).min(self.blocks.len())
    }
}

/// True if the bias follows the path of the temperature.
fn is_hysteresis(effect: &Effect) -> bool {
    effect.terms.iter().any(|term| term.regressor.contains(":backlash("))
}

/// True if the bias settles after power-on.
fn is_warm_up(effect: &Effect) -> bool {
    effect.terms.iter().any(|term| term.regressor.contains("clock:decay("))
}

/// The blocks in which the temperature, having turned, comes back by the first part of its span.
fn reversing(temperature: &[f64]) -> Vec<bool> {
    let span = span(temperature);
    let mut reversing = vec![false; temperature.len()];
    let mut turn = |from: usize| {
        let until = temperature[from];
        let back = |block: &usize| (temperature[*block] - until).abs() <= RELEASE * span;
        (from..temperature.len()).take_while(back).for_each(|block| reversing[block] = true);
    };
    // the extremes since the last turn: one of them is the next turn once the temperature has left it far enough
    let (mut lowest, mut highest) = (0, 0);
    let mut rises: Option<bool> = None;
    for block in 0..temperature.len() {
        if temperature[block] < temperature[lowest] {
            lowest = block;
        }
        if temperature[block] > temperature[highest] {
            highest = block;
        }
        if rises != Some(true) && temperature[block] - temperature[lowest] > TURN * span {
            if rises.is_some() {
                turn(lowest);
            }
            (rises, highest) = (Some(true), block);
        } else if rises != Some(false) && temperature[highest] - temperature[block] > TURN * span {
            if rises.is_some() {
                turn(highest);
            }
            (rises, lowest) = (Some(false), block);
        }
    }
    reversing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temperature_reverses_where_it_comes_back() {
        let down_and_up: Vec<f64> = (0..=200).map(|i| f64::from((100_i32 - i).abs())).collect();
        let found: Vec<usize> = (0..=200).filter(|block| reversing(&down_and_up)[*block]).collect();
        assert_eq!(found, (100..=105).collect::<Vec<_>>());
        assert!(!reversing(&[20.0; 50]).contains(&true));
        let ramp: Vec<f64> = (0..100).map(|i| 20.0 + 0.1 * f64::from(i)).collect();
        assert!(!reversing(&ramp).contains(&true));
    }
}
