//! Influences on a log other than the effect: knocks, steps, doors, sway, motors, fans, hands; outliers and stuck
//! samples; the part's own digital filter, noise that is not normal, and separate clocks for each sensor.
//!
//! Shapes and strengths are drawn from families as wide as in reality, with sources where they are used; none is fitted
//! to what a diagnosis looks for. Mechanical disturbances are true motion: they show on several axes of both triads, and
//! are added to the measurements of the axes. The size of the planted effect is computed without them, so that the same
//! case can be simulated with and without.

mod character;
mod distribution;
mod filter;
mod handling;
mod impulses;
mod motion;
mod vibration;
mod wild;

use serde::{Deserialize, Serialize};

use super::random::{Random, Stream, random};
use super::setup::Setup;
use super::world::World;

pub(super) use character::Character;
pub use motion::Disturbed;
pub(super) use motion::Motion;
pub(super) use wild::spoil;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Disturbance {
    #[default]
    Clean,
    /// Knocks on the table, 2 to 8 times.
    Knocks,
    Footsteps,
    Doors,
    /// The building sways for 10 to 40 % of the time.
    Sway,
    /// The phone's vibration motor, in bursts.
    Motor,
    /// A fan that starts and stops.
    Fan,
    /// Picked up and put down again, six times at most.
    Handling,
    /// 1 to 50 outliers.
    Spikes,
    /// Stretches of 0.1 to 2 s in which the axis repeats a value.
    Stuck,
    /// The noise of the reference log and the log to explain passes through the part's digital filter.
    Filter,
    /// The noise of all logs is not normal.
    Noise,
    /// No disturbance: accelerometer, gyro and thermometer have separate rates and clocks, and timestamps with jitter.
    Streams,
}

impl Disturbance {
    /// Every disturbance in the order of the variants, with its name and its description.
    const DESCRIBED: [(Self, &str, &str); 13] = [
        (Self::Clean, "clean", "nothing but noise and effects"),
        (Self::Knocks, "knocks", "the table is knocked 2 to 8 times"),
        (Self::Footsteps, "footsteps", "somebody walks by"),
        (Self::Doors, "doors", "doors slam"),
        (Self::Sway, "sway", "the building sways"),
        (Self::Motor, "motor", "a vibration motor in bursts"),
        (Self::Fan, "fan", "a fan starts and stops"),
        (Self::Handling, "handling", "picked up and put down again"),
        (Self::Spikes, "spikes", "1 to 50 samples far off"),
        (Self::Stuck, "stuck", "stuck for 0.1 to 2 s"),
        (Self::Filter, "filter", "noise through the part's digital filter"),
        (Self::Noise, "noise", "noise that is not normal: tails, bounds, coarse steps"),
        (Self::Streams, "streams", "accelerometer at half of the gyro's rate, on a separate clock"),
    ];

    /// All disturbances, the clean log first.
    pub const ALL: [Self; Self::DESCRIBED.len()] = {
        let mut all = [Self::Clean; Self::DESCRIBED.len()];
        let mut at = 0;
        // terminates: `at` grows in each iteration
        while at < all.len() {
            all[at] = Self::DESCRIBED[at].0;
            at += 1;
        }
        all
    };

    /// Disturbance with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|disturbance| disturbance.name() == name)
    }

    /// Returns true if a set-up can be disturbed in this way: nobody picks up a device in a rig whose motion is logged.
    pub fn suits(self, setup: Setup) -> bool {
        self != Self::Handling || matches!(setup, Setup::Bench | Setup::Desk)
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        Self::DESCRIBED[self as usize].1
    }

    /// Description for a table.
    pub fn words(self) -> &'static str {
        Self::DESCRIBED[self as usize].2
    }
}

/// Motion that a disturbance adds to log number `log` of a case.
pub(super) fn motion(disturbance: Disturbance, world: &World, (seed, log): (u64, u64)) -> Motion {
    let random: &mut Random = &mut random(seed, Stream::Disturbance(log));
    let mut motion = match disturbance {
        Disturbance::Knocks => impulses::knocks(world, random),
        Disturbance::Footsteps => impulses::footsteps(world, random),
        Disturbance::Doors => impulses::doors(world, random),
        Disturbance::Sway => vibration::sway(world, random),
        Disturbance::Motor => vibration::motor(world, random),
        Disturbance::Fan => vibration::fan(world, random),
        Disturbance::Handling => handling::handling(world, random),
        _ => Motion::default(),
    };
    motion.when.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    motion
}
