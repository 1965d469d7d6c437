//! Measures the accuracy of the diagnosis on simulated cases with known truth.

mod cases;
mod error;
mod figures;
mod outcome;
mod stored_outcomes;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

pub use cases::Cases;
pub use error::CalibrationError;
pub use figures::{Goal, Statistic, figures, in_world};
pub use outcome::{Outcome, examine};
pub use stored_outcomes::StoredOutcomes;

use fos_diagnose::effects::Library;
use fos_simulate::{Disturbance, suite_in};

/// Outcomes of all cases, and their statistics.
#[derive(Debug, Clone, Serialize)]
pub struct Calibration {
    /// Seed of the suite.
    pub seed: u64,
    /// Disturbance of the logs.
    pub world: Disturbance,
    /// Outcome of every case.
    pub outcomes: Vec<Outcome>,
    /// Accuracy of the diagnosis.
    pub figures: Vec<Statistic>,
}

/// Simulates and diagnoses the cases with the effects of `library`. Outcomes in `stored` are reused, and new ones are added
/// to it. `progress` receives the number of finished cases.
pub fn calibrate(
    cases: Cases,
    library: &Library,
    stored: Option<&StoredOutcomes>,
    progress: impl Fn(usize) + Sync,
) -> Result<Calibration, CalibrationError> {
    let Cases { seed, count, world, every_axis } = cases;
    let plans = suite_in(seed, count, world);
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Outcome> = plans
        .par_iter()
        .enumerate()
        .map(|(case, plan)| {
            let outcome = match stored.and_then(|stored| stored.of(case)) {
                Some(known) => known,
                None => {
                    let outcome = examine(case, plan, every_axis, library)?;
                    stored.map(|stored| stored.add(&outcome)).transpose()?;
                    outcome
                }
            };
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ok(outcome)
        })
        .collect::<Result<_, CalibrationError>>()?;
    Ok(Calibration { seed, world, figures: figures(&outcomes), outcomes })
}
