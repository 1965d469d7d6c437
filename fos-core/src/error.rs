//! Why a model is refused when it is built: after that no step can fail.

use core::fmt;

/// Why a model cannot be used. Indices count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// The sample period is not a positive finite number.
    Period,
    /// There is no axis.
    NoAxis,
    /// More axes than the predictor has room for.
    TooManyAxes {
        /// What the model has.
        found: usize,
        /// What the predictor was made for.
        capacity: usize,
    },
    /// More inputs than the predictor has room for.
    TooManyInputs {
        /// What the model has.
        found: usize,
        /// What the predictor was made for.
        capacity: usize,
    },
    /// More terms, over all axes, than the predictor has room for.
    TooManyTerms {
        /// What the predictor was made for.
        capacity: usize,
    },
    /// A lag reaches back further than the history does.
    LagTooDeep {
        /// Its place in the model.
        axis: usize,
        /// Values that it reaches back, all channels counted.
        needed: usize,
        /// Values that the history holds.
        capacity: usize,
    },
    /// A coefficient of the axis is NaN or infinite.
    CoefficientNotFinite {
        /// Its place in the model.
        axis: usize,
        /// The term, physical part first.
        term: usize,
    },
    /// Another number of the axis is NaN, infinite or has the wrong sign.
    AxisParameter {
        /// Its place in the model.
        axis: usize,
    },
    /// A term names an input that is not there.
    UnknownInput {
        /// Its place in the model.
        axis: usize,
        /// The term, physical part first.
        term: usize,
    },
    /// A term of the physical part uses the output or an input that is computed from it.
    OutputInPhysicalPart {
        /// Its place in the model.
        axis: usize,
        /// Its place in the physical part.
        term: usize,
    },
    /// A number of an input is NaN, infinite or has the wrong sign.
    InputParameter {
        /// Its place in the model.
        input: usize,
    },
    /// An input's source is not there, or is not of the kind that its transform takes.
    InputSource {
        /// Its place in the model.
        input: usize,
    },
    /// The axis' terms could overflow even with inputs and remainder inside their limits.
    Unbounded {
        /// Its place in the model.
        axis: usize,
    },
    /// Mean or variance of the axis' innovation, or its scale, is so far out that a [`Monitor`](crate::Monitor) could
    /// overflow.
    Innovation {
        /// Its place in the model.
        axis: usize,
    },
    /// The axis does not fit [`Fixed`](crate::Fixed): a constant of it, its limits, or all its terms together come to 256
    /// and more, in its unit or in scaled units.
    AxisNotInFixedPoint {
        /// Its place in the model.
        axis: usize,
    },
    /// The input does not fit [`Fixed`](crate::Fixed): its centre or a limit of it comes to 256 and more.
    InputNotInFixedPoint {
        /// Its place in the model.
        input: usize,
    },
    /// The input has a transform, and this was built without the feature `transforms`.
    TransformNotBuilt {
        /// Its place in the model.
        input: usize,
    },
    /// The term is a product of factors, and this was built without the feature `products`.
    ProductNotBuilt {
        /// Its place in the model.
        axis: usize,
        /// The term, physical part first.
        term: usize,
    },
    /// A limit of stillness is NaN, infinite or not positive, or its window is empty.
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
            Self::Stillness => write!(f, "a limit of stillness is not a positive number"),
        }
    }
}

impl core::error::Error for ModelError {}
