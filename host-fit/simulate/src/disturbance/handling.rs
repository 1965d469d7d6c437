//! Handling: the device is picked up, rotated in the hand, and put down, in the old orientation within a degree or in a
//! new one.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use super::motion::{Motion, times};
use crate::random::{Random, between, chance, direction, log_between, normal};
use crate::world::World;

/// Adds one to six pick-ups of 3 to 20 s each, never within 20 s of one another. The sensor measures rotations, the
/// acceleration of the hand and its tremor; afterwards gravity in the new orientation, which in two of three cases is
/// the old one to within 1.5°.
pub(super) fn handling(world: &World, random: &mut Random) -> Motion {
    let n = world.len();
    let period_s = world.period_s;
    let mut motion = Motion::none(n);
    let wanted = times(world, [1.0, 6.99], random);
    let room_s = world.duration_s() / wanted as f64;
    // rotation relative to the initial orientation
    let mut turned = UnitQuaternion::identity();
    let mut row = 0;
    for time in 0..wanted {
        let length_s = between(random, 3.0, 20.0_f64.min(room_s / 3.0));
        let from_s = time as f64 * room_s + between(random, 0.2 * room_s, 0.9 * room_s - length_s);
        let (first, last) = ((from_s / period_s) as usize, ((from_s + length_s) / period_s) as usize);
        lie(&mut motion, world, turned, row..first);
        let away = Vector3::from(direction(random)) * between(random, 0.2, 2.5);
        let end = match chance(random, 0.65) {
            true => Vector3::from(direction(random)) * between(random, 0.0, 1.5_f64.to_radians()),
            false => Vector3::from(direction(random)) * between(random, 0.1, 3.0),
        };
        let wobble: Vec<(Vector3<f64>, f64, f64)> = (0..3)
            .map(|_| {
                (
                    Vector3::from(direction(random)) * log_between(random, 0.02, 0.3),
                    between(random, 0.3, 2.5),
                    between(random, 0.0, TAU),
                )
            })
            .collect();
        let tremor_hz = between(random, 8.0, 12.0);
        let tremor = log_between(random, 0.02, 0.3);
        let lift = Vector3::from(direction(random)) * log_between(random, 0.5, 6.0);
        let mut before = turned;
        for row in first..last {
            let x = (row - first) as f64 / (last - first) as f64;
            let t = (row - first) as f64 * period_s;
            // up, about in the hand, down
            let held = (TAU / 2.0 * x).sin().powi(2);
            let gone = 0.5 - 0.5 * (TAU / 2.0 * x).cos();
            let sway: Vector3<f64> =
                wobble.iter().map(|(turn, hz, phase)| turn * (TAU * hz * t + phase).sin()).sum();
            let now = UnitQuaternion::from_scaled_axis(away * held + end * gone + sway * held) * turned;
            let rate = (now * before.inverse()).scaled_axis() / -period_s;
            let shake: Vector3<f64> = Vector3::from(std::array::from_fn(|_| {
                tremor * held * ((TAU * tremor_hz * t).sin() + 0.7 * normal(random))
            }));
            let swing = lift * (2.0 * TAU * x).sin() * held + shake;
            let force = force_of(world, row);
            let seen = now * force + swing - force;
            for axis in 0..3 {
                motion.axes[axis][row] += seen[axis];
                motion.axes[3 + axis][row] += rate[axis];
            }
            before = now;
        }
        turned = UnitQuaternion::from_scaled_axis(end) * turned;
        // put down: a knock that rings for a tenth of a second
        let knock = log_between(random, 0.3, 15.0);
        let way = direction(random);
        for row in last..(last + (0.15 / period_s) as usize).min(n) {
            let t = (row - last) as f64 * period_s;
            let swing = knock * (-t / 0.02).exp() * (TAU * 45.0 * t).cos();
            for axis in 0..3 {
                motion.axes[axis][row] += swing * way[axis];
                motion.axes[3 + axis][row] += 0.02 * swing * way[(axis + 1) % 3];
            }
        }
        motion.is_over(from_s, from_s + length_s + 0.15);
        row = last;
    }
    lie(&mut motion, world, turned, row..n);
    motion
}

fn force_of(world: &World, row: usize) -> Vector3<f64> {
    Vector3::from(std::array::from_fn(|axis| world.force_mps2[axis][row]))
}

/// Adds the difference of the specific forces at rest in an orientation other than that of the world.
fn lie(motion: &mut Motion, world: &World, turned: UnitQuaternion<f64>, rows: std::ops::Range<usize>) {
    if turned == UnitQuaternion::identity() {
        return;
    }
    for row in rows {
        let force = force_of(world, row);
        let seen = turned * force - force;
        for axis in 0..3 {
            motion.axes[axis][row] += seen[axis];
        }
    }
}
