//! The coefficients of a unit's axis, estimated together, with their covariance.

use fos_data::column::Column;
use fos_data::recording::{Recording, RecordingError};
use fos_data::unit::Unit;
use fos_data::{disturbance, pose};
use fos_diagnose::detect::ErrorInBlocks;
use fos_diagnose::effects::{Inputs, Regressor};
use fos_fit::noise::{LevelPrior, NoiseLevels, Regression};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::coefficient::LEAST_ERROR;
use crate::known::{Known, is_square, matrix_of};

/// Temperatures count from here, °C: a bias is that at it.
pub const REFERENCE_C: f64 = 25.0;

/// The name of the constant.
pub const BIAS: &str = "bias";

/// Fewest blocks that tell coefficients and noise.
const FEWEST_BLOCKS: usize = 40;

/// Standard deviation of the logarithm of a noise level between units of a part: a third.
const BETWEEN_UNITS: f64 = 0.3;

/// Coefficients and their covariance, in SI units per unit of the regressor: rad/s or m/s² per K for `temp_c`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// [`BIAS`], or the regressor as it is asked for; those alone that the log tells.
    pub names: Vec<String>,
    pub values: Vec<f64>,
    /// Their covariance, row by row: noise of the estimate, white, flicker and random walk.
    pub covariance: Vec<Vec<f64>>,
}

/// An estimate as a population sees it.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// What it says of the population's coefficients.
    pub(crate) known: Known,
    /// The values; 0 of what it does not tell.
    pub(crate) values: DVector<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisEstimate {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// What its log tells of the coefficients.
    pub coefficients: Estimate,
    /// The noise that goes with them.
    pub noise: NoiseLevels,
    /// Time that it is of, s.
    pub seconds: f64,
}

/// Why an axis cannot be estimated.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A regressor cannot be read.
    #[error(
        "{regressor:?} is no regressor: {reason}\nhelp: as in the files of effects: temp_c, temp_c * temp_c, temp_c:lowpass(60)"
    )]
    Regressor { regressor: String, reason: String },
    #[error(
        "{column}: {seconds:.1} s at rest in stretches long enough for means over {block_s:.1} s; its coefficients need at least {needed:.0} s\nhelp: record a longer log of the device lying still, without interruptions"
    )]
    TooShort {
        column: String,
        /// Time at rest in blocks with enough samples, s.
        seconds: f64,
        /// Length of a block, s.
        block_s: f64,
        /// Time needed, s.
        needed: f64,
    },
}

impl AxisEstimate {
    /// Its coefficients are whole, and its noise levels finite.
    pub(crate) fn is_whole(&self) -> bool {
        let NoiseLevels { white, flicker, walk, .. } = self.noise;
        let levels = [white, flicker, walk, self.seconds];
        self.coefficients.is_whole() && levels.iter().all(|level| level.is_finite())
    }
}

impl Estimate {
    /// Every coefficient has its value and its covariances, all finite, and no variance is negative: of what was read that is not said by its type.
    pub(crate) fn is_whole(&self) -> bool {
        let n = self.names.len();
        self.values.len() == n
            && is_square(&self.covariance, n)
            && self.values.iter().chain(self.covariance.iter().flatten()).all(|value| value.is_finite())
            && (0..n).all(|place| self.covariance[place][place] >= 0.0)
    }

    /// The place of a coefficient, if the log tells it.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Standard error of a coefficient.
    pub fn standard_error(&self, name: &str) -> Option<f64> {
        self.place(name).map(|place| self.covariance[place][place].sqrt())
    }

    /// What it says of `names`, each divided by its scale.
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
        // an estimate without an error, of values that never change, is exact to a share of what values vary by
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
        Measured { known: Known { weighted: &information * &values, information }, values }
    }
}

/// The coefficients of `regressors` on an axis (a column), beside its bias, from the rows at rest of a log in one or several poses.
///
/// Generalised least squares in block means, the noise estimated with them; about `noise`, where that of the part is known: a log of
/// minutes tells hardly anything of what wanders slowly, and would be surer of its coefficients than it can be. An accelerometer without
/// true values (`ref_…`) has no bias: at rest it shows gravity beside it. A regressor that the log does not tell, because nothing of it
/// changes, is left out.
///
/// # Errors
///
/// A column is missing, a regressor cannot be read, too little is at rest, or the device moves all along.
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
    let has_bias = !pose::has_unknown_level(column, &log.error_series(column)?.reference);
    let inputs = Inputs::new(&log);
    let mut columns = vec![vec![1.0; blocks.len()]];
    for text in regressors {
        let unknown = |reason| EstimateError::Regressor { regressor: text.clone(), reason };
        let regressor = Regressor::parse(text).map_err(unknown)?;
        columns.push(blocks.means(&inputs.regressor(&regressor)?));
    }
    // what is far from zero would leave fewer digits to the noise
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
    let told: Vec<(usize, (String, f64))> = fitted
        .gls
        .kept
        .iter()
        .enumerate()
        .filter_map(|(place, index)| Some((place, named(*index)?)))
        .collect();
    let covariance = told
        .iter()
        .map(|(row, _)| told.iter().map(|(other, _)| covariance[(*row, *other)]).collect())
        .collect();
    let (names, values) = told.into_iter().map(|(_, named)| named).unzip();
    Ok(AxisEstimate {
        column: column.to_owned(),
        coefficients: Estimate { names, values, covariance },
        noise: fitted.levels,
        seconds,
    })
}

/// The log with temperatures from [`REFERENCE_C`] on: a bias is then one that was measured, or nearly.
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
