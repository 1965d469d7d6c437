//! Calibration of a study's device by hand.

use fos_core::FittedOn;
use fos_data::column::Triad;
use fos_data::recording::{Recording, SensorProvenance, Values};
use fos_fit::calibration::UnitCalibration;

use super::Study;

/// A calibration that does not go with a study.
#[derive(Debug, thiserror::Error)]
#[error(
    "{log} does not go with the study: the study's {triad} is {study}, that of the log {found}\nhelp: calibrate with a log of the same sensor, recorded in the same way"
)]
pub struct OtherDevice {
    log: String,
    triad: &'static str,
    study: String,
    found: String,
}

impl Study {
    /// Adds a calibration made from `log`, or replaces the one that the study has.
    pub fn calibrate(&mut self, calibration: UnitCalibration, log: &Recording) -> Result<(), OtherDevice> {
        let triads = [(Triad::Accelerometers, "accelerometer"), (Triad::Gyros, "gyro")];
        let other =
            triads.into_iter().find_map(|(triad, name)| Some((name, self.contradiction(log, triad)?)));
        if let Some((triad, [study, found])) = other {
            return Err(OtherDevice { log: log.paths(), triad, study, found });
        }
        self.model.calibration = Some(calibration);
        Ok(())
    }

    /// Returns a property of a triad in the study and the other one in the log, if they are not of one sensor recorded in
    /// the same way.
    pub(crate) fn contradiction(&self, log: &Recording, triad: Triad) -> Option<[String; 2]> {
        let mut known = SensorProvenance::of_sources(&self.data.sources, triad);
        // the log format does not state whether values are raw; the model does
        if known.values == Values::Unstated && self.model.fitted_on == FittedOn::Raw {
            known.values = Values::Raw;
        }
        known.contradiction(&log.provenance(triad))
    }
}
