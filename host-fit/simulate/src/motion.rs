//! Orientations, rotations, vibration and rates: the true force, field and rate of a log.

use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::part::DEGREE;
use super::random::{Random, between, chance, direction, log_between, normal, sign};
use super::thermal::raised_cosine;
use super::world::World;
use fos_data::unit::STANDARD_GRAVITY_MPS2;

/// Specific force of gravity at rest, in the axes of the earth (up is +z), m/s².
pub(super) const UP: [f64; 3] = [0.0, 0.0, STANDARD_GRAVITY_MPS2];

/// Duration of a turn of the rig, s.
const TURN_S: f64 = 2.5;

/// Attitude of a device in the earth's field.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attitude {
    /// Rotation from the axes of the earth to those of the device.
    to_unit: UnitQuaternion<f64>,
    /// Magnetic field in the axes of the earth, µT.
    field_ut: Vector3<f64>,
}

impl Attitude {
    /// Flat on a table, with a random heading.
    pub(super) fn level(random: &mut Random) -> Self {
        let tilt = [between(random, -1.0, 1.0) * DEGREE, between(random, -1.0, 1.0) * DEGREE];
        let heading = between(random, 0.0, std::f64::consts::TAU);
        Self {
            to_unit: UnitQuaternion::from_euler_angles(tilt[0], tilt[1], heading),
            field_ut: earth_field(random),
        }
    }

    pub(super) fn any(random: &mut Random) -> Self {
        Self { to_unit: random_rotation(random), field_ut: earth_field(random) }
    }

    fn force(&self) -> [f64; 3] {
        (self.to_unit * Vector3::from(UP)).into()
    }

    fn field(&self) -> [f64; 3] {
        (self.to_unit * self.field_ut).into()
    }
}

/// Magnetic field of middle latitudes, µT: 20 to 28 to the north, 40 to 47 down.
fn earth_field(random: &mut Random) -> Vector3<f64> {
    Vector3::new(between(random, 20.0, 28.0), 0.0, -between(random, 40.0, 47.0))
}

fn random_rotation(random: &mut Random) -> UnitQuaternion<f64> {
    let [a, b, c] = direction(random);
    let axis = Unit::new_normalize(Vector3::new(a, b, c));
    // the angle of a uniformly distributed rotation has the density (1 − cos θ)/π; this is close enough for orientations
    UnitQuaternion::from_axis_angle(&axis, std::f64::consts::PI * between(random, 0.0, 1.0).cbrt())
}

pub(super) fn hold(world: &mut World, pose: &Attitude, n: usize) {
    world.force_mps2 = pose.force().map(|value| vec![value; n]);
    world.field_ut = pose.field().map(|value| vec![value; n]);
    world.rate_rads = std::array::from_fn(|_| vec![0.0; n]);
    world.vibration = vec![0.0; n];
}

/// Random orientations, held for 20 to 55 s; between two, a rotation about one axis, smooth at both ends. `field_ut`
/// overrides the field in the axes of the earth.
pub(super) fn pose(world: &mut World, field_ut: Option<[f64; 3]>, n: usize, random: &mut Random) {
    let field_ut = field_ut.map_or_else(|| earth_field(random), Vector3::from);
    let period_s = world.period_s;
    let mut attitudes = Vec::with_capacity(n);
    let mut still = Vec::with_capacity(n);
    let mut from = random_rotation(random);
    let turn = (TURN_S / period_s) as usize;
    while attitudes.len() < n {
        let held = (between(random, 20.0, 55.0) / period_s) as usize;
        attitudes.extend(std::iter::repeat_n(from, held));
        still.extend(std::iter::repeat_n(true, held));
        let to = random_rotation(random);
        // slerp is undefined for half a turn; the rotation vector is not
        let whole = (to * from.inverse()).scaled_axis();
        for k in 0..turn {
            let x = (k + 1) as f64 / (turn + 1) as f64;
            let part = 0.5 * (1.0 - (std::f64::consts::PI * x).cos());
            attitudes.push(UnitQuaternion::from_scaled_axis(whole * part) * from);
        }
        still.extend(std::iter::repeat_n(false, turn));
        from = to;
    }
    attitudes.truncate(n);
    still.truncate(n);
    follow(world, &attitudes, field_ut);
    world.rate_rads = rates(&attitudes, period_s);
    world.still = Some(still);
    world.vibration = vec![0.0; n];
    world.force_is_logged = true;
}

/// Adds magnets put near the device and taken away, every 30 to 120 s: up to some 600 µT.
pub(super) fn add_magnets(world: &mut World, random: &mut Random) {
    let duration_s = world.duration_s();
    for field in &mut world.field_ut {
        let mut t = 0.0;
        let mut points = vec![(0.0, 0.0)];
        while t < duration_s {
            t += between(random, 30.0, 120.0);
            let level = if chance(random, 0.4) { 0.0 } else { 250.0 * normal(random) };
            points.extend([(t, points[points.len() - 1].1), (t + 1.5, level)]);
            t += 1.5;
        }
        for (n, value) in field.iter_mut().enumerate() {
            *value += raised_cosine(&points, n as f64 * world.period_s);
        }
    }
}

/// One orientation, and vibration above 10 Hz: broadband and up to three lines, most of it on one axis; the level
/// changes every 30 to 90 s. The mean of the vibration is zero over any second.
pub(super) fn shake(world: &mut World, pose: &Attitude, n: usize, random: &mut Random) {
    hold(world, pose, n);
    let period_s = world.period_s;
    let mut points = vec![(0.0, 0.0)];
    while points[points.len() - 1].0 < n as f64 * period_s {
        let (t, level) = points[points.len() - 1];
        let next = if chance(random, 0.2) { 0.0 } else { log_between(random, 0.3, 3.5) };
        let until = t + between(random, 30.0, 90.0);
        points.extend([(until, level), (until + 1.0, next)]);
    }
    let level: Vec<f64> = (0..n).map(|k| raised_cosine(&points, k as f64 * period_s)).collect();
    let strongest = (between(random, 0.0, 3.0) as usize).min(2);
    let lines: Vec<[f64; 2]> = (0..(between(random, 0.0, 3.99) as usize))
        .map(|_| [between(random, 18.0, 95.0), between(random, 0.2, 0.7)])
        .collect();
    let resonance = between(random, 25.0, 80.0);
    let (mut total, mut share) = (0.0, [0.0; 3]);
    for (axis, share) in share.iter_mut().enumerate() {
        *share = if axis == strongest { 1.0 } else { between(random, 0.15, 0.45) };
        total += *share * *share;
    }
    for (force, share) in world.force_mps2.iter_mut().zip(share) {
        add_vibration(force, &level, (resonance, &lines, share), period_s, random);
    }
    world.vibration = level.iter().map(|level| total * level * level).collect();
}

/// Adds vibration of unit variance times level and share: a resonance driven by differenced white noise, and lines.
fn add_vibration(
    force: &mut [f64],
    level: &[f64],
    (resonance_hz, lines, share): (f64, &[[f64; 2]], f64),
    period_s: f64,
    random: &mut Random,
) {
    let radius: f64 = 0.75;
    let ar = [2.0 * radius * (std::f64::consts::TAU * resonance_hz * period_s).cos(), -radius * radius];
    let broad = super::coloured::Colour::new(ar, -1.0);
    let of_lines: f64 = lines.iter().map(|[_, amplitude]| 0.5 * amplitude * amplitude).sum();
    let scale = share / (1.0 + of_lines).sqrt();
    let phases: Vec<f64> = lines.iter().map(|_| between(random, 0.0, std::f64::consts::TAU)).collect();
    let (mut past, mut last) = ([0.0; 2], 0.0);
    for (n, (force, level)) in force.iter_mut().zip(level).enumerate() {
        let e = broad.innovation * normal(random);
        let value = ar[0] * past[0] + ar[1] * past[1] + e - last;
        (past, last) = ([value, past[0]], e);
        let t = n as f64 * period_s;
        let sum: f64 = lines
            .iter()
            .zip(&phases)
            .map(|([freq_hz, amplitude], phase)| {
                amplitude * (std::f64::consts::TAU * freq_hz * t + phase).sin()
            })
            .sum();
        *force += scale * level * (value + sum);
    }
}

/// A table that rotates about one of the device's axes, at first within 8° of the vertical: dwells, staircases of both
/// signs, slow sines, up to 100 to 200 °/s. The device is not quite square on the table, and the table's inner axes make
/// slow moves of their own of 1 to 2 °/s, which gradually tilt it further. The true specific force is gravity rotated
/// along.
pub(super) fn turn_table(world: &mut World, axis: usize, n: usize, random: &mut Random) {
    let period_s = world.period_s;
    let main = programme(n as f64 * period_s, between(random, 100.0, 200.0) * DEGREE, random);
    let tilt: [f64; 3] = std::array::from_fn(|_| between(random, -0.008, 0.008));
    let moves: [[f64; 3]; 3] = std::array::from_fn(|_| {
        [
            between(random, 0.8, 2.5) * DEGREE,
            log_between(random, 20.0, 50.0),
            between(random, 0.0, std::f64::consts::TAU),
        ]
    });
    let mut rates: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(n));
    let mut attitudes = Vec::with_capacity(n);
    let mut up = [0.0; 3];
    up[axis] = 1.0;
    let lean = UnitQuaternion::from_scaled_axis(Vector3::from(direction(random)) * 8.0 * DEGREE);
    let vertical = Vector3::z_axis().into_inner();
    let start = UnitQuaternion::rotation_between(&vertical, &Vector3::from(up))
        .unwrap_or_else(|| UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI));
    let mut attitude = start * lean;
    for sample in 0..n {
        let t = sample as f64 * period_s;
        let rate = main.rate(t);
        let mut omega = [0.0; 3];
        for k in 0..3 {
            let [size, cycle_s, phase] = moves[k];
            omega[k] = if k == axis {
                rate
            } else {
                tilt[k] * rate + size * (std::f64::consts::TAU * t / cycle_s + phase).sin()
            };
            rates[k].push(omega[k]);
        }
        attitudes.push(attitude);
        attitude = UnitQuaternion::from_scaled_axis(Vector3::from(omega) * -period_s) * attitude;
        if sample % 1000 == 0 {
            attitude.renormalize();
        }
    }
    let field_ut = earth_field(random);
    follow(world, &attitudes, field_ut);
    world.rate_rads = rates;
    world.vibration = vec![0.0; n];
    (world.force_is_logged, world.rate_is_logged) = (true, true);
}

/// Programme of the table: rates between which it moves smoothly, and sines.
struct Programme {
    points: Vec<(f64, f64)>,
    /// Start (s), end (s), amplitude (rad/s) and period (s) of each sine.
    sines: Vec<[f64; 4]>,
}

impl Programme {
    fn rate(&self, t: f64) -> f64 {
        // the sines are in order; between them the staircase
        let next = self.sines.partition_point(|sine| sine[0] <= t);
        match next.checked_sub(1).map(|i| self.sines[i]) {
            Some([start, end, amplitude, cycle_s]) if t < end => {
                amplitude * (std::f64::consts::TAU * (t - start) / cycle_s).sin()
            }
            _ => raised_cosine(&self.points, t),
        }
    }
}

fn programme(duration_s: f64, largest: f64, random: &mut Random) -> Programme {
    let mut programme = Programme { points: vec![(0.0, 0.0)], sines: Vec::new() };
    let mut t = between(random, 15.0, 40.0);
    programme.points.push((t, 0.0));
    while t < duration_s {
        if chance(random, 0.5) {
            // a staircase: up or down, then the other way
            let first = sign(random);
            for (side, step) in [(first, 1), (first, 2), (first, 3), (-first, 1), (-first, 2), (-first, 3)] {
                let level = side * largest * f64::from(step) / 3.0;
                programme.points.push((t + 2.0, level));
                t += 2.0 + between(random, 12.0, 25.0);
                programme.points.push((t, level));
            }
            programme.points.push((t + 3.0, 0.0));
            t += 3.0;
        } else {
            let cycle_s = between(random, 30.0, 100.0);
            let end = t + cycle_s * (2.0 + between(random, 0.0, 2.0).floor());
            programme.sines.push([t, end, largest * between(random, 0.5, 1.0), cycle_s]);
            t = end;
        }
        programme.points.push((t, 0.0));
        t += between(random, 15.0, 45.0);
        programme.points.push((t, 0.0));
    }
    programme
}

/// Sets force and field of a device in these attitudes.
fn follow(world: &mut World, attitudes: &[UnitQuaternion<f64>], field_ut: Vector3<f64>) {
    let up = Vector3::from(UP);
    let n = attitudes.len();
    world.force_mps2 = std::array::from_fn(|_| Vec::with_capacity(n));
    world.field_ut = std::array::from_fn(|_| Vec::with_capacity(n));
    for to_unit in attitudes {
        let (force, field) = (to_unit * up, to_unit * field_ut);
        for k in 0..3 {
            world.force_mps2[k].push(force[k]);
            world.field_ut[k].push(field[k]);
        }
    }
}

/// Rate of a device in these attitudes, rad/s, in its own axes.
fn rates(attitudes: &[UnitQuaternion<f64>], period_s: f64) -> [Vec<f64>; 3] {
    let mut rates: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(attitudes.len()));
    for pair in
        attitudes.windows(2).chain(attitudes.last().map(|last| [*last, *last]).as_ref().map(|p| &p[..]))
    {
        let turned =
            if pair[0] == pair[1] { Vector3::zeros() } else { (pair[1] * pair[0].inverse()).scaled_axis() };
        for k in 0..3 {
            rates[k].push(-turned[k] / period_s);
        }
    }
    rates
}
