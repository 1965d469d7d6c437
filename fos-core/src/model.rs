//! The model of one device: up to six axes over shared inputs. Immutable; it may sit in flash.

use serde::{Deserialize, Serialize};

use crate::{Calibration, Input, Range, Real, StillnessLimits, Term};

/// An axis of the sensor. Units: m/s² for accelerometers, rad/s for gyros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Axis {
    /// Accelerometer x, m/s².
    Ax,
    /// Accelerometer y, m/s².
    Ay,
    /// Accelerometer z, m/s².
    Az,
    /// Gyro x, rad/s.
    Gx,
    /// Gyro y, rad/s.
    Gy,
    /// Gyro z, rad/s.
    Gz,
    /// Any other series; its unit is that of the data.
    Other,
}

/// A logged quantity that an input is computed from, in SI units except as stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Quantity {
    /// Sensor temperature, °C.
    Temperature,
    /// Supply voltage, V.
    Supply,
    /// Processor load, %.
    Load,
    /// Magnetic field x, µT.
    MagneticX,
    /// Magnetic field y, µT.
    MagneticY,
    /// Magnetic field z, µT.
    MagneticZ,
    /// A measured axis of the same device.
    Measured(Axis),
    /// The reference (true value) of an axis.
    Reference(Axis),
    /// Any other quantity; its name is in the image's [`Info`](crate::Info), in the order of the quantities.
    Other,
}

/// Processing of the measured values before the fit. The device must feed the same, so that no correction is
/// applied twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FittedOn {
    /// Raw sensor output.
    Raw,
    /// Corrected by the factory calibration or the driver.
    FactoryCorrected,
}

/// Statistics of the innovation on the data of the fit, in scaled units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InnovationStatistics<R> {
    /// Mean; magnitude at most 10¹⁵.
    pub mean: R,
    /// Variance; 10⁻³⁸ … 10²⁰.
    pub variance: R,
    /// Lag-1 correlation, −1 … 1.
    pub lag_1_correlation: R,
}

/// Parameters of one axis; its terms are in [`AxisModel`].
///
/// y = (measured − reference − offset)/scale is the scaled error; measured, reference and offset are in the axis'
/// unit. The terms of the physical part give p, those of the stochastic part r̂ − constant, r = y − p.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisParameters<R> {
    /// Axis of the sensor; it determines the unit, m/s² or rad/s.
    pub axis: Axis,
    /// True value at rest in the orientation of the fit, in the axis' unit: 0 for a gyro, the component of gravity for
    /// an accelerometer. Used when a sample at rest has no reference.
    pub reference: R,
    /// Constant error (bias), in the axis' unit. Subtracted before any scaling, so that f32 keeps its digits.
    pub offset: R,
    /// Size of one scaled unit in the axis' unit; at least 10⁻¹⁹.
    pub scale: R,
    /// Constant a0 of the stochastic part, scaled.
    pub constant: R,
    /// Range of the remainder r in the data of the fit, scaled.
    pub range: Range<R>,
    /// Range of p, the sum of the physical terms, in the data of the fit, scaled, with room for the rounding of p. On
    /// the device p is limited to this range widened by its width on either side, so that terms which cancel only
    /// within the data of the fit cannot diverge. [`Range::unlimited`] if not known; 0 … 0 without physical terms.
    pub physical_range: Range<R>,
    /// Magnitude from which a measured value counts as saturated, in the axis' unit; 0 if not known.
    pub full_scale: R,
    /// Number of repetitions of a measured value from which the sensor counts as stuck; 0 disables the test. Stored as
    /// `stuck_after`.
    #[serde(rename = "stuck_after")]
    pub stuck_after_repeats: u16,
    /// Number of consecutive missing samples that are coasted before the history restarts. Stored as `gap_limit`.
    #[serde(rename = "gap_limit")]
    pub gap_limit_samples: u8,
    /// Longest validated duration of coasting, s; beyond it the stochastic part fades out.
    pub coast_limit_s: R,
    /// Statistics of the innovation on the data of the fit.
    pub innovation: InnovationStatistics<R>,
}

/// The model of one axis: ŷ(n) = p(n) + r̂(n).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisModel<'a, R> {
    /// Scaling, limits and innovation statistics.
    pub parameters: AxisParameters<R>,
    /// p: terms over inputs only.
    pub physical: &'a [Term<R>],
    /// r̂ without its constant: terms over the lagged remainder and inputs.
    pub stochastic: &'a [Term<R>],
}

/// The model of one device: up to six axes over shared inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Model<'a, R> {
    /// Sample period T, s.
    pub period_s: f64,
    /// Processing of the measured values before the fit.
    pub fitted_on: FittedOn,
    /// Limits below which the device counts as still; `None` if the data did not determine them.
    pub stillness: Option<StillnessLimits<R>>,
    /// Calibration of the triads, for the corrected values; a [`Predictor`](crate::Predictor) does not apply it.
    pub calibration: Option<Calibration<R>>,
    /// The logged quantities, in the order of [`Sample::quantities`](crate::Sample).
    pub quantities: &'a [Quantity],
    /// The inputs u_0, u_1, …
    pub inputs: &'a [Input<R>],
    /// The axes, in the order of a sample's measured values.
    pub axes: &'a [AxisModel<'a, R>],
}

/// Widening of the fitted range of p on either side before p is limited, in widths of the range. An input of an added
/// effect may already go one width beyond its fitted range (docs/MATHS.md), and effects that were excited in turn in
/// the data of the fit may act together later. A model of one input reaches the limit of that input first.
pub(crate) const PHYSICAL_MARGIN: f64 = 1.0;

impl<R: Real> AxisParameters<R> {
    /// Limits of p on the device: [`physical_range`](Self::physical_range) widened by its width on either side; scaled.
    pub fn physical_limits(&self) -> Range<R> {
        self.physical_range.widened(R::from_f64(PHYSICAL_MARGIN))
    }
}
