//! How often the diagnosis is right: simulated cases with a known truth, diagnosed, corrected and counted.

mod cases;
mod error;
mod figures;
mod kept;
mod outcome;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

pub use cases::Cases;
pub use error::CalibrationError;
pub use figures::{Goal, Statistic, figures, in_world};
pub use kept::KeptOutcomes;
pub use outcome::{Outcome, examine};

use fos_diagnose::effects::Library;
use fos_simulate::{Disturbance, suite_in};

/// A calibration: what came out of every case, and the figures.
#[derive(Debug, Clone, Serialize)]
pub struct Calibration {
    /// Seed of the suite.
    pub seed: u64,
    /// What disturbs its logs.
    pub world: Disturbance,
    /// What came out of every case.
    pub outcomes: Vec<Outcome>,
    /// How often the diagnosis was right.
    pub figures: Vec<Statistic>,
}

/// Simulates the cases, and counts how often the diagnosis is right with the effects of `library`. What is `kept` already
/// is not computed again, and what comes out is kept. `progress` is told the cases done.
///
/// # Errors
///
/// A case cannot be simulated or diagnosed, or its outcome cannot be kept.
pub fn calibrate(
    cases: Cases,
    library: &Library,
    kept: Option<&KeptOutcomes>,
    progress: impl Fn(usize) + Sync,
) -> Result<Calibration, CalibrationError> {
    let Cases { seed, count, world, every_axis } = cases;
    let plans = suite_in(seed, count, world);
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Outcome> = plans
        .par_iter()
        .enumerate()
        .map(|(case, plan)| {
            let outcome = match kept.and_then(|kept| kept.of(case)) {
                Some(known) => known,
                None => {
                    let outcome = examine(case, plan, every_axis, library)?;
                    kept.map(|kept| kept.add(&outcome)).transpose()?;
                    outcome
                }
            };
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ok(outcome)
        })
        .collect::<Result<_, CalibrationError>>()?;
    Ok(Calibration { seed, world, figures: figures(&outcomes), outcomes })
}
