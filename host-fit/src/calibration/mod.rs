//! How often the diagnosis is right: simulated cases with a known truth, diagnosed, corrected and counted.

mod figures;
mod outcome;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

pub use figures::{Figure, Goal, figures};
pub use outcome::{Outcome, examine};

use crate::effects::Library;
use crate::simulate::{PlanError, suite};

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// A case cannot be simulated.
    #[error("case {case}: {source}")]
    Plan {
        /// Its number.
        case: usize,
        /// Why.
        source: PlanError,
    },
    /// A case cannot be diagnosed.
    #[error("case {case}: {source}")]
    Diagnose {
        /// Its number.
        case: usize,
        /// Why.
        source: Box<crate::diagnose::DiagnoseError>,
    },
}

/// A calibration: what came out of every case, and the figures.
#[derive(Debug, Clone, Serialize)]
pub struct Calibration {
    /// Seed of the suite.
    pub seed: u64,
    /// What came out of every case.
    pub outcomes: Vec<Outcome>,
    /// How often the diagnosis was right.
    pub figures: Vec<Figure>,
}

/// Simulates `count` cases from `seed` and counts how often the diagnosis is right with the effects of `library`. `progress` is told
/// the cases done.
///
/// # Errors
///
/// A case cannot be simulated or diagnosed.
pub fn calibrate(
    seed: u64,
    count: usize,
    library: &Library,
    progress: impl Fn(usize) + Sync,
) -> Result<Calibration, CalibrationError> {
    let plans = suite(seed, count);
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Outcome> = plans
        .par_iter()
        .enumerate()
        .map(|(case, plan)| {
            let outcome = examine(case, plan, library);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            outcome
        })
        .collect::<Result<_, _>>()?;
    Ok(Calibration { seed, figures: figures(&outcomes), outcomes })
}
