//! Model of one axis alone.

use std::ops::Deref;

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
