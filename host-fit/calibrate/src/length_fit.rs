//! Estimation of a triad from vectors of known length: gravity at rest, the rate of a turntable.

use nalgebra::{DMatrix, DVector};

use crate::least_squares::{
    CONVERGED, Linearised, OUTLIER_CHANCE, covariance, excess_variance, leverages, minimise, student,
};
use crate::triad::TriadModel;

/// Most rounds of weights: they depend on the residuals, which depend on them.
const MAX_ROUNDS: usize = 30;

/// Relative change of the variances at which the rounds end: 0.1 % of an interval.
const SAME_WEIGHTS: f64 = 2e-3;

/// Scatter that the first round assumes, relative to the length: 1 mg at 1 g. A larger one would give the values known before the
/// fit more weight than the vectors, and the rounds would not leave them.
const FIRST_SCATTER: f64 = 1e-3;

/// Mean of the raw values over a rest or plateau.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vector {
    pub(crate) raw: [f64; 3],
    /// Temperature above the reference, K.
    pub(crate) kelvin: f64,
    /// True length, m/s² or rad/s.
    pub(crate) length: f64,
    /// Variance of the measured length by the noise of the samples, (m/s²)² or (rad/s)².
    pub(crate) variance: f64,
}

/// A parameter known before the fit: its index, value and standard deviation.
pub(crate) type Known = (usize, f64, f64);

/// The fitted triad.
pub(crate) struct LengthFit {
    pub(crate) model: TriadModel,
    /// Covariance of the estimated parameters, in the order of [`TriadModel::parameters`], scaled by the residuals.
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) degrees_of_freedom: f64,
    /// Measured − true length of each vector, m/s² or rad/s.
    pub(crate) residuals: Vec<f64>,
    /// Standard deviation of each residual before the fit: noise and scatter from rest to rest.
    pub(crate) deviations: Vec<f64>,
    /// The same divided by their standard deviation after the fit (internally studentised).
    pub(crate) studentised: Vec<f64>,
    /// Variance from rest to rest beyond the noise of the samples.
    pub(crate) excess: f64,
    /// Whitened Jacobian of the vectors, without rows of known parameters.
    pub(crate) jacobian: DMatrix<f64>,
    pub(crate) iterations: usize,
}

impl LengthFit {
    /// Vectors whose residual is improbably large against the others, the worst first: externally studentised residuals beyond
    /// Student's t at a chance of [`OUTLIER_CHANCE`] for the whole log (Cook and Weisberg 1982, section 2.2.2). None with fewer
    /// degrees of freedom than `fewest`.
    pub(crate) fn outlying(&self, fewest: f64) -> Vec<(usize, f64)> {
        let degrees = self.degrees_of_freedom;
        if degrees < fewest {
            return Vec::new();
        }
        let limit = student(1.0 - OUTLIER_CHANCE / self.studentised.len() as f64, degrees - 1.0);
        let external = |r: &f64| r.abs() * ((degrees - 1.0) / (degrees - r * r).max(1e-9)).sqrt();
        let sizes = self.studentised.iter().map(external).enumerate();
        let mut found: Vec<(usize, f64)> = sizes.filter(|(_, size)| *size > limit).collect();
        found.sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
        found
    }
}

/// Fits the first `n` parameters to `vectors`, from `start`. Requires more rows than parameters.
pub(crate) fn fit(vectors: &[Vector], start: &TriadModel, n: usize, known: &[Known]) -> Option<LengthFit> {
    let most_degrees = vectors.len() as f64 - n as f64 + known.len() as f64;
    let mut degrees_of_freedom = most_degrees;
    let mut parameters = DVector::from_column_slice(&start.parameters()[..n]);
    let noise: Vec<f64> = vectors.iter().map(|v| v.variance).collect();
    let model_at = |free_values: &DVector<f64>| {
        let mut all = start.parameters();
        all[..n].copy_from_slice(free_values.as_slice());
        TriadModel::of_parameters(&all, start.reference_c)
    };
    let mut variances: Vec<f64> =
        vectors.iter().map(|v| v.variance + (FIRST_SCATTER * v.length).powi(2)).collect();
    let mut excess = 0.0;
    let mut iterations = 0;
    let mut minimum = None;
    for _ in 0..MAX_ROUNDS {
        let found = minimise(parameters.clone(), CONVERGED, |free_values| {
            linearise(vectors, &variances, &model_at(free_values), free_values, known)
        })?;
        iterations += found.iterations;
        parameters.copy_from(&found.parameters);
        let model = model_at(&parameters);
        let residuals: Vec<f64> =
            vectors.iter().map(|v| model.length(&v.raw, v.kelvin).0 - v.length).collect();
        if let Some(unscaled) = covariance(&found.at.jacobian) {
            // Knowledge from before the fit adds a part of a degree of freedom, or none.
            let leverage = leverages(&found.at.jacobian, &unscaled);
            let taken: f64 = leverage.iter().take(vectors.len()).sum();
            let least = (vectors.len() as f64 - n as f64).max(0.0);
            degrees_of_freedom = (vectors.len() as f64 - taken).clamp(least, least.max(most_degrees));
        }
        minimum = Some((found, variances.clone()));
        excess = excess_variance(&residuals, &noise, degrees_of_freedom);
        // equal weights where neither noise nor residual exist
        let next: Vec<f64> = noise.iter().map(|v| (v + excess).max(1e-18)).collect();
        let change = next.iter().zip(&variances).map(|(new, old)| (new / old - 1.0).abs());
        let is_done = change.fold(0.0, f64::max) < SAME_WEIGHTS;
        variances = next;
        if is_done {
            break;
        }
    }
    let (minimum, variances) = minimum?;
    let model = model_at(&parameters);
    let residuals: Vec<f64> = vectors.iter().map(|v| model.length(&v.raw, v.kelvin).0 - v.length).collect();
    let unscaled = covariance(&minimum.at.jacobian)?;
    let squares = minimum.at.residuals.rows(0, vectors.len()).norm_squared();
    let scale = if degrees_of_freedom > 0.0 { squares / degrees_of_freedom } else { 1.0 };
    // residuals below the noise of the samples are luck of few rests, not accuracy
    let scale = if noise.iter().all(|v| *v > 0.0) { scale.max(1.0) } else { scale };
    let leverage = leverages(&minimum.at.jacobian, &unscaled);
    let studentised = minimum.at.residuals.iter().zip(&leverage).take(vectors.len());
    let studentised =
        studentised.map(|(r, h)| r / (scale * (1.0 - h).max(1e-9)).sqrt().max(f64::MIN_POSITIVE)).collect();
    Some(LengthFit {
        model,
        covariance: unscaled * scale,
        degrees_of_freedom,
        residuals,
        deviations: variances.iter().map(|v| (v * scale).sqrt()).collect(),
        studentised,
        excess,
        jacobian: minimum.at.jacobian.rows(0, vectors.len()).into_owned(),
        iterations,
    })
}

fn linearise(
    vectors: &[Vector],
    variances: &[f64],
    model: &TriadModel,
    free_values: &DVector<f64>,
    known: &[Known],
) -> Linearised {
    let rows = vectors.len() + known.len();
    let mut residuals = DVector::zeros(rows);
    let mut jacobian = DMatrix::zeros(rows, free_values.len());
    for (row, (vector, variance)) in vectors.iter().zip(variances).enumerate() {
        let (length, gradient) = model.length(&vector.raw, vector.kelvin);
        let weight = 1.0 / variance.sqrt();
        residuals[row] = (length - vector.length) * weight;
        (0..free_values.len()).for_each(|column| jacobian[(row, column)] = gradient[column] * weight);
    }
    for (row, &(index, value, deviation)) in known.iter().enumerate() {
        if index < free_values.len() {
            residuals[vectors.len() + row] = (free_values[index] - value) / deviation;
            jacobian[(vectors.len() + row, index)] = 1.0 / deviation;
        }
    }
    Linearised { residuals, jacobian }
}

/// Derivatives of the length of one vector by the first `n` parameters.
pub(crate) fn gradient(model: &TriadModel, raw: &[f64; 3], kelvin: f64, n: usize) -> DVector<f64> {
    let (_, all) = model.length(raw, kelvin);
    DVector::from_column_slice(&all[..n])
}

/// The sphere nearest to the vectors: centre and radius, by the linear system |x|² = 2c·x + (r² − |c|²). A start for axes of
/// unknown scale; `None` if the vectors lie in a plane.
pub(crate) fn sphere(raw: &[[f64; 3]]) -> Option<([f64; 3], f64)> {
    let count = raw.len() as f64;
    let mean = [0, 1, 2].map(|axis| raw.iter().map(|r| r[axis]).sum::<f64>() / count);
    let spread = raw.iter().map(|r| (0..3).map(|i| (r[i] - mean[i]).powi(2)).sum::<f64>()).sum::<f64>();
    let size = (spread / count).sqrt();
    if size.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let scaled: Vec<[f64; 3]> = raw.iter().map(|r| [0, 1, 2].map(|i| (r[i] - mean[i]) / size)).collect();
    let matrix = DMatrix::from_fn(
        raw.len(),
        4,
        |row, column| if column < 3 { 2.0 * scaled[row][column] } else { 1.0 },
    );
    let singular = matrix.clone().singular_values();
    if singular.min() < 1e-3 * singular.max() {
        return None;
    }
    let right =
        DVector::from_iterator(raw.len(), scaled.iter().map(|r| r.iter().map(|x| x * x).sum::<f64>()));
    let solution = crate::least_squares::solve(matrix, right)?;
    let centre = [0, 1, 2].map(|i| solution[i]);
    let radius = (solution[3] + centre.iter().map(|c| c * c).sum::<f64>()).sqrt();
    (radius.is_finite() && radius > 0.0)
        .then(|| ([0, 1, 2].map(|i| mean[i] + size * centre[i]), size * radius))
}
