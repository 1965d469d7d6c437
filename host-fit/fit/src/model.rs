//! A fitted model on the host: f64, with names, units and standard errors. It is always run by fos-core.

use fos_core::{
    AxisModel, AxisParameters, Channel, Factor, FittedOn, Input, Model, ModelError, Predictor, Quantity,
    Range, Real, Source, StillnessLimits, Term,
};
use serde::{Deserialize, Serialize};

use crate::parameters::StoredParameters;
use crate::signal::{self, autocorrelation::autocorrelation};
use crate::unit_calibration::UnitCalibration;

/// Largest number of axes of a model on the host.
pub const AXES: usize = 6;

/// Largest number of inputs of a model on the host.
pub const INPUTS: usize = 32;

/// Evaluator with the capacities of the host: 512 terms, 4096 values of history.
pub type HostPredictor<R> = Predictor<R, AXES, INPUTS, 512, 4096>;

/// A small evaluator that is cheap to copy and that most models fit into.
pub type SmallPredictor<R> = Predictor<R, AXES, INPUTS, 64, 256>;

/// Model of one device: axes over shared inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitModel {
    /// Sample period T, s.
    pub period_s: f64,
    /// Kind of the measured values while fitting: raw or corrected.
    pub fitted_on: FittedOn,
    /// Thresholds below which the device counts as still.
    pub stillness: Option<StillnessLimits<f64>>,
    /// Bias, sensitivity and cross-axis, applied to the corrected values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<UnitCalibration>,
    /// Logged quantities from which inputs are computed.
    pub quantities: Vec<LoggedQuantity>,
    /// Inputs u_0, u_1, …
    pub inputs: Vec<NamedInput>,
    /// Axes, each with its own terms over the same inputs.
    pub axes: Vec<FittedAxis>,
}

/// A logged quantity: a column of a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoggedQuantity {
    /// Name of the column, as `temp_c`.
    pub column: String,
    /// Identity on the device: its thermometer, one of its axes, or a value from the application.
    pub quantity: Quantity,
}

/// An input with a readable name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedInput {
    /// Name as in tables: `temp_c`, `lowpass(r, 10 s)`.
    pub name: String,
    #[serde(flatten)]
    pub input: Input<f64>,
}

/// Inputs of a model, and the quantities that they are computed from, to be changed.
#[derive(Debug)]
pub struct InputsMut<'m> {
    pub quantities: &'m mut Vec<LoggedQuantity>,
    pub inputs: &'m mut Vec<NamedInput>,
}

/// One axis of a [`UnitModel`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedAxis {
    /// Column that was fitted.
    pub column: String,
    #[serde(with = "StoredParameters")]
    pub parameters: AxisParameters<f64>,
    /// Physical part p: terms over inputs only.
    pub physical: Vec<FittedTerm>,
    /// Stochastic part r̂ without its constant.
    pub stochastic: Vec<FittedTerm>,
    /// Statistics of the fitted rows without any model; none for a model from an image, or in studies of earlier
    /// versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plain: Option<Plain>,
}

/// Statistics of the measured error of an axis before any correction, from which the simpler rivals are made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plain {
    /// Mean of measured − true value, or of measured if the true value is an unknown constant, in the axis' unit.
    pub mean: f64,
    /// Range of the same values.
    pub range: Range<f64>,
    /// Lag-1 autocorrelation.
    pub lag_1: f64,
}

impl Plain {
    /// Computes the statistics from the values of the rows, and from the same in gap-free stretches, on any scale.
    pub fn of(values: &[f64], stretches: &[&[f64]]) -> Self {
        let extreme = |choose: fn(f64, f64) -> f64| values.iter().copied().reduce(choose).unwrap_or(0.0);
        Self {
            mean: signal::mean(&[values]),
            range: Range::new(extreme(f64::min), extreme(f64::max)),
            lag_1: autocorrelation(stretches, 1).map_or(0.0, |result| result.lag_1()),
        }
    }
}

/// A term with its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedTerm {
    /// Coefficient, scaled units.
    pub coefficient: f64,
    /// Standard error, scaled units; absent if it was not estimated.
    pub standard_error: Option<f64>,
    pub factors: Vec<Factor>,
}

impl UnitModel {
    /// Returns a predictor for the model, in f64, or in f32 as on the device.
    pub fn predictor<R: Real>(&self) -> Result<HostPredictor<R>, ModelError> {
        self.with(HostPredictor::new)
    }

    /// Calls `work` with the model in the form of fos-core, in scalar `R`.
    pub fn with<R: Real, T>(&self, work: impl FnOnce(&Model<'_, R>) -> T) -> T {
        let terms = |terms: &[FittedTerm]| -> Vec<Term<R>> {
            // factors come from a search or from a study file, where a bad one was rejected
            let term =
                |term: &FittedTerm| Term::try_new(term.coefficient, &term.factors).map(|term| term.convert());
            terms.iter().filter_map(term).collect()
        };
        let quantities: Vec<Quantity> = self.quantities.iter().map(|logged| logged.quantity).collect();
        let inputs: Vec<Input<R>> = self.inputs.iter().map(|named| named.input.convert()).collect();
        let parts: Vec<_> =
            self.axes.iter().map(|axis| (terms(&axis.physical), terms(&axis.stochastic))).collect();
        let axes: Vec<AxisModel<'_, R>> = self
            .axes
            .iter()
            .zip(&parts)
            .map(|(axis, (physical, stochastic))| AxisModel {
                parameters: axis.parameters.convert(),
                physical,
                stochastic,
            })
            .collect();
        work(&Model {
            period_s: self.period_s,
            fitted_on: self.fitted_on,
            stillness: self.stillness.map(|limits| limits.convert()),
            calibration: self.device_calibration().map(|calibration| calibration.convert()),
            quantities: &quantities,
            inputs: &inputs,
            axes: &axes,
        })
    }

    /// Adds the axes of `other`, a model of the same device, with the inputs that their terms use; common inputs are
    /// shared. One axis of corrected values makes it a model of corrected values.
    pub fn absorb(&mut self, other: UnitModel) {
        if other.fitted_on == FittedOn::FactoryCorrected {
            self.fitted_on = FittedOn::FactoryCorrected;
        }
        let first_axis = self.axes.len() as u8;
        let terms = other.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
        let used: Vec<Channel> = terms.flat_map(|term| &term.factors).map(|factor| factor.channel).collect();
        let mut inputs = vec![0; other.inputs.len()];
        for (index, mut named) in other.inputs.into_iter().enumerate() {
            if !used.contains(&Channel::Input(index as u8)) {
                continue;
            }
            match &mut named.input.source {
                Source::Clock => {}
                Source::Quantity(quantity) => {
                    let logged = other.quantities[usize::from(*quantity)].clone();
                    *quantity = position(&mut self.quantities, logged);
                }
                Source::Remainder(axis) => *axis += first_axis,
            }
            inputs[index] = position(&mut self.inputs, named);
        }
        for mut axis in other.axes {
            for term in axis.physical.iter_mut().chain(&mut axis.stochastic) {
                for factor in &mut term.factors {
                    if let Channel::Input(input) = &mut factor.channel {
                        *input = inputs[usize::from(*input)];
                    }
                }
            }
            self.axes.push(axis);
        }
    }

    /// Joins models of one device, each with axes of its own; none without any.
    pub fn joined(models: impl IntoIterator<Item = Self>) -> Option<Self> {
        models.into_iter().reduce(|mut all, other| {
            all.absorb(other);
            all
        })
    }

    pub fn inputs_mut(&mut self) -> InputsMut<'_> {
        InputsMut { quantities: &mut self.quantities, inputs: &mut self.inputs }
    }

    /// Removes the inputs and quantities that no term uses.
    pub fn drop_unused(&mut self) {
        let bare = Self { quantities: Vec::new(), inputs: Vec::new(), axes: Vec::new(), ..self.clone() };
        let whole = std::mem::replace(self, bare);
        self.absorb(whole);
    }

    /// Returns the number of terms of all axes.
    pub fn n_terms(&self) -> usize {
        self.axes.iter().map(|axis| axis.physical.len() + axis.stochastic.len()).sum()
    }
}

/// Returns the index of `thing` in `things`; appends it if absent.
pub fn position<T: PartialEq>(things: &mut Vec<T>, thing: T) -> u8 {
    let found = things.iter().position(|other| *other == thing).unwrap_or_else(|| {
        things.push(thing);
        things.len() - 1
    });
    found as u8
}
