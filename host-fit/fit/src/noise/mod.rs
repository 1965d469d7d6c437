//! The noise of an axis at rest: its levels, estimated; the error whitened with them; regression in it (generalised
//! least squares).
//!
//! | file | subject |
//! |---|---|
//! | `blocks` | a recording in block means |
//! | `model` | white, flicker, random walk as a state-space model; whitening |
//! | `gls` | regression on whitened blocks |
//! | `levels` | the levels, estimated together with a regression |
//! | `quiet` | what is known of them before: data sheet, quiet log |

mod blocks;
mod gls;
mod levels;
mod model;
mod prior;

#[cfg(test)]
mod gls_tests;
#[cfg(test)]
mod levels_tests;
#[cfg(test)]
mod noise_tests;

pub use blocks::{Block, Blocks, length_for};
pub use gls::{Gls, dot};
pub use levels::{Fitted, LevelPrior, LogLevels, Regression, UnknownLevels};
pub use model::{GaussMarkov, NoiseLevels};
