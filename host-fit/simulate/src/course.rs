//! Error of a planted effect in one log: its regressors, or its course if it is random or outside the library.

use super::coloured::GaussMarkov;
use super::effect::{Effect, Outside};
use super::random::{EVALUATION, Random, Stream, between, chance, normal, random, sign};
use super::regressors::{NamedSeries, regressors};
use super::shape::Shape;
use super::world::World;

impl Shape {
    /// Columns of its error in a log: 1 the log to explain, 2 the evaluation log.
    pub(super) fn columns(&self, world: &World, log: u64, seed: u64) -> Vec<NamedSeries> {
        let found = regressors(self.effect, self.parameter, world, self.target, &self.anchor);
        if self.effect == Effect::BiasStep && log == EVALUATION {
            // the shock is over: its offset remains
            return found.into_iter().map(|(name, values)| (name, vec![1.0; values.len()])).collect();
        }
        if found.is_empty() {
            return course(self, world, &mut random(seed, Stream::Course(log, self.number)));
        }
        found
    }
}

/// Columns whose weighted sum is the error; of size one.
fn course(shape: &Shape, world: &World, random: &mut Random) -> Vec<NamedSeries> {
    let (n, dt) = (world.len(), world.period_s);
    let parameter = shape.parameter;
    let duration_s = n as f64 * dt;
    let one = |values: Vec<f64>| vec![("course".to_owned(), values)];
    let time = |k: usize| k as f64 * dt;
    match shape.effect {
        Effect::DriftingLine => drifting_line(n, dt, parameter, random),
        Effect::GaussMarkov => {
            let (decay, drive) = GaussMarkov { sigma: 1.0, tau_s: parameter }.step(dt);
            let start = normal(random);
            one(process(n, start, decay, drive, random))
        }
        Effect::RateRandomWalk => one(process(n, 0.0, 1.0, dt.sqrt(), random)),
        Effect::RandomTelegraph => one(telegraph(n, dt, parameter, random)),
        Effect::NoiseTemperature => one(noise_of_level(&shape.temp(world), random)),
        Effect::Outside(outside) => match outside {
            Outside::TempTimesSupply => one(product(&shape.temp(world), &shape.supply(world))),
            Outside::SupplyTimesLoad => one(product(&shape.supply(world), &shape.load(world))),
            Outside::TempWiggle => {
                let of = |t: &f64| (std::f64::consts::TAU * t / parameter + shape.phase).sin();
                one(world.temp_c.iter().map(of).collect())
            }
            Outside::TempDip => {
                let middle = shape.anchor.temp[0]
                    + (shape.phase / std::f64::consts::PI - 1.0) * 0.5 * shape.anchor.temp[1];
                one(world.temp_c.iter().map(|t| -(-0.5 * ((t - middle) / parameter).powi(2)).exp()).collect())
            }
            Outside::NoiseLevel => one(noise_of_level(&shape.source(world), random)),
            Outside::Oscillation => {
                let phase = between(random, 0.0, std::f64::consts::TAU);
                one((0..n).map(|k| (std::f64::consts::TAU * time(k) / parameter + phase).sin()).collect())
            }
            Outside::Threshold => {
                let level = 0.4 * (shape.phase / std::f64::consts::PI - 1.0);
                one(shape.source(world).iter().map(|x| f64::from(u8::from(*x > level))).collect())
            }
            Outside::Recoveries => {
                let mut next_s = between(random, 30.0, 120.0);
                let (mut state, decay) = (0.0, (-dt / parameter).exp());
                let step = |k: usize| {
                    state *= decay;
                    if time(k) >= next_s {
                        state += sign(random) * between(random, 0.5, 1.5);
                        next_s += between(random, 80.0, 250.0);
                    }
                    state
                };
                one((0..n).map(step).collect())
            }
            Outside::Bursts => {
                let mut on = vec![false; n];
                let mut t = between(random, 5.0, 60.0);
                while t < duration_s {
                    let end = t + between(random, 5.0, 20.0);
                    let rows = (t / dt) as usize..((end / dt) as usize).min(n);
                    on[rows].fill(true);
                    t = end + between(random, 20.0, 150.0);
                }
                let w = std::f64::consts::TAU * parameter;
                one((0..n).map(|k| if on[k] { (w * time(k)).sin() } else { 0.0 }).collect())
            }
        },
        _ => Vec::new(),
    }
}

/// Sine and cosine of a line whose frequency is a random walk that reaches 0.1 to 0.5 Hz by the end.
fn drifting_line(n: usize, dt: f64, freq_hz: f64, random: &mut Random) -> Vec<NamedSeries> {
    let step = between(random, 0.1, 0.5) / (n as f64).sqrt();
    let (mut freq, mut phase) = (freq_hz, between(random, 0.0, std::f64::consts::TAU));
    let (mut sines, mut cosines) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for _ in 0..n {
        sines.push(phase.sin());
        cosines.push(phase.cos());
        freq += step * normal(random);
        phase = (phase + std::f64::consts::TAU * freq * dt) % std::f64::consts::TAU;
    }
    vec![("line_sin".to_owned(), sines), ("line_cos".to_owned(), cosines)]
}

/// First-order process, driven by white noise.
fn process(n: usize, start: f64, decay: f64, drive: f64, random: &mut Random) -> Vec<f64> {
    let mut state = start;
    let mut next = || {
        let value = state;
        state = decay * state + drive * normal(random);
        value
    };
    (0..n).map(|_| next()).collect()
}

/// White noise whose standard deviation rises from 0 to 1 while `source` goes from −1 to 1.
fn noise_of_level(source: &[f64], random: &mut Random) -> Vec<f64> {
    source.iter().map(|x| (0.5 * (x + 1.0)).clamp(0.0, 1.5) * normal(random)).collect()
}

/// Two states with exponentially distributed dwell times.
fn telegraph(n: usize, dt: f64, dwell_s: f64, random: &mut Random) -> Vec<f64> {
    let mut state = sign(random);
    (0..n)
        .map(|_| {
            if chance(random, dt / dwell_s) {
                state = -state;
            }
            state
        })
        .collect()
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}
