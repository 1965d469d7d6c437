//! Temporary vibration: a building in the wind, a phone's vibration motor, a fan.

use std::f64::consts::TAU;

use super::motion::{Motion, times};
use crate::random::{Random, between, chance, direction, log_between};
use crate::thermal::raised_cosine;
use crate::world::World;

/// Coupling of a vibration into the device: a share for each axis.
struct Coupling {
    force: [f64; 3],
    /// Rate per specific force, rad/s per m/s².
    rate: [f64; 3],
}

impl Coupling {
    fn draw(rate_per_force: f64, random: &mut Random) -> Self {
        Self { force: direction(random), rate: direction(random).map(|part| rate_per_force * part) }
    }
}

/// Adds `amplitude`(t) times the sine of the integral of `hz`(t) to all axes.
fn add(
    motion: &mut Motion,
    coupling: &Coupling,
    (from_s, to_s): (f64, f64),
    period_s: f64,
    mut course: impl FnMut(f64) -> (f64, f64),
) {
    let rows =
        (from_s / period_s).ceil().max(0.0) as usize..((to_s / period_s) as usize).min(motion.axes[0].len());
    let mut turns = 0.0;
    for row in rows {
        let (hz, amplitude) = course(row as f64 * period_s);
        turns += hz * period_s;
        let (sin, cos) = (TAU * turns).sin_cos();
        for axis in 0..3 {
            motion.axes[axis][row] += amplitude * coupling.force[axis] * sin;
            motion.axes[3 + axis][row] += amplitude * coupling.rate[axis] * cos;
        }
    }
}

/// Adds a mode of 0.1 to 0.6 Hz of a tall building, with a peak of 0.5 to 30 mm/s², in gusts for 10 to 40 % of the time.
pub(super) fn sway(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let share = between(random, 0.1, 0.4);
    let hz = log_between(random, 0.1, 0.6);
    let largest = log_between(random, 0.0005, 0.03);
    // the floor tilts as it bends: speed over the height of the building
    let coupling = Coupling::draw(1.0 / (TAU * hz * log_between(random, 5.0, 100.0)), random);
    let gusts = 1 + between(random, 0.0, 4.99) as usize;
    let length_s = share * world.duration_s() / gusts as f64;
    for gust in 0..gusts {
        let room_s = world.duration_s() / gusts as f64;
        let from_s = gust as f64 * room_s + between(random, 0.0, room_s - length_s);
        let to_s = from_s + length_s;
        let size = largest * between(random, 0.4, 1.0);
        let rise_s = length_s * between(random, 0.1, 0.4);
        let envelope = [(from_s, 0.0), (from_s + rise_s, size), (to_s - rise_s, size), (to_s, 0.0)];
        let wander_s = between(random, 40.0, 200.0);
        add(&mut motion, &coupling, (from_s, to_s), world.period_s, |t| {
            (hz * (1.0 + 0.01 * (TAU * t / wander_s).sin()), raised_cosine(&envelope, t))
        });
        motion.is_over(from_s, to_s);
    }
    motion
}

/// A vibration motor of 130 to 240 Hz, 0.5 to 30 m/s², in patterns of bursts of 0.1 to 1 s, 2 to 12 times; it spins up
/// and runs out in 20 to 150 ms. What is above half the sample rate is aliased, as in a part whose filter is wide.
pub(super) fn motor(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let hz = between(random, 130.0, 240.0);
    let size = log_between(random, 0.5, 30.0);
    let coupling = Coupling::draw(log_between(random, 0.002, 0.05), random);
    let calls = times(world, [2.0, 12.99], random);
    for _ in 0..calls {
        let from_s = between(random, 1.0, world.duration_s() - 10.0);
        let (bursts, on_s) = (1 + between(random, 0.0, 3.99) as usize, log_between(random, 0.1, 1.0));
        let off_s = between(random, 0.1, 0.6);
        let (rise_s, end_s) = (between(random, 0.02, 0.1), between(random, 0.02, 0.15));
        let mut at_s = from_s;
        for _ in 0..bursts {
            let envelope = [
                (at_s, 0.0),
                (at_s + rise_s, 1.0),
                (at_s + rise_s + on_s, 1.0),
                (at_s + rise_s + on_s + end_s, 0.0),
            ];
            let until_s = envelope[3].0;
            add(&mut motion, &coupling, (at_s, until_s), world.period_s, |t| {
                let speed = raised_cosine(&envelope, t);
                // the force of an eccentric mass is proportional to the square of its speed
                (hz * speed, size * speed * speed)
            });
            at_s = until_s + off_s;
        }
        motion.is_over(from_s, at_s);
    }
    motion
}

/// Adds a fan of 15 to 95 Hz and its harmonic, 5 to 500 mm/s², that runs for 20 to 60 % of the time; it spins up in 2 to
/// 6 s and down in 3 to 15 s; its speed wanders by parts in a thousand.
pub(super) fn fan(world: &World, random: &mut Random) -> Motion {
    let mut motion = Motion::none(world.len());
    let hz = between(random, 15.0, 95.0);
    let size = log_between(random, 0.005, 0.5);
    let couplings = [0, 1].map(|_| Coupling::draw(log_between(random, 0.0005, 0.02), random));
    let second = if chance(random, 0.6) { between(random, 0.1, 0.7) } else { 0.0 };
    let runs = 1 + between(random, 0.0, 2.99) as usize;
    let share = between(random, 0.2, 0.6);
    let room_s = world.duration_s() / runs as f64;
    for run in 0..runs {
        let length_s = share * room_s;
        let from_s = run as f64 * room_s + between(random, 0.0, room_s - length_s);
        let to_s = from_s + length_s;
        let (rise_s, end_s) = (between(random, 2.0, 6.0), between(random, 3.0, 15.0));
        let envelope = [(from_s, 0.0), (from_s + rise_s, 1.0), (to_s - end_s, 1.0), (to_s, 0.0)];
        let (wander, wander_s) = (log_between(random, 1e-4, 5e-3), between(random, 20.0, 120.0));
        for (harmonic, part) in [(1.0, 1.0), (2.0, second)] {
            let coupling = &couplings[usize::from(harmonic > 1.0)];
            add(&mut motion, coupling, (from_s, to_s), world.period_s, |t| {
                let speed = raised_cosine(&envelope, t);
                let hz = harmonic * hz * speed * (1.0 + wander * (TAU * t / wander_s).sin());
                (hz, part * size * speed * speed)
            });
        }
        motion.is_over(from_s, to_s);
    }
    motion
}
