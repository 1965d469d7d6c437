//! Model of one axis alone.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use crate::model::{FittedAxis, LoggedQuantity, NamedInput, UnitModel};

/// A [`UnitModel`] of one axis. It can be read as such, and its inputs and its axis can be changed, but not their number
/// of axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UnitModel", into = "UnitModel")]
pub struct SingleAxisModel(UnitModel);

/// A model that has not exactly one axis.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a model of one axis is needed; this one has {0}")]
pub struct NotOneAxis(pub usize);

impl SingleAxisModel {
    /// The model of an axis that was built or taken out of another just before.
    pub(crate) fn of(model: UnitModel) -> Self {
        debug_assert_eq!(model.axes.len(), 1);
        Self(model)
    }

    /// The axis.
    pub fn axis(&self) -> &FittedAxis {
        &self.0.axes[0]
    }

    /// The axis, to be changed.
    pub fn axis_mut(&mut self) -> &mut FittedAxis {
        &mut self.0.axes[0]
    }

    /// The quantities, and the inputs computed from them, to be extended.
    pub fn inputs_mut(&mut self) -> (&mut Vec<LoggedQuantity>, &mut Vec<NamedInput>) {
        (&mut self.0.quantities, &mut self.0.inputs)
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
