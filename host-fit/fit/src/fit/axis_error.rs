//! Why an axis cannot be fitted, and what to do about it.

use fos_core::ModelError;
use fos_data::recording::RecordingError;

use super::FitError;
use super::autoregression::AutoregressionError;
use crate::candidates::{CandidatesError, MAX_CANDIDATES};

/// Why an axis cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    /// A column is not there.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Too little to fit to.
    #[error(
        "{column}: {rows} rows at rest to train on; {needed} are needed for {candidates} candidates\nhelp: a longer log, a larger `train`{}",
        what_fits(", or ", fits)
    )]
    TooShort {
        column: String,
        /// Rows at rest in the training part.
        rows: usize,
        /// Rows needed.
        needed: usize,
        candidates: usize,
        /// Options that the rows are enough for; empty if there are none.
        fits: String,
    },
    /// More than a search can hold.
    #[error(
        "{column}: {candidates} candidates, of which all products are averaged; {MAX_CANDIDATES} is the most that memory is taken for\nhelp: a smaller `max_lag`, `input_lags` or `degree`{}",
        what_fits(", as ", fits)
    )]
    TooMany {
        column: String,
        candidates: usize,
        /// Options that give fewer.
        fits: String,
    },
    /// An accelerometer without a reference, in more than one pose.
    #[error(
        "{column}: the device rests in several orientations, from {:.1} s on with {} and from {:.1} s on with {} m/s²: gravity differs between them, and the difference would be fitted as an error\nhelp: fit one orientation: `train` {train_s}s ends in the first; or mark one in a column `still`; or log the true values in ref_ax_mps2, ref_ay_mps2, ref_az_mps2; gyros are not affected: `axis` gx,gy,gz",
        first.0, force(&first.1), second.0, force(&second.1)
    )]
    TwoPoses {
        column: String,
        /// Since when the first is held, s as stamped, and what the accelerometers show in it, m/s².
        first: (f64, Vec<f64>),
        /// The same of the second.
        second: (f64, Vec<f64>),
        /// Whole seconds at rest to the end of the first.
        train_s: u64,
    },
    /// All values are the same, or half of them and more repeat one that is stuck.
    #[error(
        "{column} repeats one value, {value:?}, in the training part: stuck or not connected\nhelp: leave the axis out with `axis`, or fit on rows in which it measures (`train`)"
    )]
    Constant { column: String, value: f64 },
    /// An input that does not change where it is fitted.
    #[error(
        "{column} is {value:?} in every row that is fitted: nothing can be learnt of what follows it\nhelp: leave it out of `physical` and `input`, or fit on rows in which it changes (`train`)"
    )]
    Steady {
        /// The column of the input.
        column: String,
        value: f64,
    },
    /// An input that has no value where it is fitted.
    #[error(
        "{column} has no value in the rows that are fitted\nhelp: leave it out of `physical` and `input`, or fit on rows in which it is logged (`train`)"
    )]
    NotKnown {
        /// The column of the input.
        column: String,
    },
    /// The candidates do not make a pool.
    #[error("{column}: {source}\nhelp: a smaller `max_lag`, `input_lags` or `degree`")]
    Candidates { column: String, source: CandidatesError },
    /// The search or the final solution.
    #[error(
        "{column}: {source}\nhelp: a longer log at rest without empty cells, a larger `train`, a smaller `max_lag`, or fewer inputs (`physical`, `input`)"
    )]
    Search { column: String, source: FitError },
    /// An autoregression cannot be estimated.
    #[error(
        "{column}: {source}\nhelp: a smaller `max_lag`, a longer log at rest without empty cells, or `method` fos"
    )]
    Autoregression { column: String, source: AutoregressionError },
    /// The model does not follow the rows that it was fitted to.
    #[error(
        "{column}: the model diverges on the rows that it was fitted to: a prediction is {off:.3e} off, and the error lies between {low:.3e} and {high:.3e} there\nhelp: fewer terms (`max_terms`, `degree` 1), a longer log at rest, or remove inputs that hardly change in it (`physical`, `input`)"
    )]
    Diverges {
        column: String,
        /// The largest error of a prediction, in the axis' unit.
        off: f64,
        /// The least error in the fitted rows, in the axis' unit.
        low: f64,
        high: f64,
    },
    /// fos-core refuses the model.
    #[error(
        "{column}: no model for values like these: {source}\nhelp: name the column's unit in the column map, as in {column}=gyro:mdps, and remove rows that are not measurements"
    )]
    Model { column: String, source: ModelError },
}

fn what_fits(joined_by: &str, fits: &str) -> String {
    if fits.is_empty() { String::new() } else { format!("{joined_by}{fits}") }
}

fn force(levels: &[f64]) -> String {
    let levels: Vec<String> = levels.iter().map(|level| format!("{level:.2}")).collect();
    format!("({})", levels.join(", "))
}
