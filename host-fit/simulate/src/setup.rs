//! Use of a device while it is recorded: on a bench, a desk, a pose rig, a shaker, a rate table.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::motion::{self, Attitude};
use super::random::{Random, between, chance, log_between, normal, sign};
use super::thermal::{Ambient, Thermal};
use super::world::World;

/// A use of a device. An accelerometer on the shaker measures the vibration, as it should: the log does not state which
/// part of that is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Setup {
    /// Static on a bench; a temperature cycle or a quiet room, occasional steps of the supply.
    Bench,
    /// Static on a desk; a changing load heats the board and lets the supply sag.
    Desk,
    /// A rig holds orientations of 20 to 55 s, turning in 2.5 s; the true specific force is logged.
    PoseRig,
    /// A shaker changes its level every 30 to 90 s.
    Shaker,
    /// A table turns about one axis with known rates; true rate and specific force are logged.
    RateTable,
}

/// Course of the covariates, possibly one that makes two effects indistinguishable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// Defined by the set-up.
    Drawn,
    /// The temperature is linear in time.
    TemperatureRamp,
    /// The temperature approaches its final value exponentially from power-on.
    TemperatureExponential {
        /// Time constant, s.
        tau_s: f64,
    },
    /// The supply is a multiple of the temperature.
    SupplyFollowsTemperature,
    /// The magnetic field is vertical, as at a pole: a multiple of the specific force in every orientation.
    FieldAlongForce,
}

/// Requirements on a log, independent of the draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Wants {
    /// Temperature must move.
    pub(super) temperature: bool,
    /// The supply must move.
    pub(super) supply: bool,
    /// Magnets must be nearby.
    pub(super) magnets: bool,
    /// The log to explain and the evaluation log must have the same orientation.
    pub(super) same_pose: bool,
}

/// A device in its surroundings: the common part of its logs.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) setup: Setup,
    pub(super) path: Path,
    pub(super) wants: Wants,
    /// Axis of rotation of the table: 0, 1, 2.
    pub(super) table_axis: usize,
    pub(super) period_s: f64,
    thermal: Thermal,
    temperature_moves: bool,
    supply_moves: bool,
    magnets: bool,
    supply_v: f64,
    volts_per_kelvin: f64,
    rise_k: f64,
    ramp: Ambient,
    sag_v: f64,
    pose: Attitude,
    field_parallel: f64,
}

impl Scene {
    /// Draws the surroundings. `target` and `turns_target` determine the axis of the rate table.
    pub(super) fn draw(
        (setup, path): (Setup, Path),
        wants: Wants,
        (target, turns_target): (Axis, bool),
        period_s: f64,
        random: &mut Random,
    ) -> Self {
        let likely = if matches!(setup, Setup::Bench | Setup::RateTable) { 0.6 } else { 0.12 };
        let other = (target.direction() + if chance(random, 0.5) { 1 } else { 2 }) % 3;
        let rise_k = sign(random) * between(random, 8.0, 15.0);
        Self {
            setup,
            path,
            wants,
            table_axis: if turns_target { target.direction() } else { other },
            period_s,
            thermal: Thermal::draw(random),
            temperature_moves: chance(random, likely) || wants.temperature,
            supply_moves: chance(random, 0.35) || wants.supply,
            magnets: chance(random, 0.5) || wants.magnets,
            supply_v: between(random, 2.97, 3.03),
            volts_per_kelvin: sign(random) * between(random, 0.006, 0.012),
            rise_k,
            ramp: Ambient::Ramp(rise_k / between(random, 1200.0, 1800.0)),
            sag_v: between(random, 0.05, 0.15),
            pose: if chance(random, 0.5) { Attitude::level(random) } else { Attitude::any(random) },
            field_parallel: sign(random) * between(random, 3.0, 6.0),
        }
    }

    /// Reference log: rest in one orientation under steady conditions.
    pub(super) fn reference(&self, duration_s: f64, random: &mut Random) -> World {
        let n = self.samples(duration_s);
        let mut world = self.covariates(n, Ambient::Still, false, false, random);
        motion::hold(&mut world, &self.pose, n);
        world
    }

    /// Log to explain or evaluation log: the set-up at work.
    pub(super) fn log(&self, duration_s: f64, is_eval: bool, random: &mut Random) -> World {
        let n = self.samples(duration_s);
        let ambient = match self.path {
            Path::TemperatureRamp => self.ramp,
            Path::TemperatureExponential { tau_s } => Ambient::Exponential { rise_k: self.rise_k, tau_s },
            _ if self.temperature_moves || self.path == Path::SupplyFollowsTemperature => Ambient::Cycle,
            _ => Ambient::Room,
        };
        let works = self.setup == Setup::Desk;
        let mut world = self.covariates(n, ambient, works, self.supply_moves, random);
        if self.path == Path::SupplyFollowsTemperature {
            let first = world.temp_c[0];
            world.supply_v =
                world.temp_c.iter().map(|t| self.supply_v + self.volts_per_kelvin * (t - first)).collect();
        }
        let new_pose = is_eval && !self.wants.same_pose && chance(random, 0.5);
        let pose = if new_pose { Attitude::any(random) } else { self.pose };
        match self.setup {
            Setup::Bench | Setup::Desk => motion::hold(&mut world, &pose, n),
            Setup::Shaker => motion::shake(&mut world, &pose, n, random),
            Setup::RateTable => motion::turn_table(&mut world, self.table_axis, n, random),
            Setup::PoseRig if self.path == Path::FieldAlongForce => {
                motion::pose(
                    &mut world,
                    Some(motion::UP.map(|force| self.field_parallel * force)),
                    n,
                    random,
                );
            }
            Setup::PoseRig => {
                motion::pose(&mut world, None, n, random);
                if self.magnets {
                    motion::add_magnets(&mut world, random);
                }
            }
        }
        world
    }

    fn samples(&self, duration_s: f64) -> usize {
        (duration_s / self.period_s) as usize
    }

    /// Load, temperature and supply.
    fn covariates(
        &self,
        n: usize,
        ambient: Ambient,
        works: bool,
        supply_moves: bool,
        random: &mut Random,
    ) -> World {
        let load_pct = if works { self.work(n, random) } else { vec![between(random, 3.0, 8.0); n] };
        let temp_c = self.thermal.die(ambient, &load_pct, self.period_s, random);
        let supply_v = self.supply(&load_pct, works, supply_moves, random);
        World { period_s: self.period_s, temp_c, supply_v, load_pct, ..World::default() }
    }

    /// Load, %, in steps of 20 to 120 s.
    fn work(&self, n: usize, random: &mut Random) -> Vec<f64> {
        let mut load = Vec::with_capacity(n);
        while load.len() < n {
            let level = if chance(random, 0.3) { 0.0 } else { between(random, 5.0, 100.0) };
            let samples = (between(random, 20.0, 120.0) / self.period_s) as usize;
            load.resize((load.len() + samples).min(n), level);
        }
        load
    }

    /// Supply, V: a slow wander; levels of a laboratory supply; the sag under load.
    fn supply(&self, load: &[f64], works: bool, moves: bool, random: &mut Random) -> Vec<f64> {
        let tau_s = 60.0;
        let sd = between(random, 0.0008, 0.002);
        let decay = (-self.period_s / tau_s).exp();
        let drive = sd * (1.0 - decay * decay).sqrt();
        let mut wander = sd * normal(random);
        let (mut slow, mut level, mut wanted, mut until) = (wander, 0.0, 0.0, 0.0);
        // the desk is supplied by a battery or a separate regulator: it changes too, but more slowly
        let dwell = if works { [60.0, 240.0] } else { [20.0, 90.0] };
        (0..load.len())
            .map(|n| {
                let t = n as f64 * self.period_s;
                if moves && t >= until {
                    wanted = between(random, 2.85, 3.1) - self.supply_v;
                    until = t + log_between(random, dwell[0], dwell[1]);
                    level = if n == 0 { wanted } else { level };
                }
                wander = decay * wander + drive * normal(random);
                slow += (wander - slow) * self.period_s / 2.0;
                // the output capacitor
                level += (wanted - level) * self.period_s / 0.3;
                let sag = if works { self.sag_v * load[n] / 100.0 } else { 0.0 };
                self.supply_v + slow + level - sag
            })
            .collect()
    }
}

impl Setup {
    /// All set-ups: on a bench, on a desk, in a pose rig, on a shaker, on a rate table.
    pub const ALL: [Self; 5] = [Self::Bench, Self::Desk, Self::PoseRig, Self::Shaker, Self::RateTable];

    /// Set-up with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|setup| setup.name() == name)
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bench => "bench",
            Self::Desk => "desk",
            Self::PoseRig => "pose-rig",
            Self::Shaker => "shaker",
            Self::RateTable => "rate-table",
        }
    }

    /// Description in the words of a log's author.
    pub fn words(self) -> &'static str {
        match self {
            Self::Bench => "static on a bench",
            Self::Desk => "static on a desk, the processor works now and then",
            Self::PoseRig => "rig holds a series of poses; still=0 while it moves",
            Self::Shaker => "on a shaker whose level changes",
            Self::RateTable => "on a rate table; ref_* is what the table does",
        }
    }
}
