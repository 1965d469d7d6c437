//! Reasons to reject a model when it is built. After that no step can fail.

use core::fmt;

/// Reason to reject a model. Indices count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// The sample period is not a positive finite number.
    Period,
    /// The model has no axis.
    NoAxis,
    /// More axes than the predictor has room for.
    TooManyAxes {
        /// Number in the model.
        found: usize,
        /// Capacity of the predictor.
        capacity: usize,
    },
    /// More inputs than the predictor has room for.
    TooManyInputs {
        /// Number in the model.
        found: usize,
        /// Capacity of the predictor.
        capacity: usize,
    },
    /// More terms, over all axes, than the predictor has room for.
    TooManyTerms {
        /// Capacity of the predictor.
        capacity: usize,
    },
    /// A lag is longer than the history.
    LagTooDeep {
        /// Index of the axis in the model.
        axis: usize,
        /// Values between the lagged one and the present, all channels counted.
        needed: usize,
        /// Capacity of the history, values.
        capacity: usize,
    },
    /// A coefficient of the axis is NaN or infinite.
    CoefficientNotFinite {
        /// Index of the axis in the model.
        axis: usize,
        /// Index of the term, physical part first.
        term: usize,
    },
    /// Another number of the axis is NaN, infinite or has the wrong sign.
    AxisParameter {
        /// Index of the axis in the model.
        axis: usize,
    },
    /// A term refers to an input that does not exist.
    UnknownInput {
        /// Index of the axis in the model.
        axis: usize,
        /// Index of the term, physical part first.
        term: usize,
    },
    /// A term of the physical part uses the output, or an input computed from it.
    OutputInPhysicalPart {
        /// Index of the axis in the model.
        axis: usize,
        /// Index of the term in the physical part.
        term: usize,
    },
    /// A number of an input is NaN, infinite or has the wrong sign.
    InputParameter {
        /// Index of the input in the model.
        input: usize,
    },
    /// The source of an input does not exist, or does not suit its transform.
    InputSource {
        /// Index of the input in the model.
        input: usize,
    },
    /// The terms of the axis could overflow with inputs and remainder inside their limits.
    Unbounded {
        /// Index of the axis in the model.
        axis: usize,
    },
    /// Mean or variance of the innovation of the axis, or its scale, is so large or small that a
    /// [`Monitor`](crate::Monitor) could overflow.
    Innovation {
        /// Index of the axis in the model.
        axis: usize,
    },
    /// The axis exceeds the range of [`Fixed`](crate::Fixed): a constant, a limit or the sum of the terms is 256 or more,
    /// in its unit or in scaled units.
    AxisNotInFixedPoint {
        /// Index of the axis in the model.
        axis: usize,
    },
    /// The input exceeds the range of [`Fixed`](crate::Fixed): its centre or a limit is 256 or more.
    InputNotInFixedPoint {
        /// Index of the input in the model.
        input: usize,
    },
    /// The input has a transform, but fos-core was built without the feature `transforms`.
    TransformNotBuilt {
        /// Index of the input in the model.
        input: usize,
    },
    /// The term is a product of factors, but fos-core was built without the feature `products`.
    ProductNotBuilt {
        /// Index of the axis in the model.
        axis: usize,
        /// Index of the term, physical part first.
        term: usize,
    },
    /// A number of the calibration is NaN, infinite or too large.
    Calibration,
    /// A stillness limit is NaN, infinite or not positive, or the window is empty.
    Stillness,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Period => write!(f, "the sample period is not a positive number"),
            Self::NoAxis => write!(f, "the model has no axis"),
            Self::TooManyAxes { found, capacity } => write!(f, "{found} axes, room for {capacity}"),
            Self::TooManyInputs { found, capacity } => write!(f, "{found} inputs, room for {capacity}"),
            Self::TooManyTerms { capacity } => write!(f, "more terms than the {capacity} there is room for"),
            Self::LagTooDeep { axis, needed, capacity } => {
                write!(f, "axis {axis} reaches {needed} values back, the history holds {capacity}")
            }
            Self::CoefficientNotFinite { axis, term } => {
                write!(f, "axis {axis}, term {term}: the coefficient is not finite")
            }
            Self::AxisParameter { axis } => {
                write!(f, "axis {axis}: a parameter is not finite or out of bounds")
            }
            Self::Innovation { axis } => {
                write!(f, "axis {axis}: mean or variance of its innovation, or its scale, is out of bounds")
            }
            Self::UnknownInput { axis, term } => write!(f, "axis {axis}, term {term}: no such input"),
            Self::OutputInPhysicalPart { axis, term } => {
                write!(f, "axis {axis}, term {term}: the physical part must not use the output")
            }
            Self::InputParameter { input } => {
                write!(f, "input {input}: a parameter is not finite or out of bounds")
            }
            Self::InputSource { input } => write!(f, "input {input}: its source does not fit its transform"),
            Self::AxisNotInFixedPoint { axis } => {
                write!(f, "axis {axis}: it needs values of 256 and more, which fixed point does not have")
            }
            Self::InputNotInFixedPoint { input } => {
                write!(f, "input {input}: it needs values of 256 and more, which fixed point does not have")
            }
            Self::TransformNotBuilt { input } => {
                write!(f, "input {input} has a transform: build fos-core with its feature `transforms`")
            }
            Self::ProductNotBuilt { axis, term } => {
                write!(f, "axis {axis}, term {term} is a product: build fos-core with its feature `products`")
            }
            Self::Unbounded { axis } => write!(f, "axis {axis}: the terms can overflow"),
            Self::Calibration => write!(f, "a number of the calibration is not finite or out of bounds"),
            Self::Stillness => write!(f, "a limit of stillness is not a positive number"),
        }
    }
}

impl core::error::Error for ModelError {}
