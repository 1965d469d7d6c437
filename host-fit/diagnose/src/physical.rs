//! Output of the physical part of a model over a log, and the log converted to the orientation of the fit.

use std::borrow::Cow;

use fos_core::OTHER_POSE;
use fos_data::observed::ObservedAxis;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;

/// Error of running the physical part.
#[derive(Debug, thiserror::Error)]
pub enum PhysicalError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error("the model cannot be run: {0}")]
    Model(#[from] fos_core::ModelError),
}

/// Returns the output of the physical part of each axis without its offset, in the unit of the axis, one value per row
/// of `log`.
pub(crate) fn physical(model: &UnitModel, log: &Recording) -> Result<Vec<Vec<f64>>, PhysicalError> {
    if model.axes.iter().all(|axis| axis.physical.is_empty()) {
        return Ok(vec![vec![0.0; log.n_rows()]; model.axes.len()]);
    }
    // no row is tracked: the physical part does not depend on the measured error
    let tracked = vec![false; log.n_rows()];
    let playback = Playback::new(log, model, &tracked)?;
    let mut alone = model.clone();
    for axis in &mut alone.axes {
        axis.stochastic.clear();
        axis.parameters.constant = 0.0;
    }
    let mut predictor = alone.predictor::<f64>()?;
    let mut predicted = vec![Vec::with_capacity(log.n_rows()); model.axes.len()];
    let mut feed = playback.feed();
    for row in 0..log.n_rows() {
        playback.catch_up(&mut predictor, row);
        let corrections = feed.coast(&mut predictor, row);
        for ((predicted, correction), axis) in predicted.iter_mut().zip(corrections).zip(&alone.axes) {
            predicted.push(correction.predicted - axis.parameters.offset);
        }
    }
    Ok(predicted)
}

/// A log as if the device had lain in the orientation of the fit throughout.
pub(crate) struct InFittedPose<'a> {
    pub(crate) log: Cow<'a, Recording>,
    /// Axes that lay in another orientation for some of the time.
    pub(crate) turned: Vec<String>,
}

/// Returns the log as if the device had lain in the orientation of the fit in all dwells. In another orientation an
/// accelerometer without a reference has another constant, and only changes of its error are modelled.
pub(crate) fn in_fitted_pose<'a>(
    model: &UnitModel,
    log: &'a Recording,
    stillness: &Stillness,
) -> Result<InFittedPose<'a>, PhysicalError> {
    let has_level = |place: &usize| !log.is_bias_known(&model.axes[*place].column);
    let places: Vec<usize> = (0..model.axes.len()).filter(has_level).collect();
    let mut posed = InFittedPose { log: Cow::Borrowed(log), turned: Vec::new() };
    if places.is_empty() {
        return Ok(posed);
    }
    let explained = physical(model, log)?;
    for place in places {
        let axis = &model.axes[place];
        let (reference, scale) = (axis.parameters.reference + axis.parameters.offset, axis.parameters.scale);
        let mut has_turned = false;
        let wanted = |level: f64| {
            let is_other = (level - reference).abs() > OTHER_POSE * scale;
            has_turned |= is_other;
            if is_other { reference } else { level }
        };
        let observed = ObservedAxis::at_rest(log, stillness, &axis.column)?;
        let moved = observed.with_levels(&explained[place], wanted);
        if has_turned {
            posed.log = Cow::Owned(posed.log.with_values(&axis.column, moved));
            posed.turned.push(axis.column.clone());
        }
    }
    Ok(posed)
}
