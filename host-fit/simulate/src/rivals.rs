//! Remaining part of a planted effect after the other slow effects of the library are fitted.

use nalgebra::DVector;

use super::axis::Axis;
use super::effect::{Band, Effect};
use super::regressors::{Anchor, NamedSeries, regressors};
use super::setup::Setup;
use super::strength::{Blocks, Whitener};
use super::world::World;

/// Samples in a cell of the covariates of rivals: 10 Hz of 200 Hz suffices for slow effects.
pub(super) const CELL: usize = 20;

/// Lags below this are no rival of temp_linear, s.
const SHORT_LAG_S: f64 = 40.0;

/// Rival that leaves the smallest remaining part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Best {
    pub(super) effect: Effect,
    pub(super) parameter: f64,
    pub(super) left: f64,
}

/// Every rival at every point of its grid, whitened.
pub(super) struct Rivals(Vec<(Effect, f64, Vec<DVector<f64>>)>);

impl Rivals {
    /// Rivals among the effects that this set-up can show and the log's columns reveal.
    pub(super) fn new(
        (setup, target): (Setup, Axis),
        logged: &[&str],
        field: &World,
        (blocks, whitener): (&Blocks, &Whitener),
    ) -> Self {
        let world = field.decimated(CELL);
        let blocks = blocks.decimated(CELL);
        let anchor = Anchor::of(field, target);
        let white = |columns: Vec<NamedSeries>| -> Vec<DVector<f64>> {
            columns.iter().map(|(_, column)| whitener.whiten(&blocks.means(column))).collect()
        };
        let mut all = Vec::new();
        for effect in Effect::LIBRARY {
            let description = effect.description();
            let shown = description.needs.iter().all(|column| logged.contains(column));
            if description.band != Band::Slow || !shown || !effect.suits(setup, target) {
                continue;
            }
            for parameter in grid(effect, world.duration_s()) {
                all.push((effect, parameter, white(regressors(effect, parameter, &world, target, &anchor))));
            }
        }
        Self(all)
    }

    /// Best rival of `effect`, whose whitened error is `error`, after `known` is projected out. More general effects
    /// that contain it do not count.
    pub(super) fn best(
        &self,
        effect: Effect,
        error: &DVector<f64>,
        known: &[(Effect, DVector<f64>)],
    ) -> Option<Best> {
        let ours = |rival: Effect| rival == effect || known.iter().any(|(effect, _)| *effect == rival);
        let left = |columns: &Vec<DVector<f64>>| {
            let others = known.iter().map(|(_, error)| error).chain(columns).cloned();
            Whitener::left(error, &others.collect::<Vec<_>>())
        };
        self.0
            .iter()
            .filter(|(rival, parameter, _)| !ours(*rival) && !contains((*rival, *parameter), effect))
            .map(|(effect, parameter, columns)| Best {
                effect: *effect,
                parameter: *parameter,
                left: left(columns),
            })
            .min_by(|a, b| a.left.total_cmp(&b.left))
    }
}

/// Returns true if `general`, with its parameter, can produce every error of `special`. A lag that is short compared
/// with ramps of minutes is temp_linear with a redundant parameter.
fn contains((general, parameter): (Effect, f64), special: Effect) -> bool {
    match (general, special) {
        (Effect::TempPoly, Effect::TempLinear) | (Effect::SfTemp, Effect::SfError) => true,
        (Effect::ThermalLag, Effect::TempLinear) => parameter < SHORT_LAG_S,
        _ => false,
    }
}

fn grid(effect: Effect, duration_s: f64) -> Vec<f64> {
    let logarithmic = |[low, high]: [f64; 2], n: usize| -> Vec<f64> {
        (0..n).map(|k| low * (high / low).powf(k as f64 / (n - 1) as f64)).collect()
    };
    match (effect, effect.description().parameter) {
        (Effect::BiasStep, _) => (1..25).map(|k| duration_s * f64::from(k) / 25.0).collect(),
        (_, Some((_, range))) => logarithmic(range, 8),
        (_, None) => vec![0.0],
    }
}
