//! Information about a vector, possibly without any about some components.

use nalgebra::{DMatrix, DVector};

/// Information of one source about a vector: the inverse covariance Λ, and Λ·x.
///
/// Rows and columns of unknown coefficients are 0, which a covariance could not express.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Information {
    pub(crate) information: DMatrix<f64>,
    /// Λ·x.
    pub(crate) weighted: DVector<f64>,
}

/// Information about the mean of a distribution from one noisy draw of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeanInformation {
    pub(crate) information: DMatrix<f64>,
    pub(crate) weighted: DVector<f64>,
    /// ln det (I + Λ·C).
    pub(crate) log_determinant: f64,
}

impl Information {
    /// Adds the information of another source.
    pub(crate) fn add(&mut self, other: &MeanInformation) {
        self.information += &other.information;
        self.weighted += &other.weighted;
    }

    /// No information about `n` coefficients.
    pub(crate) fn nothing(n: usize) -> Self {
        Self { information: DMatrix::zeros(n, n), weighted: DVector::zeros(n) }
    }

    /// Information through a scatter with covariance C: (I + Λ·C)⁻¹·Λ, which needs neither inverse.
    pub(crate) fn through(&self, scatter: &DMatrix<f64>) -> MeanInformation {
        let n = self.weighted.len();
        let factor = (DMatrix::identity(n, n) + &self.information * scatter).lu();
        // Product of two positive semidefinite matrices: its eigenvalues are not negative, and those of the sum at least 1.
        let solve =
            |right: &DMatrix<f64>| factor.solve(right).unwrap_or_else(|| DMatrix::zeros(n, right.ncols()));
        let information = symmetric(&solve(&self.information));
        let weighted =
            solve(&DMatrix::from_column_slice(n, 1, self.weighted.as_slice())).column(0).into_owned();
        MeanInformation { information, weighted, log_determinant: factor.determinant().abs().ln() }
    }
}

/// Mean of a matrix and its transpose; removes asymmetry from rounding.
pub(crate) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

pub(crate) fn matrix_of(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column])
}

/// `rows` is an `n` × `n` matrix.
pub(crate) fn is_square(rows: &[Vec<f64>], n: usize) -> bool {
    rows.len() == n && rows.iter().all(|row| row.len() == n)
}
