//! Coefficients of an effect and their covariance.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use fos_fit::noise::Gls;

/// Coefficients of an effect, one per regressor; 0 if they could not be estimated.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    pub(crate) coefficients: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
    /// Indices of the estimated coefficients; the covariance of the others is 0.
    estimated: Vec<usize>,
}

impl Estimate {
    /// Returns the estimate of the regressors at `places` of a regression.
    pub(crate) fn of(gls: &Gls, places: Range<usize>) -> Self {
        let (all, covariance) = (gls.coefficients(), gls.covariance());
        let kept = |place: usize| gls.kept.iter().position(|index| *index == place);
        let places: Vec<usize> = places.collect();
        Self {
            coefficients: DVector::from_iterator(places.len(), places.iter().map(|place| all[*place])),
            covariance: DMatrix::from_fn(places.len(), places.len(), |i, j| {
                kept(places[i]).zip(kept(places[j])).map_or(0.0, |(i, j)| covariance[(i, j)])
            }),
            estimated: (0..places.len()).filter(|at| kept(places[*at]).is_some()).collect(),
        }
    }

    /// Returns the Cholesky factor L of the covariance L·Lᵀ of the estimated coefficients; rows and columns of the
    /// others are 0. `None` if the matrix is not a covariance, for example because data are not finite.
    pub(crate) fn factor(&self) -> Option<DMatrix<f64>> {
        let (estimated, k) = (&self.estimated, self.coefficients.len());
        let estimated_block = DMatrix::from_fn(estimated.len(), estimated.len(), |i, j| {
            self.covariance[(estimated[i], estimated[j])]
        });
        let lower = estimated_block.cholesky()?.l();
        let mut factor = DMatrix::zeros(k, k);
        for (i, row) in estimated.iter().enumerate() {
            for (j, column) in estimated.iter().enumerate() {
                factor[(*row, *column)] = lower[(i, j)];
            }
        }
        Some(factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An estimate of three coefficients, some of which could be estimated.
    fn estimate(estimated: Vec<usize>, covariance: DMatrix<f64>) -> Estimate {
        Estimate { coefficients: DVector::from_element(3, 1.0), covariance, estimated }
    }

    fn covariance() -> DMatrix<f64> {
        DMatrix::from_row_slice(3, 3, &[4.0, 1.2, -0.4, 1.2, 9.0, 0.7, -0.4, 0.7, 2.5])
    }

    #[test]
    fn factor_of_fully_estimated_covariance_is_cholesky() {
        let factor = estimate(vec![0, 1, 2], covariance()).factor();
        assert_eq!(factor, covariance().cholesky().map(|cholesky| cholesky.l()));
    }

    #[test]
    fn unestimated_coefficient_keeps_covariance_of_the_others() {
        let mut known = covariance();
        known.row_mut(1).fill(0.0);
        known.column_mut(1).fill(0.0);
        let factor = estimate(vec![0, 2], known.clone()).factor().expect("a covariance of the others");
        assert!((&factor * factor.transpose() - known).amax() < 1e-14);
        assert!(factor[(2, 2)] > 0.0);
    }

    /// Such coefficients were taken as exact, so that the interval of the reduction covered the noise alone.
    #[test]
    fn invalid_covariance_has_no_factor() {
        let mut indefinite = covariance();
        (indefinite[(0, 1)], indefinite[(1, 0)]) = (7.0, 7.0);
        assert_eq!(estimate(vec![0, 1, 2], indefinite).factor(), None);
        let mut not_finite = covariance();
        not_finite[(2, 2)] = f64::NAN;
        assert_eq!(estimate(vec![0, 1, 2], not_finite).factor(), None);
    }
}
