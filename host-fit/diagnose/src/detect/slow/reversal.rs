//! Exclusion of bias steps at a reversal of the temperature, and of warm-ups while it falls: there hysteresis, a lag or
//! the temperature itself explains what seems to follow the clock.
//!
//! A package with stick-slip yields after the temperature has come back by a few kelvin, often at once, and repeats it
//! on the next loop, which a step does not do.

use super::candidates::Candidate;
use super::model::{SlowSearch, State};
use crate::detect::hypothesis::{Hypothesis, span};
use crate::detect::shape::TEMPERATURE;
use crate::effects::{Detector, Effect};

/// Share of the span by which the temperature must come back to count as reversed.
const TURN: f64 = 0.1;

/// Share of the span over which stress is released after a reversal.
const RELEASE: f64 = 0.05;

/// Ratio of scores from which on a step at a reversal outweighs hysteresis.
const OUTWEIGHS: f64 = 5.0;

/// Cooling within one time constant, K, from which on a bias follows the environment: self-heating is a few kelvin
/// upwards.
const COOLING: f64 = 2.0;

impl SlowSearch<'_> {
    /// Removes steps at reversals of the temperature unless they outweigh hysteresis.
    pub(super) fn remove_thermal_steps(&self, state: &State, candidates: &mut Vec<Candidate>) {
        let Some(temperature) = self.hypotheses.logged_means(TEMPERATURE) else { return };
        let reversing = reversing(&temperature);
        let hysteresis = candidates.iter().filter(|candidate| is_hysteresis(&candidate.hypothesis.effect));
        let best = hysteresis.map(|candidate| candidate.score).fold(0.0, f64::max);
        let is_explained = state.accepted.iter().any(|accepted| is_hysteresis(&accepted.effect));
        candidates.retain(|candidate| match candidate.hypothesis.value {
            Some(time_s) if candidate.hypothesis.effect.search == Detector::Step => {
                let is_thermal = is_explained || candidate.score < OUTWEIGHS * best;
                !(is_thermal && reversing[self.blocks_at(time_s)].contains(&true))
            }
            _ => true,
        });
    }

    /// Returns the best candidate that may be reported. A warm-up while the temperature falls is not; it remains a rival of
    /// what is, since the log cannot exclude it.
    pub(super) fn best_reported(&self, candidates: Vec<Candidate>) -> Option<Candidate> {
        candidates.into_iter().find(|candidate| !self.is_cooling_warm_up(&candidate.hypothesis))
    }

    fn is_cooling_warm_up(&self, Hypothesis { effect, value, .. }: &Hypothesis) -> bool {
        let Some(tau_s) = value.filter(|_| is_warm_up(effect)) else { return false };
        self.hypotheses.logged_means(TEMPERATURE).is_some_and(|temperature| {
            let last = self.blocks_at(tau_s).start.min(temperature.len() - 1);
            temperature[0] - temperature[last] >= COOLING
        })
    }

    /// Returns the blocks before and after a time, s after the first sample.
    fn blocks_at(&self, time_s: f64) -> std::ops::Range<usize> {
        let index = (time_s / self.blocks.length_s).round() as u64;
        let after = self.blocks.blocks.partition_point(|block| block.index < index);
        after.saturating_sub(1)..(after + 1).min(self.blocks.len())
    }
}

/// Returns true for an effect that depends on the path of the temperature.
fn is_hysteresis(effect: &Effect) -> bool {
    effect.terms.iter().any(|term| term.regressor.contains(":backlash("))
}

/// Returns true for an effect that settles after power-on.
fn is_warm_up(effect: &Effect) -> bool {
    effect.terms.iter().any(|term| term.regressor.contains("clock:decay("))
}

/// Marks the blocks in which the temperature, after a reversal, comes back by the first [`RELEASE`] of its span.
fn reversing(temperature: &[f64]) -> Vec<bool> {
    let span = span(temperature);
    let mut reversing = vec![false; temperature.len()];
    let mut turn = |from: usize| {
        let until = temperature[from];
        let back = |block: &usize| (temperature[*block] - until).abs() <= RELEASE * span;
        (from..temperature.len()).take_while(back).for_each(|block| reversing[block] = true);
    };
    // extremes since the last reversal: one of them is the next reversal once the temperature has moved far enough from
    // it
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
    fn finds_reversals_of_temperature() {
        let down_and_up: Vec<f64> = (0..=200).map(|i| f64::from((100_i32 - i).abs())).collect();
        let found: Vec<usize> = (0..=200).filter(|block| reversing(&down_and_up)[*block]).collect();
        assert_eq!(found, (100..=105).collect::<Vec<_>>());
        assert!(!reversing(&[20.0; 50]).contains(&true));
        let ramp: Vec<f64> = (0..100).map(|i| 20.0 + 0.1 * f64::from(i)).collect();
        assert!(!reversing(&ramp).contains(&true));
    }
}
