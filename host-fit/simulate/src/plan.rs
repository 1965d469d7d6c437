//! What to simulate: a plan, and what can be wrong with it.

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::disturbance::Disturbance;
use super::effect::Effect;
use super::part::PARTS;
use super::plant::Plant;
use super::setup::{Path, Setup};
use super::streams;

/// Nominal sample rate of a joint log, Hz.
pub const NOMINAL_RATE_HZ: f64 = 200.0;

/// How long the logs are, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Durations {
    /// Length of the quiet log, s.
    pub baseline_s: f64,
    /// The log to be explained.
    pub field_s: f64,
    /// The log to be corrected.
    pub eval_s: f64,
}

impl Default for Durations {
    fn default() -> Self {
        Self { baseline_s: 600.0, field_s: 1500.0, eval_s: 900.0 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Nothing,
    Single(Level),
    /// Two effects that can be told apart.
    Pair,
    /// One of two effects that this log cannot tell apart.
    Inseparable(Effect, Effect),
    /// Something that no library has.
    Outside,
}

/// How clear an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Of size 10 to 16.
    Weak,
    /// Of size 22 to 45.
    Medium,
    /// Of size 80 to 300.
    Strong,
}

impl Level {
    /// The level nearest to a size.
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
    /// Of every random number.
    pub seed: u64,
    /// Name of the part, as in [`PARTS`].
    pub part: String,
    /// How the unit is used.
    pub setup: Setup,
    /// Course of the covariates.
    pub path: Path,
    /// The axis to be explained.
    pub target: Axis,
    /// What is planted in field and evaluation.
    pub planted: Vec<Plant>,
    /// How long the logs are.
    pub durations: Durations,
    /// What the case is for.
    pub kind: Kind,
    /// What disturbs field and evaluation.
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

    /// Nominal rate of its logs, Hz.
    pub fn nominal_rate_hz(&self) -> f64 {
        match self.disturbance {
            Disturbance::Streams => streams::RATE_HZ,
            _ => NOMINAL_RATE_HZ,
        }
    }
}

/// A plan that cannot be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("there is no part {0:?}; choose from {parts}", parts = PARTS.map(|part| part.name).join(", "))]
    Part(String),
    /// The set-up cannot show the effect on this axis.
    #[error("{effect} does not show on {} in the set-up {}{}", .setup.name(), .target.column(), places(*.effect))]
    Unsuited {
        /// What was to be planted.
        effect: Effect,
        setup: Setup,
        /// The axis that it should show on.
        target: Axis,
    },
    /// The effect is nothing on this log: a parameter out of reach, or a log too short.
    #[error("{effect} with parameter {parameter} makes no error in a field of this length")]
    Nothing {
        /// What was to be planted.
        effect: Effect,
        parameter: f64,
    },
    #[error("a log must last 60 s or more")]
    Short,
    /// A size is not positive, a parameter is no number.
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
