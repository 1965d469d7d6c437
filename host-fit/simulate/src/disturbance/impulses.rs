//! Short blows: knocks on the table, steps on the floor, doors. Each excites a few modes of the support of the device.

use std::f64::consts::TAU;

use super::motion::{Motion, times};
use crate::random::{Random, between, chance, direction, log_between, sign};
use crate::world::World;

/// Support of the device: modes that ring when it is struck.
struct Support {
    modes: Vec<Mode>,
}

/// A mode: frequency, decay, and coupling into the device.
struct Mode {
    hz: f64,
    /// Decay time to 1/e, s.
    decay_s: f64,
    /// Coupling into each axis: force per unit of the blow; rate, rad/s per m/s².
    force: [f64; 3],
    rate: [f64; 3],
}

impl Support {
    /// Draws one to four modes between these frequencies, each ringing for 2 to 15 periods.
    fn draw([low_hz, high_hz]: [f64; 2], random: &mut Random) -> Self {
        let count = 1 + between(random, 0.0, 3.99) as usize;
        let modes = (0..count).map(|number| {
            let hz = log_between(random, low_hz, high_hz);
            let share = if number == 0 { 1.0 } else { between(random, 0.1, 0.8) };
            // the rotation that accompanies a swing: speed over a lever of 2 cm to 2 m
            let lever_m = log_between(random, 0.02, 2.0);
            let turn = direction(random).map(|part| share * part / (TAU * hz * lever_m));
            Mode {
                hz,
                decay_s: log_between(random, 2.0, 15.0) / hz,
                force: direction(random).map(|part| share * part),
                rate: turn,
            }
        });
        Self { modes: modes.collect() }
    }

    /// Adds a blow of `size` m/s² at `at_s`; returns the time at which it has decayed.
    fn strike(
        &self,
        motion: &mut Motion,
        (at_s, size): (f64, f64),
        period_s: f64,
        random: &mut Random,
    ) -> f64 {
        let mut until_s = at_s;
        let flip = sign(random);
        for mode in &self.modes {
            let phase = between(random, 0.0, 0.5);
            let end_s = at_s + 7.0 * mode.decay_s;
            until_s = until_s.max(end_s);
            let first = (at_s / period_s).ceil().max(0.0) as usize;
            let last = ((end_s / period_s) as usize).min(motion.axes[0].len());
            for row in first..last {
                let t = row as f64 * period_s - at_s;
                // a blow takes 1 to 5 ms: it begins within a sample
                let swing = size * flip * (-t / mode.decay_s).exp() * (1.0 - (-t / 0.002).exp());
                let angle = TAU * mode.hz * t + phase;
                for axis in 0..3 {
                    motion.axes[axis][row] += swing * mode.force[axis] * angle.sin();
                    motion.axes[3 + axis][row] += swing * mode.rate[axis] * angle.cos();
                }
            }
        }
        until_s
    }
}

/// Adds 2 to 8 knocks within 25 minutes, of 0.05 to 30 m/s², some of them two or three in a row.
pub(super) fn knocks(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let support = Support::draw([8.0, 90.0], random);
    let wanted = times(world, [2.0, 8.99], random);
    for _ in 0..wanted {
        let at_s = between(random, 1.0, world.duration_s() - 2.0);
        let blows = if chance(random, 0.3) { 2 + usize::from(chance(random, 0.4)) } else { 1 };
        let size = log_between(random, 0.05, 30.0);
        let (mut next_s, mut until_s) = (at_s, at_s);
        for _ in 0..blows {
            let own = size * between(random, 0.6, 1.2);
            until_s = support.strike(&mut motion, (next_s, own), world.period_s, random).max(until_s);
            next_s += between(random, 0.12, 0.5);
        }
        motion.is_over(at_s, until_s);
    }
    motion
}

/// Adds walks of 4 to 30 steps, 1.5 to 2.3 per second, each of 3 to 300 mm/s², approaching and then receding.
pub(super) fn footsteps(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let support = Support::draw([6.0, 30.0], random);
    let wanted = times(world, [2.0, 14.0], random);
    for _ in 0..wanted {
        let from_s = between(random, 1.0, world.duration_s() - 2.0);
        let steps = log_between(random, 4.0, 30.0) as usize;
        let cadence_hz = between(random, 1.5, 2.3);
        let nearest = log_between(random, 0.003, 0.3);
        let closest = between(random, 0.0, 1.0) * steps as f64;
        let (mut at_s, mut until_s) = (from_s, from_s);
        for step in 0..steps {
            let away = (step as f64 - closest).abs() * 0.7 / between(random, 1.5, 3.0);
            let size = nearest / (1.0 + away * away) * between(random, 0.7, 1.3);
            until_s = support.strike(&mut motion, (at_s, size), world.period_s, random).max(until_s);
            at_s += between(random, 0.93, 1.07) / cadence_hz;
        }
        motion.is_over(from_s, until_s);
    }
    motion
}

/// Adds 1 to 6 doors: a blow of 5 mm/s² to 1 m/s² to the building, of low frequency and long decay.
pub(super) fn doors(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let support = Support::draw([3.0, 25.0], random);
    let wanted = times(world, [1.0, 6.99], random);
    for _ in 0..wanted {
        let at_s = between(random, 1.0, world.duration_s() - 2.0);
        let size = log_between(random, 0.005, 1.0);
        let until_s = support.strike(&mut motion, (at_s, size), world.period_s, random);
        motion.is_over(at_s, until_s);
    }
    motion
}
