//! Noise of an axis at rest: estimation of its levels, whitening, and regression in it (generalised least squares).
//!
//! | file | subject |
//! |---|---|
//! | `blocks` | a recording in block means |
//! | `model` | white, flicker, random walk as a state-space model; whitening |
//! | `gls` | regression on whitened blocks |
//! | `levels` | the levels, estimated together with a regression |
//! | `prior` | prior of the levels: data sheet, reference log |
//! | `estimate` | white noise, bias instability and random walk from the data alone, with intervals |
//! | `gauss_markov` | white noise and a Gauss-Markov process in place of flicker and random walk |
//! | `filter` | discrete noise for a Kalman filter |
//! | `profile` | minimum and profile intervals of the likelihood |
//! | `information` | how long to record for an accuracy of the levels |
//! | `least` | the least number from which on a condition holds |
//! | `step` | the noise behind the steps of a coarse converter |
//! | `thermal_drift` | the drift with temperature, estimated together with the levels |
//! | `axis` | the same of an axis of a log, with its Allan deviation |

mod axis;
mod blocks;
mod estimate;
mod filter;
mod gauss_markov;
mod gls;
mod information;
mod least;
mod level;
mod levels;
mod model;
mod prior;
mod profile;
mod step;
mod thermal_drift;

#[cfg(test)]
mod estimate_tests;
#[cfg(test)]
mod gls_tests;
#[cfg(test)]
mod levels_tests;
#[cfg(test)]
mod noise_tests;

pub use axis::{AxisNoise, AxisNoiseError, axis_noise};
pub use blocks::{Block, Blocks, length_for, length_with_levels_for};
pub use estimate::{FLICKER_FLOOR, Level, NoiseEstimate, estimate};
pub use filter::{Absent, FilterNoise};
pub use gauss_markov::GaussMarkovNoise;
pub use gls::{Gls, combination, dot};
pub use information::{expected_rise, expected_walk_ratio, log_deviations, seconds_for_walk_within};
pub use least::least_where;
pub use levels::{Fitted, LevelPrior, LogLevels, Regression, UnknownLevels, minimise};
pub use model::{GaussMarkov, NoiseLevels};
pub use thermal_drift::ThermalDrift;
