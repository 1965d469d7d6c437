//! Axes of a study that effects were added to, and undo.

use fos_data::closest::closest;
use fos_data::recording::LoadOptions;
use fos_fit::model::UnitModel;
use fos_fit::single_axis::SingleAxisModel;

use super::refinement::Refinement;
use super::{Study, StudyStep};

/// Error of a request for an axis of a study.
#[derive(Debug, thiserror::Error)]
pub enum StudyAxisError {
    #[error(
        "the study has no axis {axis}{}; it has {}\nhelp: name one of them", did_you_mean(axis, axes), axes.join(", ")
    )]
    NoAxis { axis: String, axes: Vec<String> },
    #[error("the study has several axes: {}\nhelp: name one of them", .0.join(", "))]
    SeveralAxes(Vec<String>),
    #[error("nothing was added to {0}\nhelp: add an effect first")]
    NothingAdded(String),
}

/// Short name of the axis of a column: `gx` of `gx_rads`.
fn short(column: &str) -> &str {
    column.split('_').next().unwrap_or(column)
}

fn did_you_mean(axis: &str, columns: &[String]) -> String {
    let meant = closest(short(axis), columns.iter().map(|column| short(column)));
    meant.map_or_else(String::new, |meant| format!(" (did you mean {meant}?)"))
}

impl Study {
    /// Returns the columns of all axes.
    pub fn columns(&self) -> Vec<String> {
        self.model.axes.iter().map(|axis| axis.column.clone()).collect()
    }

    /// Returns the column of an axis, by its full name (`gx_rads`) or its short one (`gx`); without a name that of the only
    /// axis.
    pub fn column(&self, axis: Option<&str>) -> Result<String, StudyAxisError> {
        let axes = self.columns();
        match (axis, &axes[..]) {
            (None, [only]) => Ok(only.clone()),
            (None, _) => Err(StudyAxisError::SeveralAxes(axes)),
            (Some(axis), _) => match axes.iter().find(|column| *column == axis || short(column) == axis) {
                Some(column) => Ok(column.clone()),
                None => Err(StudyAxisError::NoAxis { axis: axis.to_owned(), axes }),
            },
        }
    }

    /// Returns the column of the axis whose last effect is removed: the named one, otherwise the only one with an added effect.
    pub fn column_to_undo(&self, axis: Option<&str>) -> Result<String, StudyAxisError> {
        let refined = self.refinements.iter().filter(|refinement| refinement.added().next().is_some());
        match (axis, &refined.collect::<Vec<_>>()[..]) {
            (None, [only]) => Ok(only.column.clone()),
            _ => self.column(axis),
        }
    }

    /// Returns the options with which the logs of an axis are read: those of its refinement, otherwise those of the fit.
    pub fn read_options(&self, column: &str) -> &LoadOptions {
        self.refinement_of(column).map_or(&self.data.read, |refinement| &refinement.logs.read)
    }

    /// Returns the refinement of an axis, if any.
    pub fn refinement_of(&self, column: &str) -> Option<&Refinement> {
        self.refinements.iter().find(|refinement| refinement.column == column)
    }

    /// Returns the model of one axis of the study, as it is now.
    pub fn axis_alone(&self, column: &str) -> Result<SingleAxisModel, StudyAxisError> {
        let index = self.model.axes.iter().position(|axis| axis.column == column);
        index
            .map(|index| self.model.only(index))
            .ok_or_else(|| StudyAxisError::NoAxis { axis: column.to_owned(), axes: self.columns() })
    }

    /// The part of the study that is of one axis without its refinement: the inverse of [`Study::joined`].
    pub fn only(&self, column: &str) -> Result<Self, StudyAxisError> {
        let model =
            UnitModel { calibration: self.model.calibration.clone(), ..self.axis_alone(column)?.into() };
        let index = self.axes.iter().position(|report| report.column == column);
        let of_axis = |step: &StudyStep| StudyStep {
            name: step.name.clone(),
            errors: index.and_then(|index| step.errors.get(index)).cloned().into_iter().collect(),
        };
        Ok(Self {
            schema: self.schema.clone(),
            tool: self.tool.clone(),
            data: self.data.clone(),
            settings: self.settings.clone(),
            model,
            axes: self.axes.iter().filter(|report| report.column == column).cloned().collect(),
            steps: self.steps.iter().map(of_axis).collect(),
            refinements: Vec::new(),
        })
    }

    /// Stores `refinement`, and puts its last state into the model.
    pub fn keep(&mut self, refinement: Refinement) {
        if let Some(last) = refinement.last() {
            self.replace(&refinement.column, last.model.clone());
        }
        match self.refinements.iter_mut().find(|other| other.column == refinement.column) {
            Some(known) => *known = refinement,
            None => self.refinements.push(refinement),
        }
    }

    /// Removes the last effect that was added to `column`; returns its identifier.
    pub fn undo(&mut self, column: &str) -> Result<String, StudyAxisError> {
        let nothing = || StudyAxisError::NothingAdded(column.to_owned());
        let refinement =
            self.refinements.iter_mut().find(|refinement| refinement.column == column).ok_or_else(nothing)?;
        let added = refinement.last().and_then(|step| step.added.as_ref()).ok_or_else(nothing)?;
        let effect = added.effect.id.clone();
        refinement.steps.pop();
        let refinement = refinement.clone();
        self.keep(refinement);
        Ok(effect)
    }

    fn replace(&mut self, column: &str, model: SingleAxisModel) {
        let axes = (0..self.model.axes.len()).map(|index| {
            let alone =
                if self.model.axes[index].column == column { model.clone() } else { self.model.only(index) };
            alone.into()
        });
        if let Some(joined) = UnitModel::joined(axes) {
            let calibration = self.model.calibration.take();
            self.model = UnitModel { calibration, ..joined };
        }
    }
}
