//! Random telegraph noise: a bias that jumps between the same two levels at random times.
//!
//! A course of two levels is decoded from the block means (Viterbi), then fitted by generalised least squares with the
//! coloured noise of the reference log, like any other regressor. Its penalty is the code length of its transitions, so
//! that noise alone, which some course of two levels always explains in part, does not pass.

use fos_fit::noise::{Blocks, Fitted, LevelPrior, NoiseLevels, Regression};
use fos_fit::signal::{centred, mean, variance};

use super::left_over::{INSTEAD, LeftOver};
use super::open::{self, Lead, LeadKind};
use super::prepared::Prepared;
use super::slow::{ACCEPT, Found, SlowResult};
use crate::effects::{Band, Detector};
use fos_data::statistics::median_of;

/// Least number of transitions in each direction: one up and one down may be a temporary fault.
const MIN_EACH_WAY: usize = 2;

/// Windows over which slow wander is removed before decoding, as shares of the log; above 1 it is not removed.
const WINDOWS: [f64; 4] = [2.0, 0.4, 0.15, 0.05];

/// Iterations of decoding, levels and wander; they converge after three or four.
const TURNS: usize = 8;

/// Penalty for the time of a transition inside its block.
const MOMENT_PRICE: f64 = 2.0;

/// Largest share of the transitions that may lie in pairs within a block.
const MAX_VISITS: f64 = 0.5;

/// Excess noise that explains this share of what the two levels explain refutes them.
const NOISE_SHARE: f64 = 0.2;

/// A course of two levels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Telegraph {
    /// Course in block means about its mean: levels differ by 1, a block with a transition lies in between.
    pub(super) course: Vec<f64>,
    /// Upper minus lower level, unit of the axis, and its standard error.
    pub(super) difference: [f64; 2],
    /// Mean dwell time in the lower and in the upper level, s.
    pub(super) dwell_s: [f64; 2],
    pub(super) transitions: usize,
    /// Decrease of −2 ln L.
    pub(super) gain: f64,
    /// Gain minus a penalty for its coefficients and the code of its transitions.
    pub(super) score: f64,
}

/// Returns random telegraph noise if it explains the residual better than steps, other functions of the clock, excess
/// noise and leads together.
pub(super) fn instead(prepared: &Prepared<'_>, slow: &SlowResult, left: &LeftOver) -> Option<Telegraph> {
    let mut regressors: Vec<&[f64]> = prepared.given.iter().map(Vec::as_slice).collect();
    for found in slow.found.iter().filter(|found| found.is_backed()) {
        regressors.extend(found.hypothesis.columns());
    }
    let reduced = &prepared.reduced;
    let residual = Residual {
        blocks: &reduced.blocks,
        y: &reduced.means,
        regressors: &regressors,
        prior: &slow.reference_prior,
    };
    let telegraph = residual.telegraph()?;
    let lead = left.leads.iter().map(|lead| lead.score).fold(0.0, f64::max);
    let replaced = if left.instead { lead } else { slow.unbacked() + slow.noise_score.max(0.0) + lead };
    (telegraph.score > replaced + INSTEAD).then_some(telegraph)
}

impl Telegraph {
    /// Returns true if a search with the telegraph noise in the model finds no step and little excess noise.
    pub(super) fn leaves_noise(&self, beside: &SlowResult) -> bool {
        let is_step = |found: &Found| found.hypothesis.effect.search == Detector::Step;
        beside.noise_gain < NOISE_SHARE * self.gain && !beside.found.iter().any(is_step)
    }
}

/// Returns the lead to a logged quantity whose threshold decides the level: what another quantity switches is not random.
pub(super) fn decided(found: &Telegraph, prepared: &Prepared<'_>) -> Option<Lead> {
    let reduced = &prepared.reduced;
    let follows = open::threshold_of(prepared.log(), &reduced.blocks, &prepared.column, &found.course)?;
    let explained = found.difference[0].powi(2) * variance(&[&found.course]);
    let share = (explained / variance(&[&reduced.means])).min(1.0);
    let lead = Lead::new(LeadKind::Course, follows, Band::Slow, found.score);
    Some(Lead { gain: found.gain, share, ..lead })
}

/// Residual of a log after everything that follows a logged quantity.
pub(super) struct Residual<'a> {
    pub(super) blocks: &'a Blocks,
    pub(super) y: &'a [f64],
    pub(super) regressors: &'a [&'a [f64]],
    pub(super) prior: &'a LevelPrior,
}

impl Residual<'_> {
    /// Returns the best course of two levels if it is worth its penalty.
    pub(super) fn telegraph(&self) -> Option<Telegraph> {
        // with an unknown level after every turn the two levels cannot be compared
        if !self.blocks.restarts().is_empty() {
            return None;
        }
        let null = self.fit(&[]);
        let residual = null.gls.unexplained(self.y, self.regressors);
        let courses = WINDOWS.iter().filter_map(|share| decoded(&residual, *share));
        let mut best: Option<(f64, Decoded)> = None;
        for decoded in courses {
            let with = self.at(&decoded.course, null.levels);
            let score = null.deviance - with.deviance - self.price(&decoded);
            if best.as_ref().is_none_or(|(other, _)| score > *other) {
                best = Some((score, decoded));
            }
        }
        let (_, decoded) = best?;
        let with = self.fit(&[&decoded.course]);
        let gain = null.deviance - with.deviance;
        let score = gain - self.price(&decoded);
        let place = self.regressors.len();
        let difference = *with.gls.coefficients().get(place)?;
        let at = with.gls.kept.iter().position(|kept| *kept == place)?;
        let error = with.gls.covariance()[(at, at)].sqrt();
        let is_worth_it = score >= ACCEPT && difference > 0.0;
        is_worth_it.then(|| Telegraph {
            difference: [difference, error],
            dwell_s: decoded.dwell(self.blocks.length_s),
            transitions: decoded.transitions(),
            course: decoded.course,
            gain,
            score,
        })
    }

    fn fit(&self, further: &[&[f64]]) -> Fitted {
        let regressors: Vec<&[f64]> = self.regressors.iter().chain(further).copied().collect();
        let Self { blocks, y, prior, .. } = *self;
        Regression { blocks, y, regressors: &regressors, prior }.fit(NoiseLevels::from_logs(&prior.mean))
    }

    fn at(&self, course: &[f64], levels: NoiseLevels) -> Fitted {
        let regressors: Vec<&[f64]> = self.regressors.iter().copied().chain([course]).collect();
        let Self { blocks, y, prior, .. } = *self;
        Regression { blocks, y, regressors: &regressors, prior }.at(levels)
    }

    /// Penalty: one coefficient, two transition rates, and −2 ln P of the states under these rates.
    fn price(&self, decoded: &Decoded) -> f64 {
        let n = self.y.len() as f64;
        let visits = decoded.visits as f64 * visit_price(self.y.len());
        3.0 * n.ln() + decoded.code_length() + MOMENT_PRICE * decoded.transitions() as f64 + visits
    }
}

/// State of every block, and the course with the transitions inside their blocks.
#[derive(Debug, Clone)]
struct Decoded {
    states: Vec<bool>,
    course: Vec<f64>,
    /// Number of blocks in which the other level was visited, in addition to those at a transition.
    visits: usize,
}

impl Decoded {
    fn transitions(&self) -> usize {
        self.each_way().iter().sum()
    }

    /// Returns the number of transitions out of the lower and out of the upper level.
    fn each_way(&self) -> [usize; 2] {
        let out_of =
            |state: bool| self.states.windows(2).filter(|pair| pair[0] == state && pair[1] != state).count();
        [out_of(false), out_of(true)]
    }

    /// Returns the number of blocks in the lower and in the upper level.
    fn blocks_in(&self) -> [usize; 2] {
        let upper = self.states.iter().filter(|state| **state).count();
        [self.states.len() - upper, upper]
    }

    /// Returns −2 ln P of the states with one transition rate per level.
    fn code_length(&self) -> f64 {
        let bits = |left: usize, all: usize| -> f64 {
            let (left, all) = (left as f64, all as f64);
            let term = |part: f64| if part > 0.0 { -2.0 * part * (part / all).ln() } else { 0.0 };
            term(left) + term(all - left)
        };
        let (left, all) = (self.each_way(), self.blocks_in());
        bits(left[0], all[0]) + bits(left[1], all[1])
    }

    fn dwell(&self, length_s: f64) -> [f64; 2] {
        let (left, all) = (self.each_way(), self.blocks_in());
        [0, 1].map(|state| all[state] as f64 * length_s / left[state].max(1) as f64)
    }
}

/// Decodes two levels after slow wander over `share` of the values is removed; `None` if there are not two.
fn decoded(values: &[f64], share: f64) -> Option<Decoded> {
    let window = (share * values.len() as f64) as usize;
    let off = |values: &[f64]| -> Vec<f64> {
        match window < values.len() {
            true => moving_mean(values, window),
            false => vec![mean(&[values]); values.len()],
        }
    };
    let mut wander = off(values);
    let mut states: Vec<bool> = values.iter().zip(&wander).map(|(value, wander)| value > wander).collect();
    let mut levels = [0.0; 2];
    for _ in 0..TURNS {
        let flat: Vec<f64> = values.iter().zip(&wander).map(|(value, wander)| value - wander).collect();
        levels = levels_of(&flat, &states)?;
        let level = |state: bool| levels[usize::from(state)];
        let left: Vec<f64> = flat.iter().zip(&states).map(|(value, state)| value - level(*state)).collect();
        let changes = states.windows(2).filter(|pair| pair[0] != pair[1]).count();
        states = viterbi(&flat, levels, variance(&[&left]), (changes + 1) as f64 / values.len() as f64);
        let without: Vec<f64> =
            values.iter().zip(&states).map(|(value, state)| value - levels[usize::from(*state)]).collect();
        wander = off(&without);
    }
    let flat: Vec<f64> = values.iter().zip(&wander).map(|(value, wander)| value - wander).collect();
    let (course, visits) = course(&flat, &states, levels);
    let decoded = Decoded { states, course, visits };
    let may_visit = decoded.visits as f64 <= MAX_VISITS * decoded.transitions() as f64;
    (may_visit && decoded.each_way().iter().all(|count| *count >= MIN_EACH_WAY)).then_some(decoded)
}

/// Returns the means of the values in the lower and in the upper state.
fn levels_of(values: &[f64], states: &[bool]) -> Option<[f64; 2]> {
    let of = |wanted: bool| {
        let values: Vec<f64> =
            values.iter().zip(states).filter(|(_, state)| **state == wanted).map(|(v, _)| *v).collect();
        (!values.is_empty()).then(|| mean(&[&values]))
    };
    let (lower, upper) = (of(false)?, of(true)?);
    (upper > lower).then_some([lower, upper])
}

/// Returns the most probable states of values about two levels, with transition probability `change` from one value to
/// the next.
fn viterbi(values: &[f64], levels: [f64; 2], variance: f64, change: f64) -> Vec<bool> {
    let change = change.clamp(1e-4, 0.5);
    let (stays, changes) = (-2.0 * (1.0 - change).ln(), -2.0 * change.ln());
    let cost = |value: f64, state: usize| (value - levels[state]).powi(2) / variance.max(f64::MIN_POSITIVE);
    let mut sums = [0.0_f64; 2];
    let mut from: Vec<[bool; 2]> = Vec::with_capacity(values.len());
    for value in values {
        let reached = [0, 1].map(|state: usize| {
            let (same, other) = (sums[state] + stays, sums[1 - state] + changes);
            // previous state of the cheapest path
            (same.min(other), if same <= other { state == 1 } else { state == 0 })
        });
        from.push(reached.map(|(_, state)| state));
        sums = [0, 1].map(|state: usize| reached[state].0 + cost(*value, state));
    }
    let mut state = sums[1] < sums[0];
    let mut states = vec![false; values.len()];
    for (at, from) in from.iter().enumerate().rev() {
        states[at] = state;
        state = from[usize::from(state)];
    }
    states
}

/// Penalty of a visit to the other level within one block of `n`: two transitions, each in any block.
fn visit_price(n: usize) -> f64 {
    4.0 * (n as f64).ln()
}

/// Returns 0 in the lower and 1 in the upper level about the mean, and the number of visits. Of the two blocks at a
/// transition, the one whose mean is further between the levels contains it and gets a fraction. So does any block that is
/// further between them than noise puts it by the price of a visit: the other level was visited within it.
fn course(values: &[f64], states: &[bool], levels: [f64; 2]) -> (Vec<f64>, usize) {
    let difference = levels[1] - levels[0];
    let share = |block: usize| ((values[block] - levels[0]) / difference).clamp(0.0, 1.0);
    let state = |block: usize| f64::from(u8::from(states[block]));
    let off = |block: usize| (share(block) - state(block)).abs();
    let mut course: Vec<f64> = (0..states.len()).map(state).collect();
    for block in 1..states.len() {
        if states[block] != states[block - 1] {
            let mixed = if off(block) > off(block - 1) { block } else { block - 1 };
            course[mixed] = share(mixed);
        }
    }
    let left =
        (0..states.len()).map(|block| (values[block] - levels[0] - course[block] * difference).powi(2));
    // half of the squares of normal noise lie below 0.455 of its variance
    let variance = median_of(left).unwrap_or(0.0) / 0.455;
    let mut visits = 0;
    for (block, value) in course.iter_mut().enumerate() {
        let is_whole = *value == state(block);
        if is_whole && (off(block) * difference).powi(2) > visit_price(states.len()) * variance {
            *value = share(block);
            visits += 1;
        }
    }
    (centred(course), visits)
}

/// Centred moving means, shorter at the ends.
fn moving_mean(values: &[f64], window: usize) -> Vec<f64> {
    let half = (window / 2).max(1);
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..values.len())
        .map(|at| {
            let (from, to) = (at.saturating_sub(half), (at + half + 1).min(values.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    /// Levels 0 and `height` with these dwell times in turn, in noise of unit variance.
    fn values(dwells: &[usize], height: f64, seed: u64) -> (Vec<f64>, Vec<bool>) {
        let states: Vec<bool> =
            dwells.iter().enumerate().flat_map(|(at, dwell)| vec![at % 2 == 1; *dwell]).collect();
        let noise = white_noise(seed, states.len());
        (
            noise.iter().zip(&states).map(|(v, state)| v + height * f64::from(u8::from(*state))).collect(),
            states,
        )
    }

    #[test]
    fn decodes_two_levels_in_noise_and_in_wander() {
        let dwells = [40, 20, 60, 15, 30, 80, 12, 40, 25, 50, 30];
        let (plain, states) = values(&dwells, 5.0, 1);
        let right = |decoded: &Decoded| {
            decoded.states.iter().zip(&states).filter(|(found, state)| found == state).count() as f64
                / states.len() as f64
        };
        let found = decoded(&plain, 2.0).unwrap();
        assert!(right(&found) > 0.98, "{}", right(&found));
        assert_eq!(found.transitions(), dwells.len() - 1);
        let wandering: Vec<f64> =
            plain.iter().enumerate().map(|(at, value)| value + 6.0 * (at as f64 / 90.0).sin()).collect();
        let best = WINDOWS.iter().filter_map(|share| decoded(&wandering, *share));
        let best = best.map(|decoded| right(&decoded)).fold(0.0, f64::max);
        assert!(best > 0.9, "{best}");
    }

    #[test]
    fn finds_no_two_levels_in_a_step_or_a_constant() {
        let (step, _) = values(&[200, 200], 5.0, 2);
        assert!(decoded(&step, 2.0).is_none());
        assert!(decoded(&[1.0; 100], 2.0).is_none());
    }
}
