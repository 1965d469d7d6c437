//! Model of three axes that measure one vector, free of the frame that the vector is given in.
//!
//! raw = S·U·a + b, where the rows of U are the unit vectors of the sensitive axes. The length of a does not change with a
//! rotation of the frame, so rests or plateaus of known length determine only U·Uᵀ = Γ: ones on the diagonal, the cosines
//! of the angles between the axes beside it. With w = S⁻¹(raw − b),
//!
//! |a|² = wᵀ Γ⁻¹ w,
//!
//! in 9 unknowns: b (3), S (3), Γ (3). The frame of the corrected values is the one in which U is symmetric,
//! U = Γ^½ (Löwdin 1950): of all right-angled frames the nearest to the three axes, independent of the numbering of the axes. The
//! correction is a = M(raw − b), M = Γ^−½ S⁻¹.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use serde::Serialize;

/// Number of parameters of [`TriadModel`]: bias, sensitivity, cosines, and the two slopes.
pub(crate) const PARAMETERS: usize = 15;

/// Number of parameters without the slopes, which are the last ones.
pub(crate) const UNKNOWNS: usize = 9;

/// Pairs of axes in the order of the cosines: xy, xz, yz.
pub const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Bias, sensitivity and cross-axis of three axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TriadModel {
    /// Value of each axis where the measured vector is 0, in the unit of the log, at [`TriadModel::reference_c`].
    pub bias: [f64; 3],
    /// Values of the log per m/s² or rad/s along each axis; 1 for an ideal sensor in SI units.
    pub sensitivity: [f64; 3],
    /// Cosines of the angles between the axes, in the order of [`PAIRS`].
    pub cosine: [f64; 3],
    /// Change of the bias with temperature, unit of the log per K.
    pub bias_per_k: [f64; 3],
    /// Relative change of the sensitivity with temperature, 1/K.
    pub sensitivity_per_k: [f64; 3],
    /// Temperature that bias and sensitivity are given for, °C; without effect where the slopes are 0.
    pub reference_c: f64,
}

impl Default for TriadModel {
    fn default() -> Self {
        Self {
            bias: [0.0; 3],
            sensitivity: [1.0; 3],
            cosine: [0.0; 3],
            bias_per_k: [0.0; 3],
            sensitivity_per_k: [0.0; 3],
            reference_c: 25.0,
        }
    }
}

impl TriadModel {
    pub(crate) fn of_parameters(p: &[f64; PARAMETERS], reference_c: f64) -> Self {
        let three = |at: usize| [p[at], p[at + 1], p[at + 2]];
        Self {
            bias: three(0),
            sensitivity: three(3),
            cosine: three(6),
            bias_per_k: three(9),
            sensitivity_per_k: three(12),
            reference_c,
        }
    }

    pub(crate) fn parameters(&self) -> [f64; PARAMETERS] {
        let groups = [self.bias, self.sensitivity, self.cosine, self.bias_per_k, self.sensitivity_per_k];
        let mut all = [0.0; PARAMETERS];
        for (to, from) in all.iter_mut().zip(groups.iter().flatten()) {
            *to = *from;
        }
        all
    }

    /// Γ: the cosines between the axes, ones on the diagonal.
    pub fn gram(&self) -> Matrix3<f64> {
        let [xy, xz, yz] = self.cosine;
        Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0)
    }

    /// The unit vectors of the axes, one per row, in the frame of the corrected values: Γ^½.
    pub fn axes(&self) -> Matrix3<f64> {
        power(&self.gram(), 0.5)
    }

    /// Sensitivity times 1 + slope·τ.
    fn sensitivity_at(&self, kelvin: f64) -> [f64; 3] {
        [0, 1, 2].map(|i| self.sensitivity[i] * (1.0 + self.sensitivity_per_k[i] * kelvin))
    }

    /// M, row by row, and b at a temperature, °C: the corrected vector is M·(raw − b).
    pub fn correction(&self, temperature_c: f64) -> ([[f64; 3]; 3], [f64; 3]) {
        let kelvin = temperature_c - self.reference_c;
        let (s, inverse) = (self.sensitivity_at(kelvin), power(&self.gram(), -0.5));
        let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| inverse[(i, j)] / s[j]));
        (matrix, [0, 1, 2].map(|i| self.bias[i] + self.bias_per_k[i] * kelvin))
    }

    /// The corrected vector, m/s² or rad/s.
    pub fn corrected(&self, raw: [f64; 3], temperature_c: f64) -> [f64; 3] {
        let (m, b) = self.correction(temperature_c);
        m.map(|row| (0..3).map(|j| row[j] * (raw[j] - b[j])).sum())
    }

    /// The values that the sensor shows for a vector in the frame of the corrected values: the inverse of
    /// [`TriadModel::corrected`].
    pub fn measured(&self, vector: [f64; 3], temperature_c: f64) -> [f64; 3] {
        let kelvin = temperature_c - self.reference_c;
        let along = self.axes() * Vector3::from(vector);
        let s = self.sensitivity_at(kelvin);
        [0, 1, 2].map(|i| s[i] * along[i] + self.bias[i] + self.bias_per_k[i] * kelvin)
    }

    /// |a| of a raw vector at `kelvin` above the reference, and its derivatives by all parameters.
    ///
    /// With q = Γ⁻¹w and n = |a|: ∂n/∂bᵢ = −qᵢ/(sᵢn), ∂n/∂sᵢ = −qᵢwᵢ/(sᵢn), ∂n/∂γᵢⱼ = −qᵢqⱼ/n.
    pub(crate) fn length(&self, raw: &[f64; 3], kelvin: f64) -> (f64, [f64; PARAMETERS]) {
        let s = self.sensitivity_at(kelvin);
        let w =
            Vector3::from([0, 1, 2].map(|i| (raw[i] - self.bias[i] - self.bias_per_k[i] * kelvin) / s[i]));
        let not_a_number = (f64::NAN, [f64::NAN; PARAMETERS]);
        let Some(cholesky) = self.gram().cholesky() else { return not_a_number };
        let q = cholesky.solve(&w);
        let length = w.dot(&q).sqrt();
        let mut gradient = [0.0; PARAMETERS];
        for i in 0..3 {
            let by_bias = -q[i] / (s[i] * length);
            let by_log_sensitivity = -q[i] * w[i] / length;
            gradient[i] = by_bias;
            gradient[3 + i] = by_log_sensitivity / self.sensitivity[i];
            gradient[9 + i] = by_bias * kelvin;
            gradient[12 + i] = by_log_sensitivity * kelvin / (1.0 + self.sensitivity_per_k[i] * kelvin);
        }
        for (pair, (i, j)) in PAIRS.into_iter().enumerate() {
            gradient[6 + pair] = -q[i] * q[j] / length;
        }
        (length, gradient)
    }
}

/// A power of a symmetric matrix with positive eigenvalues; NaN where one is not positive.
pub(crate) fn power(matrix: &Matrix3<f64>, exponent: f64) -> Matrix3<f64> {
    let eigen = SymmetricEigen::new(*matrix);
    let values = eigen.eigenvalues.map(|value| value.powf(exponent));
    eigen.eigenvectors * Matrix3::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> TriadModel {
        TriadModel {
            bias: [0.3, -0.2, 0.1],
            sensitivity: [1.02, 0.97, 1.01],
            cosine: [0.01, -0.02, 0.015],
            bias_per_k: [2e-3, -1e-3, 5e-4],
            sensitivity_per_k: [1e-4, -2e-4, 5e-5],
            reference_c: 25.0,
        }
    }

    #[test]
    fn correcting_undoes_measuring() {
        let vector = [3.0, -4.0, 8.0];
        let again = model().corrected(model().measured(vector, 31.0), 31.0);
        for axis in 0..3 {
            assert!((again[axis] - vector[axis]).abs() < 1e-12);
        }
    }

    /// The brute-force twin: central differences.
    #[test]
    fn derivatives_of_the_length_are_exact() {
        let raw = [3.2, -7.0, 6.1];
        let (length, gradient) = model().length(&raw, 6.0);
        let corrected = Vector3::from(model().corrected(raw, 31.0));
        assert!((length - corrected.norm()).abs() < 1e-12);
        for (index, derivative) in gradient.iter().enumerate() {
            let moved = |by: f64| {
                let mut p = model().parameters();
                p[index] += by;
                TriadModel::of_parameters(&p, 25.0).length(&raw, 6.0).0
            };
            let numerical = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((numerical - derivative).abs() < 1e-7 * derivative.abs().max(1.0), "{index}");
        }
    }
}
