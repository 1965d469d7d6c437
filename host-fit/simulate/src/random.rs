//! Seeded random numbers: one stream for each purpose, so that draws for one purpose never change another.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Generator of the simulated cases.
pub(super) type Random = ChaCha8Rng;

/// Numbers of the logs of a case: reference log, log to explain, evaluation log.
pub(super) const REFERENCE: u64 = 0;
pub(super) const LOG: u64 = 1;
pub(super) const EVALUATION: u64 = 2;

/// Purposes, each a stream of one seed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stream {
    /// Device: noise levels, colour, bias, true rate.
    Unit,
    /// Choice of the optional columns.
    Columns,
    World(u64),
    /// Errors of sensors and recorder in a log.
    Recorder(u64),
    /// Noise of one axis in a log.
    Noise(u64, u64),
    /// Shape of a planted effect (its parameter, its direction), and its course in a log.
    Plant(u64),
    /// Random course of a planted effect in a log.
    Course(u64, u64),
    /// Motion that disturbs a log.
    Disturbance(u64),
    /// Invalid samples of a log.
    Wild(u64),
    Suite(u64),
}

/// Generator for one purpose.
pub(super) fn random(seed: u64, stream: Stream) -> Random {
    let number = match stream {
        Stream::Unit => 1,
        Stream::Columns => 2,
        Stream::World(log) => 10 + log,
        Stream::Recorder(log) => 20 + log,
        Stream::Noise(log, axis) => 100 + 10 * log + axis,
        Stream::Plant(effect) => 1000 + effect,
        Stream::Course(log, effect) => 2000 + 100 * log + effect,
        Stream::Disturbance(log) => 3000 + log,
        Stream::Wild(log) => 3100 + log,
        Stream::Suite(case) => 10_000 + case,
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}

pub(super) fn normal(random: &mut Random) -> f64 {
    StandardNormal.sample(random)
}

/// Log-normal with this median; `deviation` is that of the logarithm.
pub(super) fn log_normal(random: &mut Random, median: f64, deviation: f64) -> f64 {
    median * (deviation * normal(random)).exp()
}

/// Uniform between `low` and `high`.
pub(super) fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random_range(0.0..1.0)
}

/// Uniform in the logarithm.
pub(super) fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    between(random, low.ln(), high.ln()).exp()
}

/// True with this probability.
pub(super) fn chance(random: &mut Random, probability: f64) -> bool {
    random.random_range(0.0..1.0) < probability
}

pub(super) fn sign(random: &mut Random) -> f64 {
    if chance(random, 0.5) { 1.0 } else { -1.0 }
}

/// A direction, uniform on the sphere.
pub(super) fn direction(random: &mut Random) -> [f64; 3] {
    loop {
        let v = [normal(random), normal(random), normal(random)];
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.1 {
            return v.map(|x| x / length);
        }
    }
}
