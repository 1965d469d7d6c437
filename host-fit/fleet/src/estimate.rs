//! Joint estimate of the coefficients of an axis of a unit, with their covariance.

use fos_data::column::Column;
use fos_data::disturbance;
use fos_data::recording::{Recording, RecordingError};
use fos_data::unit::Unit;
use fos_diagnose::detect::ErrorInBlocks;
use fos_diagnose::effects::{Inputs, Regressor};
use fos_fit::noise::{LevelPrior, NoiseLevels, Regression};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::coefficient::LEAST_ERROR;
use crate::information::{Information, is_square, matrix_of};

/// Reference temperature, °C; the bias is that at this temperature.
pub const REFERENCE_C: f64 = 25.0;

/// Name of the constant coefficient.
pub const BIAS: &str = "bias";

/// Fewest blocks from which coefficients and noise are estimated.
const FEWEST_BLOCKS: usize = 40;

/// Standard deviation of the logarithm of a noise level between units of a part (0.3 is about one third).
const BETWEEN_UNITS: f64 = 0.3;

/// Coefficients and their covariance, in the axis' SI unit per unit of the regressor: rad/s or m/s² per K for `temp_c`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// [`BIAS`] and regressors, as requested; only those identifiable from the log.
    pub names: Vec<String>,
    pub values: Vec<f64>,
    /// Covariance by rows, from white noise, flicker and random walk.
    pub covariance: Vec<Vec<f64>>,
}

/// An estimate in the coefficients and scales of a population.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// Information about the coefficients of the population.
    pub(crate) information: Information,
    /// Scaled values; 0 for coefficients missing from the estimate.
    pub(crate) values: DVector<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisEstimate {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// Coefficients identifiable from the log.
    pub coefficients: Estimate,
    /// Noise levels, estimated with the coefficients.
    pub noise: NoiseLevels,
    /// Time at rest used for the estimate, s.
    pub seconds: f64,
}

/// An axis cannot be estimated.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{regressor:?} is no regressor: {reason}\nhelp: as in the files of effects: temp_c, temp_c * temp_c, temp_c:lowpass(60)"
    )]
    Regressor { regressor: String, reason: String },
    /// A regressor occurs twice, so its correction would be subtracted twice.
    #[error("the regressor {0:?} is given twice\nhelp: give each regressor once")]
    DuplicateRegressor(String),
    #[error(
        "the regressor {BIAS:?} has the name of the constant coefficient\nhelp: rename the column in the log or in the column map"
    )]
    ReservedRegressor,
    #[error(
        "{column}: {seconds:.1} s at rest in stretches long enough for means over {block_s:.1} s; its coefficients need at least {needed:.0} s\nhelp: record a longer log of the device lying still, without interruptions"
    )]
    TooShort {
        column: String,
        /// Time at rest in blocks with enough samples, s.
        seconds: f64,
        block_s: f64,
        needed: f64,
    },
}

impl AxisEstimate {
    /// All coefficients and noise levels are present and finite.
    pub(crate) fn is_complete(&self) -> bool {
        let NoiseLevels { white, flicker, walk, .. } = self.noise;
        let levels = [white, flicker, walk, self.seconds];
        self.coefficients.is_complete() && levels.iter().all(|level| level.is_finite())
    }
}

impl Estimate {
    /// Every coefficient has its value and covariances, all finite, and no variance is negative: types do not ensure this for a file
    /// that was read.
    pub(crate) fn is_complete(&self) -> bool {
        let n = self.names.len();
        self.values.len() == n
            && is_square(&self.covariance, n)
            && self.values.iter().chain(self.covariance.iter().flatten()).all(|value| value.is_finite())
            && (0..n).all(|place| self.covariance[place][place] >= 0.0)
    }

    /// Index of a coefficient, if it is identifiable from the log.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Standard error of a coefficient, in its SI unit.
    pub fn standard_error(&self, name: &str) -> Option<f64> {
        self.place(name).map(|place| self.covariance[place][place].sqrt())
    }

    /// Information about the coefficients `names`, each divided by its scale.
    pub(crate) fn measured(&self, names: &[String], scale: &[f64]) -> Measured {
        let n = names.len();
        let places: Vec<(usize, usize)> =
            names.iter().enumerate().filter_map(|(place, name)| Some((place, self.place(name)?))).collect();
        let own = matrix_of(&self.covariance);
        let covariance = DMatrix::from_fn(places.len(), places.len(), |row, column| {
            let (row, column) = (places[row], places[column]);
            own[(row.1, column.1)] / (scale[row.0] * scale[column.0])
        });
        let mut values = DVector::zeros(n);
        for (place, of_own) in &places {
            values[*place] = self.values[*of_own] / scale[*place];
        }
        // An estimate without an error, from constant values, still gets a finite information.
        let mut covariance = covariance;
        for index in 0..places.len() {
            covariance[(index, index)] += LEAST_ERROR;
        }
        let inverse = covariance.cholesky().map(|factor| factor.inverse());
        let mut information = DMatrix::zeros(n, n);
        for (row, (place, _)) in places.iter().enumerate() {
            for (column, (other, _)) in places.iter().enumerate() {
                information[(*place, *other)] =
                    inverse.as_ref().map_or(0.0, |inverse| inverse[(row, column)]);
            }
        }
        Measured { information: Information { weighted: &information * &values, information }, values }
    }
}

/// Parses regressors and checks that each has a coefficient of its own.
pub fn check_regressors(regressors: &[String]) -> Result<Vec<Regressor>, EstimateError> {
    let mut parsed = Vec::new();
    for text in regressors {
        let unknown = |reason| EstimateError::Regressor { regressor: text.clone(), reason };
        let regressor = Regressor::parse(text).map_err(unknown)?;
        if text == BIAS {
            return Err(EstimateError::ReservedRegressor);
        }
        if parsed.contains(&regressor) {
            return Err(EstimateError::DuplicateRegressor(text.clone()));
        }
        parsed.push(regressor);
    }
    Ok(parsed)
}

/// Estimates the bias and the coefficients of `regressors` of an axis (a column) from the rows at rest of a log in one or several
/// orientations.
///
/// Uses generalised least squares on block means, with the noise estimated jointly. `noise`, the levels of the part if known, serves as
/// prior: a log of minutes hardly shows slow drift, and its intervals would be too narrow without it. An accelerometer without reference
/// values (`ref_…`) has no bias, because it is indistinguishable from gravity at rest. Regressors that do not vary in the log are excluded.
///
/// # Errors
///
/// A column is missing, the regressors are refused by [`check_regressors`], the time at rest is too short, or the device moves throughout
/// the log.
pub fn estimate(
    recording: &Recording,
    column: &str,
    regressors: &[String],
    noise: Option<&NoiseLevels>,
) -> Result<AxisEstimate, EstimateError> {
    disturbance::check(recording)?;
    let at_rest = disturbance::marked(recording).0;
    let log = from_reference(&at_rest);
    let reduced = ErrorInBlocks::of(&log, column)?;
    let blocks = &reduced.blocks;
    let seconds = blocks.samples() as f64 * blocks.period_s;
    if blocks.beyond_levels() < FEWEST_BLOCKS {
        let (column, block_s) = (column.to_owned(), blocks.length_s);
        let (seconds, needed) = (blocks.beyond_levels() as f64 * block_s, FEWEST_BLOCKS as f64 * block_s);
        return Err(EstimateError::TooShort { column, seconds, block_s, needed });
    }
    let has_bias = log.is_bias_known(column);
    let inputs = Inputs::new(&log);
    let mut columns = vec![vec![1.0; blocks.len()]];
    for regressor in &check_regressors(regressors)? {
        columns.push(blocks.means(&inputs.regressor(regressor)?));
    }
    // Centred, so that a large offset does not cost digits of the noise.
    let mean = reduced.means.iter().sum::<f64>() / reduced.means.len() as f64;
    let y: Vec<f64> = reduced.means.iter().map(|value| value - mean).collect();
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let prior = match noise {
        Some(levels) => LevelPrior::independent(levels.logs(), [BETWEEN_UNITS; 3]),
        None => LevelPrior::of_log(blocks, &y),
    };
    let regression = Regression { blocks, y: &y, regressors: &columns, prior: &prior };
    let fitted = regression.fit(NoiseLevels::from_logs(&prior.mean));

    let (all, covariance) = (fitted.gls.coefficients(), fitted.gls.covariance());
    let named = |index: usize| match index.checked_sub(1) {
        Some(of_regressor) => Some((regressors[of_regressor].clone(), all[index])),
        None => has_bias.then(|| (BIAS.to_owned(), all[index] + mean)),
    };
    let named_coefficients: Vec<(usize, (String, f64))> = fitted
        .gls
        .kept
        .iter()
        .enumerate()
        .filter_map(|(place, index)| Some((place, named(*index)?)))
        .collect();
    let covariance = named_coefficients
        .iter()
        .map(|(row, _)| named_coefficients.iter().map(|(other, _)| covariance[(*row, *other)]).collect())
        .collect();
    let (names, values) = named_coefficients.into_iter().map(|(_, named)| named).unzip();
    Ok(AxisEstimate {
        column: column.to_owned(),
        coefficients: Estimate { names, values, covariance },
        noise: fitted.levels,
        seconds,
    })
}

/// The log with temperatures relative to [`REFERENCE_C`], so that the bias lies within the measured range, or near it.
pub(crate) fn from_reference(recording: &Recording) -> Recording {
    let mut log = recording.clone();
    let temperatures: Vec<(String, Vec<f64>)> = recording
        .channels()
        .iter()
        .filter(|channel| Column::named(&channel.name).unit() == Unit::Celsius)
        .map(|channel| {
            (channel.name.clone(), channel.values.iter().map(|value| value - REFERENCE_C).collect())
        })
        .collect();
    for (name, values) in temperatures {
        log = log.with_values(&name, values);
    }
    log
}
