//! Model of one axis alone.

use std::ops::Deref;

use fos_core::Source;
use serde::{Deserialize, Serialize};

use crate::model::{FittedAxis, InputsMut, UnitModel};

/// A [`UnitModel`] of exactly one axis, and readable as one. The axis and its inputs can be changed, but not the number of
/// axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UnitModel", into = "UnitModel")]
pub struct SingleAxisModel(UnitModel);

/// A model that has not exactly one axis.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a model of one axis is needed; this one has {0}")]
pub struct NotOneAxis(pub usize);

impl SingleAxisModel {
    /// Wraps a model that has one axis.
    pub(crate) fn of(model: UnitModel) -> Self {
        debug_assert_eq!(model.axes.len(), 1);
        Self(model)
    }

    pub fn axis(&self) -> &FittedAxis {
        &self.0.axes[0]
    }

    pub fn axis_mut(&mut self) -> &mut FittedAxis {
        &mut self.0.axes[0]
    }

    pub fn inputs_mut(&mut self) -> InputsMut<'_> {
        self.0.inputs_mut()
    }

    /// Removes the inputs and quantities that no term uses.
    pub fn drop_unused(&mut self) {
        self.0.drop_unused();
    }
}

impl UnitModel {
    /// Returns the model of the axis of this index, with the inputs that it needs and without the calibration, which is of
    /// all axes.
    ///
    /// # Panics
    ///
    /// If there is no such axis.
    pub fn only(&self, index: usize) -> SingleAxisModel {
        let mut alone = Self { axes: vec![self.axes[index].clone()], calibration: None, ..self.clone() };
        alone.drop_unused();
        for named in &mut alone.inputs {
            if let Source::Remainder(axis) = &mut named.input.source {
                // a term uses the memory of its axis only
                *axis = 0;
            }
        }
        SingleAxisModel(alone)
    }

    /// Returns the model of the axes of these indices, as [`UnitModel::only`] does for one; none without an index.
    ///
    /// # Panics
    ///
    /// If there is no such axis.
    pub fn of_axes(&self, indices: impl IntoIterator<Item = usize>) -> Option<Self> {
        Self::joined(indices.into_iter().map(|index| self.only(index).into()))
    }
}

impl TryFrom<UnitModel> for SingleAxisModel {
    type Error = NotOneAxis;

    fn try_from(model: UnitModel) -> Result<Self, NotOneAxis> {
        if model.axes.len() == 1 { Ok(Self(model)) } else { Err(NotOneAxis(model.axes.len())) }
    }
}

impl From<SingleAxisModel> for UnitModel {
    fn from(model: SingleAxisModel) -> Self {
        model.0
    }
}

impl Deref for SingleAxisModel {
    type Target = UnitModel;

    fn deref(&self) -> &UnitModel {
        &self.0
    }
}
