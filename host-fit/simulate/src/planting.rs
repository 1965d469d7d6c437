//! Scales planted effects to their sizes, and counts faults.

use std::collections::BTreeMap;
use std::slice;

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use serde::Serialize;

use super::coloured::AxisNoise;
use super::draft::{Draft, draft};
use super::effect::{Band, Effect, Outside};
use super::plan::{CasePlan, PlanError};
use super::random::{Random, Stream, between, chance, random};
use super::recorder::Faults;
use super::regressors::NamedSeries;
use super::rivals::{Best, CELL, Rivals};
use super::shape::Shape;
use super::strength::{Blocks, Whitener, level_size, noise_amplitude, solve, telegraph_amplitude};
use super::world::World;

/// A planted effect with its resulting values.
#[derive(Debug, Clone, Serialize)]
pub struct Planted {
    pub effect: Effect,
    /// In means, in single samples, in the data themselves, or as noise.
    pub band: Band,
    pub outside: bool,
    /// Parameter by name.
    pub params: BTreeMap<&'static str, f64>,
    /// Controlling covariate of a threshold or a noise level.
    pub follows: Option<&'static str>,
    /// Coefficients of its regressors, unit of the target over that of the regressor.
    pub coefficients: Vec<f64>,
    pub size: f64,
    /// Remaining size after the best other slow effect of the library; slow effects only.
    pub left_after_best_rival: Option<f64>,
    /// Best other slow effect, with its parameter.
    pub rival: Option<(Effect, f64)>,
    /// Remaining size after the other planted slow effect, and after it and the best rival; only if there are two.
    pub left_after_partner: Option<[f64; 2]>,
}

/// Sizes of the effects of a plan, and their remaining sizes after fitting others; without simulating a log.
pub fn assess(plan: &CasePlan) -> Result<Vec<Planted>, PlanError> {
    let Draft { unit, logged, field, shapes, .. } = draft(plan)?;
    let columns = shapes.iter().map(|shape| shape.columns(&field, 1, plan.seed)).collect();
    let noise = &unit.noise[plan.target as usize];
    size(plan, &shapes, &columns, &field, &logged.names(), (noise, unit.part.lsb(plan.target)))
}

/// Scales every effect to the size of the plan.
pub(super) fn size(
    plan: &CasePlan,
    shapes: &[Shape],
    columns: &Vec<Vec<NamedSeries>>,
    field: &World,
    logged: &[&str],
    (noise, lsb): (&AxisNoise, f64),
) -> Result<Vec<Planted>, PlanError> {
    if shapes.is_empty() {
        return Ok(Vec::new());
    }
    let blocks = Blocks::of(&field.usable(plan.target), CELL);
    let covariance = blocks.covariance(noise, lsb);
    let nothing = |shape: &Shape| PlanError::Nothing { effect: shape.effect, parameter: shape.parameter };
    let whitener = Whitener::new(covariance.clone()).ok_or_else(|| nothing(&shapes[0]))?;
    let mut planted = Vec::new();
    let mut whitened: Vec<Option<DVector<f64>>> = Vec::new();
    for ((plant, shape), columns) in plan.planted.iter().zip(shapes).zip(columns) {
        let unit = sum(slice::from_ref(&shape.weights), slice::from_ref(columns), field.len());
        let white = whitener.whiten(&blocks.means(&unit));
        let is_slow = measure(shape.effect) == Measure::Matched;
        let amplitude = match measure(shape.effect) {
            Measure::Matched => plant.size / white.norm(),
            Measure::Telegraph => {
                let code = transitions_code(&unit, blocks.0.len());
                let mut g = DMatrix::zeros(covariance.nrows(), covariance.nrows());
                // each of two levels left at 1/τ: the autocorrelation falls with τ/2
                blocks.add_gauss_markov(&mut g, 1.0, 0.5 * shape.parameter, noise.period_s);
                let course = DVector::from_vec(blocks.means(&unit));
                telegraph_amplitude(&covariance, &g, (&course, code), plant.size)
                    .ok_or_else(|| nothing(shape))?
            }
            Measure::Line => {
                let density = noise.density(shape.parameter, lsb);
                let energy: f64 = blocks.0.iter().flat_map(|rows| &unit[rows.clone()]).map(|x| x * x).sum();
                plant.size / (energy / density).sqrt()
            }
            Measure::Likelihood => {
                let n = covariance.nrows();
                let mut g = DMatrix::zeros(n, n);
                if shape.effect == Effect::RateRandomWalk {
                    blocks.add_random_walk(&mut g, 1.0, noise.period_s);
                } else {
                    blocks.add_gauss_markov(&mut g, 1.0, shape.parameter, noise.period_s);
                }
                noise_amplitude(&covariance, &g, plant.size).ok_or_else(|| nothing(shape))?
            }
            Measure::Level => {
                let squares = level_squares(shape, field);
                let variance = noise.fast_density(0.0, lsb).min(noise.white * noise.white);
                solve(noise.white, plant.size, |a| {
                    level_size(squares.iter().map(|square| a * a * square / variance))
                })
            }
            // its error is in the data: `add_faults`
            Measure::Data => 0.0,
        };
        if !amplitude.is_finite() {
            return Err(nothing(shape));
        }
        let description = shape.effect.description();
        planted.push(Planted {
            effect: shape.effect,
            band: description.band,
            outside: shape.effect.is_outside(),
            params: description.parameter.iter().map(|(name, _)| (*name, shape.parameter)).collect(),
            follows: shape.source_name(),
            coefficients: shape.weights.iter().map(|weight| amplitude * weight).collect(),
            size: plant.size,
            left_after_best_rival: None,
            rival: None,
            left_after_partner: None,
        });
        whitened.push(is_slow.then(|| white * amplitude));
    }
    if whitened.iter().any(Option::is_some) {
        let rivals = Rivals::new((plan.setup, plan.target), logged, field, (&blocks, &whitener));
        score(&mut planted, &whitened, &rivals);
    }
    Ok(planted)
}

/// Computes the remaining sizes after rivals and partners.
fn score(planted: &mut [Planted], whitened: &[Option<DVector<f64>>], rivals: &Rivals) {
    for k in 0..planted.len() {
        let Some(white) = &whitened[k] else { continue };
        let effect = planted[k].effect;
        if let Some(Best { effect: rival, parameter, left }) = rivals.best(effect, white, &[]) {
            planted[k].left_after_best_rival = Some(left);
            planted[k].rival = Some((rival, parameter));
        }
        let partners: Vec<(Effect, DVector<f64>)> = (0..planted.len())
            .filter(|other| *other != k)
            .filter_map(|other| Some((planted[other].effect, whitened[other].clone()?)))
            .collect();
        if !partners.is_empty() {
            let errors: Vec<DVector<f64>> = partners.iter().map(|(_, error)| error.clone()).collect();
            let alone = Whitener::left(white, &errors);
            let rival = rivals.best(effect, white, &partners).map_or(alone, |best| best.left);
            planted[k].left_after_partner = Some([alone, rival]);
        }
    }
}

/// Definition of the size of an effect; see strength.rs.
#[derive(Clone, Copy, PartialEq)]
enum Measure {
    Matched,
    Telegraph,
    Line,
    Likelihood,
    Level,
    Data,
}

fn measure(effect: Effect) -> Measure {
    match effect {
        Effect::SpectralLine | Effect::DriftingLine | Effect::Outside(Outside::Bursts) => Measure::Line,
        Effect::GaussMarkov | Effect::RateRandomWalk => Measure::Likelihood,
        Effect::RandomTelegraph => Measure::Telegraph,
        Effect::NoiseTemperature | Effect::Outside(Outside::NoiseLevel) => Measure::Level,
        Effect::Saturation | Effect::DroppedSamples | Effect::Quantisation | Effect::DeadZone => {
            Measure::Data
        }
        _ => Measure::Matched,
    }
}

/// −2 ln P of the transitions of a course of two levels, in blocks: their unpredictable part.
fn transitions_code(course: &[f64], blocks: usize) -> f64 {
    let transitions = course.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let share = (transitions as f64 / blocks as f64).clamp(1e-3, 0.5);
    -2.0 * blocks as f64 * (share * share.ln() + (1.0 - share) * (1.0 - share).ln())
}

/// Variance of the added white noise of amplitude one in every sample.
fn level_squares(shape: &Shape, field: &World) -> Vec<f64> {
    let source =
        if shape.effect == Effect::NoiseTemperature { shape.temp(field) } else { shape.source(field) };
    source.into_iter().map(|x| (0.5 * (x + 1.0)).clamp(0.0, 1.5).powi(2)).collect()
}

/// Weighted sum of all columns.
pub(super) fn sum(weights: &[Vec<f64>], columns: &[Vec<NamedSeries>], n: usize) -> Vec<f64> {
    let mut error = vec![0.0; n];
    for (weights, columns) in weights.iter().zip(columns) {
        for (weight, (_, column)) in weights.iter().zip(columns) {
            for (error, x) in error.iter_mut().zip(column) {
                *error += weight * x;
            }
        }
    }
    error
}

/// Sets limit, step and lost samples by the log to explain; the evaluation log uses the same limit, step and fraction.
pub(super) fn add_faults(
    faults: &mut Faults,
    plan: &CasePlan,
    planted: &mut [Planted],
    (analog, noise): (&[f64], &AxisNoise),
    (lsb, bias, seed, is_field): (f64, f64, u64, bool),
) {
    for (number, (plant, planted)) in plan.planted.iter().zip(planted).enumerate() {
        let n = analog.len() as f64;
        let count = plant
            .parameter
            .map_or(plant.size * plant.size, |fraction| fraction * n)
            .round()
            .clamp(1.0, 0.4 * n);
        match plant.effect {
            Effect::Saturation if is_field => {
                let mut sizes: Vec<f64> = analog.iter().map(|x| x.abs()).collect();
                sizes.sort_unstable_by(f64::total_cmp);
                faults.limit = Some(sizes[sizes.len() - 1 - count as usize]);
                planted.size = count.sqrt();
                planted.params.insert("frac", count / n);
            }
            Effect::DroppedSamples => {
                let count = if is_field { count } else { (planted.params["frac"] * n).round() };
                faults.lost = lost(
                    analog.len(),
                    count as usize,
                    &mut random(seed, Stream::Course(u64::from(is_field), number as u64)),
                );
                if is_field {
                    planted.size = count.sqrt();
                    planted.params.insert("frac", count / n);
                }
            }
            Effect::DeadZone if is_field => {
                let mut off: Vec<f64> = analog.iter().map(|value| (value - bias).abs()).collect();
                off.sort_unstable_by(f64::total_cmp);
                let of_size = (plant.size * plant.size).min(n - 1.0) as usize;
                let half_width = plant.parameter.map_or(off[of_size], f64::to_radians);
                faults.dead_zone = Some([bias, half_width]);
                planted.size = (off.partition_point(|off| *off < half_width) as f64).sqrt();
                planted.params.insert("half_width_dps", half_width.to_degrees());
            }
            Effect::Quantisation if is_field => {
                let variance = noise.white * noise.white;
                let size = |mult: f64| {
                    let ratio = (mult * mult - 1.0).max(0.0) * lsb * lsb / 12.0 / variance;
                    n.sqrt() * level_size(std::iter::once(ratio))
                };
                let wanted = plant.parameter.unwrap_or_else(|| solve(8.0, plant.size, size));
                // a converter that loses bits: whole multiples
                let mult = wanted.round().clamp(2.0, 64.0);
                faults.step = Some(mult);
                planted.size = size(mult);
                planted.params.insert("mult", mult);
            }
            _ => {}
        }
    }
}

/// `count` samples to lose, singly and in bursts of up to 50; never the first or the last.
fn lost(n: usize, count: usize, random: &mut Random) -> Vec<usize> {
    let mut gone = vec![false; n];
    let mut left = count;
    // terminates: `count` is a small share of `n`, so that some start eventually adds another
    while left > 0 {
        let length = if chance(random, 0.6) { 1 } else { between(random, 2.0, 50.0) as usize };
        let start = random.random_range(1..n - 1);
        for flag in gone.iter_mut().take(n - 1).skip(start).take(length) {
            if left > 0 && !*flag {
                *flag = true;
                left -= 1;
            }
        }
    }
    (0..n).filter(|k| gone[*k]).collect()
}
