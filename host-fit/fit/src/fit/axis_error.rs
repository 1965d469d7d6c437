//! Reasons why an axis cannot be fitted, with remedies.

use fos_core::ModelError;
use fos_data::recording::RecordingError;

use super::FitError;
use super::autoregression::AutoregressionError;
use crate::candidates::{CandidatesError, MAX_CANDIDATES};

/// Reason why an axis cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum AxisError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{column}: {rows} rows at rest to train on; {needed} are needed for {candidates} candidates\nhelp: a longer log, a larger `train`{}",
        suggestion(", or ", fits)
    )]
    TooShort {
        column: String,
        rows: usize,
        needed: usize,
        candidates: usize,
        /// Options for which the rows suffice; empty if there are none.
        fits: String,
    },
    #[error(
        "{column}: {candidates} candidates, of which all products are averaged; {MAX_CANDIDATES} is the most that memory is taken for\nhelp: a smaller `max_lag`, `input_lags` or `degree`{}",
        suggestion(", as ", fits)
    )]
    TooMany { column: String, candidates: usize, fits: String },
    #[error(
        "{column}: the device rests in several orientations, from {:.1} s on with {} and from {:.1} s on with {} m/s²: gravity differs between them, and the difference would be fitted as an error\nhelp: fit one orientation: `train` {train_s}s ends in the first; or mark one in a column `still`; or log the true values in ref_ax_mps2, ref_ay_mps2, ref_az_mps2; gyros are not affected: `axis` gx,gy,gz",
        first.0, force(&first.1), second.0, force(&second.1)
    )]
    TwoPoses {
        column: String,
        /// Begin of the first orientation as timestamp, s, and the specific force in it, m/s².
        first: (f64, Vec<f64>),
        /// Begin and specific force of the second orientation.
        second: (f64, Vec<f64>),
        /// Whole seconds at rest until the end of the first orientation.
        train_s: u64,
    },
    #[error(
        "{column}: the device rests in {poses} orientations, each with its own constant; at most {most} can be fitted together with physical terms\nhelp: a smaller `train`, which contains fewer of them; or log the true values in ref_ax_mps2, ref_ay_mps2, ref_az_mps2; or fit without `physical`; gyros are not affected: `axis` gx,gy,gz"
    )]
    TooManyPoses { column: String, poses: usize, most: usize },
    /// All values are equal, or at least half of them repeat one value.
    #[error(
        "{column} repeats one value, {value:?}, in the training part: stuck or not connected\nhelp: leave the axis out with `axis`, or fit on rows in which it measures (`train`)"
    )]
    Constant { column: String, value: f64 },
    #[error(
        "{column} is {value:?} in every row that is fitted: nothing can be learnt of what follows it\nhelp: leave it out of `physical` and `input`, or fit on rows in which it changes (`train`)"
    )]
    Steady { column: String, value: f64 },
    #[error(
        "{column} has no value in the rows that are fitted\nhelp: leave it out of `physical` and `input`, or fit on rows in which it is logged (`train`)"
    )]
    NotKnown { column: String },
    #[error("{column}: {source}\nhelp: a smaller `max_lag`, `input_lags` or `degree`")]
    Candidates { column: String, source: CandidatesError },
    #[error(
        "{column}: {source}\nhelp: a longer log at rest without empty cells, a larger `train`, a smaller `max_lag`, or fewer inputs (`physical`, `input`)"
    )]
    Search { column: String, source: FitError },
    #[error(
        "{column}: {source}\nhelp: a smaller `max_lag`, a longer log at rest without empty cells, or `method` fos"
    )]
    Autoregression { column: String, source: AutoregressionError },
    #[error(
        "{column}: the model diverges on the rows that it was fitted to: a prediction is {off:.3e} off, and the error lies between {low:.3e} and {high:.3e} there\nhelp: fewer terms (`max_terms`, `degree` 1), a longer log at rest, or remove inputs that hardly change in it (`physical`, `input`)"
    )]
    Diverges {
        column: String,
        /// These three in the axis' unit.
        off: f64,
        low: f64,
        high: f64,
    },
    #[error(
        "{column}: no model for values like these: {source}\nhelp: name the column's unit in the column map, as in {column}=gyro:mdps, and remove rows that are not measurements"
    )]
    Model { column: String, source: ModelError },
}

fn suggestion(joined_by: &str, fits: &str) -> String {
    if fits.is_empty() { String::new() } else { format!("{joined_by}{fits}") }
}

fn force(levels: &[f64]) -> String {
    let levels: Vec<String> = levels.iter().map(|level| format!("{level:.2}")).collect();
    format!("({})", levels.join(", "))
}
