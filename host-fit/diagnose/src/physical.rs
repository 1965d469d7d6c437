//! Output of the physical part of a model over a log, and the log converted to the orientation of the fit.

use fos_core::{Axis, OTHER_POSE};
use fos_data::column::Column;
use fos_data::pose;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;

/// Error of running the physical part.
#[derive(Debug, thiserror::Error)]
pub enum PhysicalError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// fos-core refuses the model.
    #[error("the model cannot be run: {0}")]
    Model(#[from] fos_core::ModelError),
}

/// Returns the output of the physical part of each axis without its offset, in the unit of the axis, one value per row
/// of `log`.
pub(crate) fn physical(
    model: &UnitModel,
    log: &Recording,
    known: &[bool],
) -> Result<Vec<Vec<f64>>, PhysicalError> {
    if model.axes.iter().all(|axis| axis.physical.is_empty()) {
        return Ok(vec![vec![0.0; log.n_rows()]; model.axes.len()]);
    }
    let playback = Playback::new(log, model, known)?;
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

/// Returns the log as if the device had lain in the orientation of the fit in all dwells. In another orientation an
/// accelerometer without a reference has another constant, and only changes of its error are modelled. `None` if
/// gravity never turned.
pub(crate) fn in_known_pose(
    model: &UnitModel,
    log: &Recording,
    stillness: &Stillness,
) -> Result<Option<Recording>, PhysicalError> {
    let has_reference = |column: &str| log.channel(&Column::named(column).reference()).is_ok();
    let is_accelerometer = |axis: Axis| matches!(axis, Axis::Ax | Axis::Ay | Axis::Az);
    let places: Vec<usize> = (0..model.axes.len())
        .filter(|place| {
            is_accelerometer(model.axes[*place].parameters.axis) && !has_reference(&model.axes[*place].column)
        })
        .collect();
    if stillness.turns.is_empty() || places.is_empty() {
        return Ok(None);
    }
    let explained = physical(model, log, &stillness.still)?;
    let mut other = log.clone();
    for place in places {
        let axis = &model.axes[place];
        let (reference, scale) = (axis.parameters.reference + axis.parameters.offset, axis.parameters.scale);
        let is_fitted_orientation = |level: f64| (level - reference).abs() <= OTHER_POSE * scale;
        let wanted = |level| if is_fitted_orientation(level) { level } else { reference };
        let values = &log.channel(&axis.column)?.values;
        let moved = pose::with_levels(values, &explained[place], &stillness.still, &stillness.turns, wanted);
        other = other.with_values(&axis.column, moved);
    }
    Ok(Some(other))
}
