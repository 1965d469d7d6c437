//! Which slow effects are missing: forward selection among hypotheses by penalised likelihood, the noise levels fitted anew
//! under each, noise itself among them; then exchanges, and what the log cannot tell apart.

mod describe;

use std::ops::Range;
use std::rc::Rc;

use super::hypothesis::{Hypotheses, Hypothesis};
use crate::effects::{Effect, Search};
use fos_data::recording::RecordingError;
use fos_fit::noise::Blocks;
use fos_fit::noise::{Fitted, LevelPrior, Regression};
use fos_fit::noise::{GaussMarkov, NoiseLevels};

/// Hypotheses whose noise levels are fitted: the best of the first pass.
const FITTED: usize = 9;

/// Least score of what is accepted. On simulated logs with nothing missing the best score of all passes 9 less often than
/// once in a hundred (docs/calibration.md).
pub(super) const ACCEPT: f64 = 9.0;

/// Price of a parameter that is searched for, beside that of its grid.
const PARAMETER_PRICE: f64 = 1.5;

/// Price of an effect that follows nothing but the clock: odds of 7 to 1 that what also follows a logged quantity is no
/// coincidence.
const CLOCK_PRICE: f64 = 4.0;

/// Most effects that are found one after the other.
const MAX_FOUND: usize = 4;

/// Rivals within this much of a finding, in −2 ln L, cannot be told from it: odds of 33 to 1.
pub(super) const INSEPARABLE: f64 = 7.0;

/// Standard deviation of the logarithm of a random walk that nothing is known of.
pub(super) const FREE_WALK: f64 = 3.0;

/// A slow effect that was found.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// The effect and the value of its parameter.
    pub(super) hypothesis: Hypothesis,
    /// Where its regressors stand among those of the fit.
    pub(super) place: Range<usize>,
    /// Standard error of the logarithm of the parameter.
    pub(super) log_error: Option<f64>,
    /// By how much −2 ln L falls with it, given everything else.
    pub(super) gain: f64,
    /// The gain after the price of its coefficients, its parameter, and its grid.
    pub(super) score: f64,
    /// Hypotheses that could stand in its place, with how much worse they are in −2 ln L.
    pub(super) rivals: Vec<(Hypothesis, f64)>,
}

/// Noise beyond the baseline's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ExtraNoise {
    /// None.
    None,
    /// A further Gauss-Markov process.
    GaussMarkov(GaussMarkov),
    /// A random walk larger than the baseline allows.
    Walk,
}

/// What was found in the slow band.
#[derive(Debug, Clone)]
pub(super) struct SlowResult {
    /// The effects, in the order of the regressors of the fit.
    pub(super) found: Vec<Found>,
    /// Noise beyond the baseline's, its gain and its score.
    pub(super) noise: ExtraNoise,
    /// By how much −2 ln L falls with it.
    pub(super) noise_gain: f64,
    /// The gain after its price.
    pub(super) noise_score: f64,
    /// The regression with all that was found.
    pub(super) fitted: Fitted,
    /// What was known of the levels, without further noise.
    pub(super) quiet_prior: LevelPrior,
    /// The prior of the levels it was fitted with.
    pub(super) prior: LevelPrior,
    /// Every effect that was tried alone: its best score; first those that explain most.
    pub(super) tried: Vec<(String, f64)>,
    /// Effects of which no regressor adds anything to what is given.
    pub(super) silent: Vec<Rc<Effect>>,
}

/// The search.
#[derive(Debug)]
pub(super) struct SlowSearch<'a> {
    /// Equally long stretches of the log; those with too little data are left out.
    pub(super) blocks: &'a Blocks,
    /// Block means of the target's error.
    pub(super) y: &'a [f64],
    /// Regressors that are in every model: the constant, what the model already has.
    pub(super) given: &'a [Vec<f64>],
    /// Makes the hypotheses.
    pub(super) hypotheses: &'a Hypotheses<'a>,
    /// The effects to try.
    pub(super) effects: &'a [Rc<Effect>],
    /// What is known of the noise levels.
    pub(super) prior: LevelPrior,
    /// The same where a random walk larger than the baseline's is tried.
    pub(super) free_walk_prior: LevelPrior,
}

/// What became of the effects that were tried alone.
#[derive(Debug, Clone, Default)]
struct Tried {
    scores: Vec<(String, f64)>,
    silent: Vec<Rc<Effect>>,
}

/// A model under construction.
#[derive(Debug, Clone)]
struct State {
    accepted: Vec<Hypothesis>,
    noise: ExtraNoise,
    fitted: Fitted,
}

/// A hypothesis on top of a state.
#[derive(Debug, Clone)]
struct Candidate {
    hypothesis: Hypothesis,
    fitted: Fitted,
    gain: f64,
    score: f64,
}

impl SlowSearch<'_> {
    /// Searches.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub(super) fn run(&self) -> Result<SlowResult, RecordingError> {
        let base = NoiseLevels::from_logs(&self.prior.mean);
        let mut state = State {
            accepted: Vec::new(),
            noise: ExtraNoise::None,
            fitted: self.fit(&[], ExtraNoise::None, base),
        };
        let mut tried = Tried::default();
        // ends after MAX_FOUND: an effect is accepted for what it gains, but `exchange` and `drop_unneeded_noise` fit anew and may
        // lose some of it
        for round in 0..MAX_FOUND {
            fos_data::interrupt::check();
            let first_pass = self.first_pass(&state)?;
            let candidates = self.fitted(&state, &first_pass)?;
            if round == 0 {
                tried = self.tried(&first_pass, &candidates);
            }
            let noise = self.best_noise(&state);
            let best = candidates.into_iter().next();
            let best_score = best.as_ref().map_or(f64::NEG_INFINITY, |candidate| candidate.score);
            match (best, noise) {
                (_, Some((noise, fitted, score))) if score >= ACCEPT && score > best_score => {
                    state = State { noise, fitted, ..state };
                }
                (Some(best), _) if best.score >= ACCEPT => {
                    state.accepted.push(best.hypothesis);
                    state.fitted = best.fitted;
                    self.drop_unneeded_noise(&mut state);
                    self.exchange(&mut state)?;
                }
                _ => break,
            }
        }
        self.drop_unsupported(&mut state);
        self.describe(state, tried)
    }

    /// Estimates these effects together, whether they are missing or not.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub(super) fn estimate(&self, wanted: &[Rc<Effect>]) -> Result<SlowResult, RecordingError> {
        let base = NoiseLevels::from_logs(&self.prior.mean);
        let mut state = State {
            accepted: Vec::new(),
            noise: ExtraNoise::None,
            fitted: self.fit(&[], ExtraNoise::None, base),
        };
        for effect in wanted {
            let alone = SlowSearch { effects: std::slice::from_ref(effect), ..*self };
            if let Some(best) = alone.candidates(&state)?.into_iter().next() {
                state.accepted.push(best.hypothesis);
                state.fitted = best.fitted;
            }
        }
        // the first was estimated before the others were there
        let again = if wanted.len() > 1 { state.accepted.len() } else { 0 };
        for place in 0..again {
            let (without, current) = self.without(&state, place);
            let rest: Vec<&Hypothesis> = without.accepted.iter().collect();
            let again = self.candidate(&rest, &without, current)?;
            state.accepted[place] = again.hypothesis;
            let all: Vec<&Hypothesis> = state.accepted.iter().collect();
            state.fitted = self.fit(&all, state.noise, again.fitted.levels);
        }
        self.describe(state, Tried::default())
    }

    fn prior_of(&self, noise: ExtraNoise) -> LevelPrior {
        match noise {
            ExtraNoise::Walk => self.free_walk_prior,
            _ => self.prior,
        }
    }

    /// Fits coefficients and noise levels with these hypotheses.
    fn fit(&self, accepted: &[&Hypothesis], noise: ExtraNoise, start: NoiseLevels) -> Fitted {
        let mut regressors: Vec<&[f64]> = self.given.iter().map(Vec::as_slice).collect();
        for hypothesis in accepted {
            regressors.extend(hypothesis.columns());
        }
        let prior = self.prior_of(noise);
        let regression =
            Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: &prior };
        match noise {
            ExtraNoise::GaussMarkov(process) => {
                regression.fit_gauss_markov(NoiseLevels { gauss_markov: None, ..start }, process)
            }
            _ => regression.fit(NoiseLevels { gauss_markov: None, ..start }),
        }
    }

    /// Coefficients only, under given levels.
    fn at(&self, accepted: &[&Hypothesis], noise: ExtraNoise, levels: NoiseLevels) -> Fitted {
        let mut regressors: Vec<&[f64]> = self.given.iter().map(Vec::as_slice).collect();
        for hypothesis in accepted {
            regressors.extend(hypothesis.columns());
        }
        let prior = self.prior_of(noise);
        Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: &prior }.at(levels)
    }

    /// What `k` coefficients and the search for a parameter cost.
    fn price(&self, k: usize, hypothesis: &Hypothesis) -> f64 {
        let grid = self.hypotheses.grid(&hypothesis.effect).len() as f64;
        let parameter = if hypothesis.value.is_some() { PARAMETER_PRICE } else { 0.0 };
        let clock = if hypothesis.effect.follows_clock_alone() { CLOCK_PRICE } else { 0.0 };
        k as f64 * (self.blocks.len() as f64).ln() + 2.0 * grid.ln() + parameter + clock
    }

    /// Every effect at the best value of its parameter on top of `state`, those of them fitted that explain most; best score
    /// first.
    fn candidates(&self, state: &State) -> Result<Vec<Candidate>, RecordingError> {
        self.fitted(state, &self.first_pass(state)?)
    }

    /// The best of a first pass, their parameters refined and the levels fitted under each; best score first.
    fn fitted(
        &self,
        state: &State,
        first_pass: &[(f64, Hypothesis)],
    ) -> Result<Vec<Candidate>, RecordingError> {
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let best = first_pass.iter().take(FITTED);
        let mut candidates = best
            .map(|(_, hypothesis)| self.candidate(&accepted, state, hypothesis.clone()))
            .collect::<Result<Vec<_>, _>>()?;
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        Ok(candidates)
    }

    /// What became of every effect that was tried alone: those fitted with the score of the fit, the others with that of the
    /// first pass, which left them behind.
    fn tried(&self, first_pass: &[(f64, Hypothesis)], candidates: &[Candidate]) -> Tried {
        let id = |hypothesis: &Hypothesis| hypothesis.effect.id.clone();
        let fitted = candidates.iter().map(|candidate| (id(&candidate.hypothesis), candidate.score));
        let behind = first_pass.iter().skip(FITTED).map(|(score, hypothesis)| (id(hypothesis), *score));
        let scores: Vec<(String, f64)> = fitted.chain(behind).collect();
        let is_silent = |effect: &&Rc<Effect>| scores.iter().all(|(id, _)| *id != effect.id);
        Tried { silent: self.effects.iter().filter(is_silent).cloned().collect(), scores }
    }

    /// Every effect at the best value of its parameter on top of `state`, under given levels; best score first. Effects of which
    /// no regressor adds anything are left out.
    fn first_pass(&self, state: &State) -> Result<Vec<(f64, Hypothesis)>, RecordingError> {
        // at the prior's levels: those of the null have swollen to hold what is missing
        let mut levels = NoiseLevels::from_logs(&self.prior.mean);
        if state.noise != ExtraNoise::None {
            levels = state.fitted.levels;
        }
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let null = self.at(&accepted, state.noise, levels);
        let mut first_pass = Vec::new();
        for effect in self.effects {
            if state.accepted.iter().any(|hypothesis| hypothesis.effect.id == effect.id)
                && effect.search != Search::Step
            {
                continue;
            }
            let mut best: Option<(f64, Hypothesis)> = None;
            for value in self.hypotheses.grid(effect) {
                let hypothesis = self.hypotheses.make(effect, value)?;
                let (gain, k) = null.gls.gain(self.blocks, &hypothesis.columns());
                if k == 0 {
                    continue;
                }
                let score = gain - self.price(k, &hypothesis);
                if best.as_ref().is_none_or(|(other, _)| score > *other) {
                    best = Some((score, hypothesis));
                }
            }
            first_pass.extend(best);
        }
        first_pass.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(first_pass)
    }

    /// A hypothesis on top of `accepted`, its parameter refined and the levels fitted.
    fn candidate(
        &self,
        accepted: &[&Hypothesis],
        state: &State,
        hypothesis: Hypothesis,
    ) -> Result<Candidate, RecordingError> {
        let with = |hypothesis: &Hypothesis, start| {
            let all: Vec<&Hypothesis> = accepted.iter().copied().chain([hypothesis]).collect();
            self.fit(&all, state.noise, start)
        };
        let first = with(&hypothesis, state.fitted.levels);
        let refined = self.refine(accepted, state.noise, &first, hypothesis)?;
        let refined = self.worth_their_price(accepted, state.noise, &first, refined);
        let fitted = with(&refined, first.levels);
        let k = fitted.gls.kept.len().saturating_sub(state.fitted.gls.kept.len());
        let gain = state.fitted.deviance - fitted.deviance;
        let score = gain - self.price(k.max(1), &refined);
        Ok(Candidate { hypothesis: refined, fitted, gain, score })
    }

    /// Looks for the best value of the parameter between the neighbours on the grid, the levels held: parabolas through
    /// the best three.
    fn refine(
        &self,
        accepted: &[&Hypothesis],
        noise: ExtraNoise,
        fitted: &Fitted,
        start: Hypothesis,
    ) -> Result<Hypothesis, RecordingError> {
        let Some(value) = start.value else { return Ok(start) };
        if start.effect.search == Search::Step {
            return self.refine_step(accepted, noise, fitted, start, value);
        }
        let evaluate = |log: f64| -> Result<(f64, f64, Hypothesis), RecordingError> {
            let hypothesis = self.hypotheses.make(&start.effect, Some(log.exp()))?;
            let all: Vec<&Hypothesis> = accepted.iter().copied().chain([&hypothesis]).collect();
            Ok((log, self.at(&all, noise, fitted.levels).deviance, hypothesis))
        };
        let middle = value.ln();
        let width = self.grid_width(&start.effect);
        let limited = |log: f64| match &start.effect.parameter {
            Some(parameter) => log.clamp(parameter.low.ln(), parameter.high.ln()),
            None => log,
        };
        let mut points = vec![evaluate(middle)?];
        for neighbour in [limited(middle - width), limited(middle + width)] {
            if (neighbour - middle).abs() > 1e-3 {
                points.push(evaluate(neighbour)?);
            }
        }
        for _ in 0..REFINEMENTS {
            points.sort_by(|a, b| a.1.total_cmp(&b.1));
            points.truncate(3);
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if points.len() < 3 {
                // at a limit of the search: half way to the neighbour makes it three
                points.push(evaluate(0.5 * (points[0].0 + points[points.len() - 1].0))?);
                continue;
            }
            let next = vertex(&points.iter().map(|p| (p.0, p.1)).collect::<Vec<_>>());
            let (low, high) = match &start.effect.parameter {
                Some(parameter) => (parameter.low.ln(), parameter.high.ln()),
                None => (middle - width, middle + width),
            };
            let Some(next) = next.map(|next| next.clamp(low, high)) else { break };
            if points.iter().any(|point| (point.0 - next).abs() < 1e-3) {
                break;
            }
            points.push(evaluate(next)?);
        }
        points.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(points.swap_remove(0).2)
    }

    /// Looks for the moment of a step inside the blocks on both sides of it.
    fn refine_step(
        &self,
        accepted: &[&Hypothesis],
        noise: ExtraNoise,
        fitted: &Fitted,
        start: Hypothesis,
        time_s: f64,
    ) -> Result<Hypothesis, RecordingError> {
        let mut best = (f64::INFINITY, start);
        for part in -STEP_PARTS..=STEP_PARTS {
            let at = time_s + f64::from(part) / f64::from(STEP_PARTS) * self.blocks.length_s;
            let hypothesis = self.hypotheses.make(&best.1.effect, Some(at))?;
            let all: Vec<&Hypothesis> = accepted.iter().copied().chain([&hypothesis]).collect();
            let deviance = self.at(&all, noise, fitted.levels).deviance;
            if deviance < best.0 {
                best = (deviance, hypothesis);
            }
        }
        Ok(best.1)
    }

    fn grid_width(&self, effect: &Effect) -> f64 {
        let grid = self.hypotheses.grid(effect);
        match grid[..] {
            [Some(first), Some(second), ..] => (second / first).ln(),
            _ => 0.0,
        }
    }

    /// The better of the two kinds of further noise on top of `state`, with its score.
    fn best_noise(&self, state: &State) -> Option<(ExtraNoise, Fitted, f64)> {
        if state.noise != ExtraNoise::None {
            return None;
        }
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let price = (self.blocks.len() as f64).ln();
        let start = state.fitted.levels;
        let walk = self.fit(&accepted, ExtraNoise::Walk, NoiseLevels { walk: 3.0 * start.walk, ..start });
        let walk_score = state.fitted.deviance - walk.deviance - price;
        let deviation = (fos_fit::signal::variance(&[&state.fitted.gls.residual]).sqrt() * start.flicker)
            .max(start.flicker);
        let longest = self.blocks.len() as f64 * self.blocks.length_s / 5.0;
        let processes = GAUSS_MARKOV_STARTS_S
            .into_iter()
            .filter(|tau_s| (2.0 * self.blocks.length_s..longest).contains(tau_s))
            .map(|tau_s| {
                let process = GaussMarkov { deviation, tau_s };
                self.fit(
                    &accepted,
                    ExtraNoise::GaussMarkov(process),
                    NoiseLevels::from_logs(&self.prior.mean),
                )
            });
        let process = processes.min_by(|a, b| a.deviance.total_cmp(&b.deviance));
        let process = process.and_then(|fitted| {
            // a shorter one is white noise in block means, and of that there is a level already
            let is_slow = |process: &GaussMarkov| (self.blocks.length_s..longest).contains(&process.tau_s);
            let process = fitted.levels.gauss_markov.filter(is_slow)?;
            let score = state.fitted.deviance - fitted.deviance - 2.0 * price;
            Some((ExtraNoise::GaussMarkov(process), fitted, score))
        });
        let walk = (ExtraNoise::Walk, walk, walk_score);
        match process {
            Some(process) if process.2 > walk.2 => Some(process),
            _ => Some(walk),
        }
    }

    /// The regressors of an effect that are worth their price, under given levels: coefficients that the log cannot tell
    /// apart would go wrong in the next one. Of choices as good, the one listed first.
    fn worth_their_price(
        &self,
        accepted: &[&Hypothesis],
        noise: ExtraNoise,
        fitted: &Fitted,
        hypothesis: Hypothesis,
    ) -> Hypothesis {
        let n = hypothesis.columns.len();
        if !hypothesis.effect.any_terms || !(2..=MOST_TERMS).contains(&n) {
            return hypothesis;
        }
        let price = (self.blocks.len() as f64).ln();
        // a part of a sum comes on top of it: of shaking in one direction any axis tells, of the next direction the sum does
        let is_sum = |term: usize| {
            hypothesis.regressors.get(term).is_some_and(|regressor| regressor.products.len() > 1)
        };
        let has_sums = (0..n).any(is_sum);
        if has_sums {
            let of = |hypothesis: Option<&Hypothesis>| {
                let all: Vec<&Hypothesis> = accepted.iter().copied().chain(hypothesis).collect();
                self.at(&all, noise, fitted.levels).deviance
            };
            let (none, all, first) = (of(None), of(Some(&hypothesis)), hypothesis.of_terms(&[0]));
            if none - of(Some(&first)) > NEARLY_ALL * (none - all) {
                return first;
            }
        }
        let mut choices: Vec<(f64, Hypothesis)> = (1_u32..1 << n)
            .map(|choice| (0..n).filter(|term| choice >> term & 1 == 1).collect::<Vec<usize>>())
            .filter(|terms| !has_sums || is_sum(terms[0]))
            .map(|terms| {
                let chosen = hypothesis.of_terms(&terms);
                let all: Vec<&Hypothesis> = accepted.iter().copied().chain([&chosen]).collect();
                (self.at(&all, noise, fitted.levels).deviance + price * terms.len() as f64, chosen)
            })
            .collect();
        let best = choices.iter().map(|(deviance, _)| *deviance).fold(f64::INFINITY, f64::min);
        choices.retain(|(deviance, _)| *deviance < best + AS_GOOD);
        choices.sort_by(|a, b| a.1.terms.len().cmp(&b.1.terms.len()).then_with(|| a.1.terms.cmp(&b.1.terms)));
        choices.swap_remove(0).1
    }

    /// Further noise that an effect has made unnecessary goes.
    fn drop_unneeded_noise(&self, state: &mut State) {
        if state.noise == ExtraNoise::None {
            return;
        }
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let without = self.fit(&accepted, ExtraNoise::None, NoiseLevels::from_logs(&self.prior.mean));
        let price = (self.blocks.len() as f64).ln();
        if without.deviance - state.fitted.deviance < price + ACCEPT {
            *state = State { noise: ExtraNoise::None, fitted: without, accepted: state.accepted.clone() };
        }
    }

    /// The state without the effect at `place`, and that effect.
    fn without(&self, state: &State, place: usize) -> (State, Hypothesis) {
        let mut accepted = state.accepted.clone();
        let removed = accepted.remove(place);
        let rest: Vec<&Hypothesis> = accepted.iter().collect();
        let fitted = self.fit(&rest, state.noise, state.fitted.levels);
        (State { accepted, noise: state.noise, fitted }, removed)
    }

    /// Each effect gives way to another that explains more in its place, until none does: the first that was found was
    /// found before the others were known.
    fn exchange(&self, state: &mut State) -> Result<(), RecordingError> {
        if state.accepted.len() < 2 {
            return Ok(());
        }
        for place in 0..state.accepted.len() {
            let (without, current) = self.without(state, place);
            let rest: Vec<&Hypothesis> = without.accepted.iter().collect();
            let own = self.candidate(&rest, &without, current.clone())?;
            let better = self.candidates(&without)?.into_iter().next();
            let winner = match better {
                Some(better) if better.score > own.score + 0.5 => better,
                _ => own,
            };
            state.accepted[place] = winner.hypothesis;
            state.fitted = winner.fitted;
        }
        Ok(())
    }

    /// Effects that lost their support to later ones go.
    fn drop_unsupported(&self, state: &mut State) {
        let mut place = 0;
        // ends: one is passed, or one fewer is left
        while place < state.accepted.len() {
            let (without, current) = self.without(state, place);
            let k = state.fitted.gls.kept.len().saturating_sub(without.fitted.gls.kept.len()).max(1);
            if without.fitted.deviance - state.fitted.deviance - self.price(k, &current) < ACCEPT {
                *state = without;
            } else {
                place += 1;
            }
        }
    }
}

/// Terms of which every choice is tried.
const MOST_TERMS: usize = 6;

/// Choices of terms within this much of the best, in −2 ln L after their price, are as good: odds of 4 to 1.
const AS_GOOD: f64 = 3.0;

/// The first sum stands for the effect if it explains this share of what all terms explain.
const NEARLY_ALL: f64 = 0.9;

/// Parts of a block in which the moment of a step is looked for.
const STEP_PARTS: i32 = 5;

/// Parabolas through the best three values of a parameter.
const REFINEMENTS: usize = 4;

/// Correlation times that a further Gauss-Markov process is looked for from, s.
const GAUSS_MARKOV_STARTS_S: [f64; 4] = [5.0, 20.0, 80.0, 250.0];

/// Where the parabola through three points is least; the better end if it is bent the other way.
fn vertex(points: &[(f64, f64)]) -> Option<f64> {
    let [(x0, y0), (x1, y1), (x2, y2)] = *points else { return None };
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (right - left) / (x2 - x0);
    if bend > 0.0 {
        Some(0.5 * (x0 + x1) - left / (2.0 * bend))
    } else {
        Some(if y0 < y2 { x0 - (x1 - x0) } else { x2 + (x2 - x1) })
    }
}
