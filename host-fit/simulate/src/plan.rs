//! Plan of a simulation, and its errors.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::disturbance::Disturbance;
use super::effect::Effect;
use super::part::PARTS;
use super::plant::Plant;
use super::setup::{Path, Setup};
use super::streams;

/// Nominal sampling rate of a log with a single clock, Hz.
pub const NOMINAL_RATE_HZ: f64 = 200.0;

/// Durations of the logs, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Durations {
    pub reference_s: f64,
    pub log_s: f64,
    pub evaluation_s: f64,
}

impl Default for Durations {
    fn default() -> Self {
        Self { reference_s: 600.0, log_s: 1500.0, evaluation_s: 900.0 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Nothing,
    Single(Level),
    /// Two distinguishable effects.
    Pair,
    /// One of two effects that are indistinguishable from this log.
    Inseparable(Effect, Effect),
    /// An effect outside the library.
    Outside,
}

/// Level of the size of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Size 10 to 16.
    Weak,
    /// Size 22 to 45.
    Medium,
    /// Size 80 to 300.
    Strong,
}

impl Level {
    /// Level nearest to a size.
    pub fn of(size: f64) -> Self {
        if size < 18.0 {
            Self::Weak
        } else if size < 60.0 {
            Self::Medium
        } else {
            Self::Strong
        }
    }

    /// Smallest and largest size.
    pub fn sizes(self) -> [f64; 2] {
        match self {
            Self::Weak => [10.0, 16.0],
            Self::Medium => [22.0, 45.0],
            Self::Strong => [80.0, 300.0],
        }
    }
}

/// A case to simulate. The same plan gives the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CasePlan {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Name of the part, as in [`PARTS`].
    pub part: String,
    pub setup: Setup,
    /// Course of the covariates.
    pub path: Path,
    /// Axis to be explained.
    pub target: Axis,
    /// Effects planted in the log to explain and the evaluation log.
    pub planted: Vec<Plant>,
    /// Durations of the logs.
    pub durations: Durations,
    /// Purpose of the case.
    pub kind: Kind,
    /// Disturbance of the log to explain and the evaluation log.
    #[serde(default)]
    pub disturbance: Disturbance,
}

impl CasePlan {
    /// A plan with nothing planted.
    pub fn new(seed: u64, part: &str, setup: Setup, target: Axis) -> Self {
        Self {
            seed,
            part: part.to_owned(),
            setup,
            path: Path::Drawn,
            target,
            planted: Vec::new(),
            durations: Durations::default(),
            kind: Kind::Nothing,
            disturbance: Disturbance::Clean,
        }
    }

    /// Plants these effects in addition; their number and sizes determine the kind of the case.
    pub fn plant(&mut self, plants: impl IntoIterator<Item = Plant>) {
        self.planted.extend(plants);
        self.kind = match self.planted.as_slice() {
            [] => Kind::Nothing,
            planted if planted.iter().any(|plant| plant.effect.is_outside()) => Kind::Outside,
            [only] => Kind::Single(Level::of(only.size)),
            _ => Kind::Pair,
        };
    }

    /// Nominal sampling rate of its logs, Hz.
    pub fn nominal_rate_hz(&self) -> f64 {
        match self.disturbance {
            Disturbance::Streams => streams::RATE_HZ,
            _ => NOMINAL_RATE_HZ,
        }
    }
}

/// Reason why a plan cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("there is no part {0:?}; choose from {parts}", parts = PARTS.map(|part| part.name).join(", "))]
    Part(String),
    #[error("{effect} does not show on {} in the set-up {}{}", .setup.name(), .target.column(), places(*.effect))]
    Unsuited { effect: Effect, setup: Setup, target: Axis },
    /// The effect makes no error in this log: a parameter out of reach, or a log too short.
    #[error("{effect} with parameter {parameter} makes no error in a field of this length")]
    Nothing { effect: Effect, parameter: f64 },
    #[error("a log must last 60 s or more")]
    Short,
    /// A size that is not positive, or a parameter that is no number.
    #[error("size and parameter of {0} must be positive numbers")]
    Size(Effect),
}

fn places(effect: Effect) -> String {
    let all = Setup::ALL.iter().flat_map(|setup| [(*setup, Axis::Ax), (*setup, Axis::Gx)]);
    let shown = all.filter(|(setup, axis)| effect.suits(*setup, *axis)).map(|(setup, axis)| {
        let axis = if axis.is_gyro() { "a gyro" } else { "an accelerometer" };
        format!("{axis} in the set-up {}", setup.name())
    });
    format!("; choose from {}", shown.collect::<Vec<_>>().join(", "))
}
