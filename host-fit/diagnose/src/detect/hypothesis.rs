//! Hypotheses on the missing effect: an effect with a value of its parameter and its regressors in block means.

use std::sync::Arc;

use crate::effects::{Detector, Effect, Inputs, Regressor};
use crate::memo::Memo;
use fos_core::Transform;
use fos_data::recording::RecordingError;
use fos_fit::noise::Blocks;
use fos_fit::signal::centred;

/// Approximate ratio of neighbouring values on the grid of a parameter, fine enough for the later refinement to find
/// any optimum in between.
const GRID_RATIO: f64 = 1.5;

/// An effect with a value of its parameter.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis {
    /// Effect of the library, built-in or a user's own.
    pub(super) effect: Arc<Effect>,
    /// Value of the parameter, if the effect has one.
    pub(super) value: Option<f64>,
    /// Regressors in block means, each about its mean.
    pub(super) columns: Arc<Vec<Vec<f64>>>,
    /// Index of the term of each column; terms that explain nothing are excluded.
    pub(super) terms: Vec<usize>,
    /// Regressors, one per column; none for a step.
    pub(super) regressors: Vec<Regressor>,
}

impl Hypothesis {
    pub(super) fn columns(&self) -> Vec<&[f64]> {
        self.columns.iter().map(Vec::as_slice).collect()
    }

    /// Returns the hypothesis with some of its regressors.
    pub(super) fn with_terms(&self, places: &[usize]) -> Self {
        let columns = places.iter().map(|place| self.columns[*place].clone()).collect();
        let terms = places.iter().map(|place| self.terms[*place]).collect();
        let regressors = places.iter().filter_map(|place| self.regressors.get(*place).cloned()).collect();
        Self { columns: Arc::new(columns), terms, regressors, ..self.clone() }
    }

    /// Returns the hypothesis with only the terms that `other`, a hypothesis of the same effect, has.
    pub(super) fn with_terms_of(&self, other: &Self) -> Self {
        let places: Vec<usize> =
            (0..self.terms.len()).filter(|place| other.terms.contains(&self.terms[*place])).collect();
        if places.len() == self.terms.len() { self.clone() } else { self.with_terms(&places) }
    }

    /// Returns true if `other` is of the same effect, for any parameter value.
    pub(super) fn is_same_effect(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id
    }
}

/// Makes and caches the hypotheses for one target and one recording.
#[derive(Debug)]
pub(super) struct Hypotheses<'a> {
    inputs: Inputs<'a>,
    blocks: Arc<Blocks>,
    target: String,
    made: Memo<(String, u64), Hypothesis>,
    means: Memo<String, Arc<[f64]>>,
}

impl<'a> Hypotheses<'a> {
    /// Makes hypotheses for the axis of column `target`.
    pub(super) fn new(inputs: Inputs<'a>, blocks: &Arc<Blocks>, target: &str) -> Self {
        let (blocks, target) = (Arc::clone(blocks), target.to_owned());
        Self { inputs, blocks, target, made: Memo::default(), means: Memo::default() }
    }

    /// Returns the inputs that the regressors are computed from, and with them the log.
    pub(super) fn inputs(&self) -> &Inputs<'a> {
        &self.inputs
    }

    /// Returns the first values to try for the parameter; one `None` for an effect without a parameter.
    pub(super) fn grid(&self, effect: &Effect) -> Vec<Option<f64>> {
        match (&effect.parameter, effect.search) {
            // a step lies after the first and before the last ten blocks: further out it is indistinguishable from the
            // constant
            (_, Detector::Step) => {
                let last = self.blocks.len().saturating_sub(STEP_MARGIN);
                let blocks = (STEP_MARGIN..last).step_by(self.blocks_a_place());
                blocks.map(|block| Some(self.step_time(block))).collect()
            }
            (Some(parameter), Detector::Terms) => {
                let steps = ((parameter.high / parameter.low).ln() / GRID_RATIO.ln()).ceil().max(1.0);
                let ratio = (parameter.high / parameter.low).powf(1.0 / steps);
                // a time constant far below a block affects only the first block, or is no lag at all
                let least = if parameter.unit == "s" { SHORTEST_BLOCKS * self.blocks.length_s } else { 0.0 };
                let values = (0..=steps as i32).map(|i| parameter.low * ratio.powi(i));
                let mut values: Vec<f64> = values.filter(|value| *value >= least).collect();
                if values.is_empty() {
                    values.push(parameter.high);
                }
                values.into_iter().map(Some).collect()
            }
            _ => vec![None],
        }
    }

    /// Returns the number of blocks between the positions at which a step is tried.
    pub(super) fn blocks_a_place(&self) -> usize {
        self.blocks.len().div_ceil(MAX_PLACES).max(1)
    }

    /// Returns a logged column in block means; `None` if it is not logged.
    pub(super) fn logged_means(&self, column: &str) -> Option<Arc<[f64]>> {
        if let Some(means) = self.means.get(column) {
            return Some(means);
        }
        let logged = self.inputs.logged(&Regressor::parse(column).ok()?)?;
        let means = self.inputs.block_means(&logged, &self.blocks).ok().filter(|means| !means.is_empty())?;
        Some(self.means.insert(column.to_owned(), means.into()))
    }

    /// Returns the time of a step just before `block`, s after the first sample.
    fn step_time(&self, block: usize) -> f64 {
        self.blocks.middle_s(block) - self.blocks.length_s / 2.0
    }

    /// Returns the hypothesis of `effect` at `value`, cached. An effect whose inputs never change has columns of zeros.
    pub(super) fn make(
        &self,
        effect: &Arc<Effect>,
        value: Option<f64>,
    ) -> Result<Hypothesis, RecordingError> {
        let key = (effect.id.clone(), value.map_or(0, f64::to_bits));
        if let Some(made) = self.made.get(&key) {
            return Ok(made);
        }
        let made = match effect.search {
            Detector::Step => self.step(effect, value),
            _ => self.of_regressors(effect, value)?,
        };
        Ok(self.made.insert(key, made))
    }

    fn step(&self, effect: &Arc<Effect>, value: Option<f64>) -> Hypothesis {
        let time_s = value.unwrap_or(0.0);
        let after = |block: usize| {
            ((self.blocks.middle_s(block) - time_s) / self.blocks.length_s + 0.5).clamp(0.0, 1.0)
        };
        let column = centred((0..self.blocks.len()).map(after).collect());
        let columns = Arc::new(vec![column]);
        Hypothesis { effect: effect.clone(), value, columns, terms: vec![0], regressors: Vec::new() }
    }

    /// Returns false for a backlash so wide that its output hardly moves.
    fn moves(&self, regressor: &Regressor) -> bool {
        regressor.inputs().all(|input| {
            let Transform::Backlash { half_width } = input.transform else { return true };
            let means = input.column.as_deref().and_then(|column| self.logged_means(column));
            means.is_none_or(|means| half_width <= WIDEST_PLAY * span(&means))
        })
    }

    fn of_regressors(&self, effect: &Arc<Effect>, value: Option<f64>) -> Result<Hypothesis, RecordingError> {
        let all = effect.regressors(&self.target, value).unwrap_or_default();
        let logged: Vec<(usize, Regressor)> = all
            .iter()
            .filter_map(|(term, regressor)| Some((*term, self.inputs.logged(regressor)?)))
            .collect();
        let first = logged.first().map(|(term, _)| *term);
        let logged: Vec<(usize, Regressor)> = logged
            .into_iter()
            .filter(|(term, regressor)| Some(*term) == first || self.moves(regressor))
            .collect();
        // with all regressors, the error states the missing column
        let used = if logged.is_empty() { all } else { logged };
        let (terms, regressors): (Vec<usize>, Vec<Regressor>) = used.into_iter().unzip();
        let columns: Vec<Vec<f64>> = regressors
            .iter()
            .map(|regressor| Ok(centred(self.inputs.block_means(regressor, &self.blocks)?)))
            .collect::<Result<_, RecordingError>>()?;
        Ok(Hypothesis { effect: effect.clone(), value, columns: Arc::new(columns), terms, regressors })
    }
}

/// Difference of the largest and the smallest value.
pub(super) fn span(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    high - low
}

/// Largest width of a backlash, as a share of the span of its input, in an effect with several terms. The output of a
/// wider one is hardly more than a constant, and hysteresis would then fit any drift.
const WIDEST_PLAY: f64 = 0.25;

/// Shortest time constant that is tried, in blocks.
const SHORTEST_BLOCKS: f64 = 0.5;

/// Largest number of positions of a step, and of oscillations, that are tried. A usual log has about half as many
/// blocks; for a log of many bursts with far more blocks it bounds the computing time.
pub(super) const MAX_PLACES: usize = 1200;

/// Least distance of a step from both ends, blocks.
const STEP_MARGIN: usize = 10;
