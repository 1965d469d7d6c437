//! What is known of a vector, so that nothing at all can be known of parts of it.

use nalgebra::{DMatrix, DVector};

/// What one source says of a vector: the inverse of a covariance, and that times the values.
///
/// Where a coefficient is not known its row and column are 0, which no covariance could say.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Known {
    pub(crate) information: DMatrix<f64>,
    /// Λ·x.
    pub(crate) weighted: DVector<f64>,
}

/// The same beside a scatter that it is seen through.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    pub(crate) information: DMatrix<f64>,
    pub(crate) weighted: DVector<f64>,
    /// ln det (I + Λ·C).
    pub(crate) log_determinant: f64,
}

impl Known {
    /// The sum of two sources.
    pub(crate) fn add(&mut self, other: &Seen) {
        self.information += &other.information;
        self.weighted += &other.weighted;
    }

    /// Nothing of `n` coefficients.
    pub(crate) fn nothing(n: usize) -> Self {
        Self { information: DMatrix::zeros(n, n), weighted: DVector::zeros(n) }
    }

    /// Through a scatter of covariance `scatter`: (I + Λ·C)⁻¹·Λ, which needs the inverse of neither.
    pub(crate) fn through(&self, scatter: &DMatrix<f64>) -> Seen {
        let n = self.weighted.len();
        let factor = (DMatrix::identity(n, n) + &self.information * scatter).lu();
        // positive semidefinite times the same: its eigenvalues are not negative, and those of the sum at least 1
        let solve =
            |right: &DMatrix<f64>| factor.solve(right).unwrap_or_else(|| DMatrix::zeros(n, right.ncols()));
        let information = symmetric(&solve(&self.information));
        let weighted =
            solve(&DMatrix::from_column_slice(n, 1, self.weighted.as_slice())).column(0).into_owned();
        Seen { information, weighted, log_determinant: factor.determinant().abs().ln() }
    }
}

/// The mean of a matrix and its transpose: what rounding has taken from a symmetric one.
pub(crate) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// From rows.
pub(crate) fn matrix_of(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column])
}

/// `n` rows of `n`.
pub(crate) fn is_square(rows: &[Vec<f64>], n: usize) -> bool {
    rows.len() == n && rows.iter().all(|row| row.len() == n)
}
