//! Heading and position errors after a time without aiding: the residual of one axis, integrated.
//!
//! A gyro axis gives a heading error, a sum over the n samples of a window of period Δt with residuals rᵢ in rad/s,
//!
//! θ = Δt · Σ rᵢ,
//!
//! an accelerometer axis a position error, with rᵢ in m/s² held for one period each and velocity and position right at
//! the begin:
//!
//! p = Δt² · Σ (n − i − ½) rᵢ, i = 0 … n − 1.
//!
//! One axis is integrated alone: no attitude error tilts gravity into it (`strapdown` integrates six axes). The residual is that of a free run which
//! begins with the window, so nothing of the error inside the window is known. Windows are whole, lie in one gap-free
//! stretch at rest each, and do not overlap.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use fos_data::column::{Column, Triad};

/// Lengths of the windows, s.
pub const UNAIDED_S: [f64; 4] = [1.0, 10.0, 60.0, 600.0];

/// Fewest windows from which an RMS is stated.
pub const FEWEST_WINDOWS: usize = 3;

/// Error of one axis after a time without aiding, over all windows of that length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS), ts(optional_fields))]
pub struct UnaidedError {
    /// Length of the windows, s.
    pub window_s: f64,
    /// Number of whole windows that were measured throughout. Below [`FEWEST_WINDOWS`] the log is too short for an RMS.
    pub windows: usize,
    /// Heading error at the end of a window, rad; for a gyro axis, and for six axes together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_rad: Option<RmsInterval>,
    /// Position error at the end of a window, m; for an accelerometer axis, and for six axes together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<RmsInterval>,
}

/// An RMS with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct RmsInterval {
    /// RMS over the windows.
    pub rms: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl UnaidedError {
    /// Computes the RMS of the errors at the ends of windows of `window_s`, in their order, rad or m.
    pub(super) fn of(triad: Triad, window_s: f64, ends: &[f64]) -> Self {
        let found = (ends.len() >= FEWEST_WINDOWS).then(|| RmsInterval::of(&[ends]));
        let of = |wanted: Triad| found.filter(|_| triad == wanted);
        Self {
            window_s,
            windows: ends.len(),
            heading_rad: of(Triad::Gyros),
            position_m: of(Triad::Accelerometers),
        }
    }

    /// Returns the heading or position error, rad or m; none where the log is too short.
    pub fn rms(&self) -> Option<RmsInterval> {
        self.heading_rad.or(self.position_m)
    }
}

impl RmsInterval {
    /// RMS of the lengths of errors about zero, given as one series per component, with the interval of χ², whose degrees
    /// of freedom allow for the autocorrelation of the errors and combine those of the components (Satterthwaite 1946). It
    /// covers the RMS of a stationary error that loses its memory within the log. An error that is equal in all windows
    /// counts as one window, as another turn-on may have another.
    pub(super) fn of(components: &[&[f64]]) -> Self {
        let mean_square = |ends: &&[f64]| ends.iter().map(|end| end * end).sum::<f64>() / ends.len() as f64;
        let squares: Vec<f64> = components.iter().map(mean_square).collect();
        let total: f64 = squares.iter().sum();
        let freedom = match components {
            [ends] => degrees_of_freedom(ends),
            _ => {
                let moving = components.iter().zip(&squares).filter(|(_, square)| **square > 0.0);
                let scatter: f64 =
                    moving.map(|(ends, square)| square * square / degrees_of_freedom(ends)).sum();
                if scatter > 0.0 { total * total / scatter } else { 1.0 }
            }
        };
        let rms = total.sqrt();
        let chi_squared = ChiSquared::new(freedom).expect("degrees of freedom are positive");
        let bound = |probability| rms * (freedom / chi_squared.inverse_cdf(probability)).sqrt();
        Self { rms, low: bound(0.95), high: bound(0.05) }
    }
}

/// Degrees of freedom of a mean square of n correlated normal values with mean zero: n / (1 + 2 Σ (1 − k/n) ρₖ²), from
/// Var(mean square) = 2σ⁴/ν. The sum ends before the first lag at which ρₖ is not positive; beyond it there is noise.
/// Each ρₖ is enlarged by 1/√n, as few values show too little correlation. At least 1.
fn degrees_of_freedom(ends: &[f64]) -> f64 {
    let n = ends.len() as f64;
    let mean_square = ends.iter().map(|end| end * end).sum::<f64>() / n;
    let correlation = |lag: usize| {
        let products = ends.iter().zip(&ends[lag..]).map(|(one, other)| one * other);
        products.sum::<f64>() / (n - lag as f64) / mean_square
    };
    let weighted = |(lag, correlation): (usize, f64)| {
        (1.0 - lag as f64 / n) * (correlation * (1.0 + 1.0 / n.sqrt())).powi(2).min(1.0)
    };
    let lags = (1..ends.len()).map(|lag| (lag, correlation(lag)));
    let sum: f64 = lags.take_while(|(_, correlation)| *correlation > 0.0).map(weighted).sum();
    (n / (1.0 + 2.0 * sum)).max(1.0)
}

/// Integral of the residual of an axis over a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Integral(Triad);

impl Integral {
    /// Returns a single integral for a gyro and a double one for an accelerometer; none for another column.
    pub(super) fn of(column: &str) -> Option<Self> {
        Column::named(column).place().map(|(triad, _)| Self(triad))
    }

    pub(super) fn triad(self) -> Triad {
        self.0
    }

    /// Weight of the residual of sample `index` of `n` in the error at the end of a window; `period_s` is that of the
    /// samples. rad per rad/s, or m per m/s².
    #[inline]
    pub(super) fn weight(self, index: usize, n: usize, period_s: f64) -> f64 {
        match self.0 {
            Triad::Gyros => period_s,
            Triad::Accelerometers => period_s * period_s * (n as f64 - index as f64 - 0.5),
        }
    }
}

#[cfg(test)]
#[path = "unaided_tests.rs"]
mod tests;
