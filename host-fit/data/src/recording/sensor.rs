//! Provenance of a recording: the statements of its source logs, as far as they agree.

use super::provenance::SensorProvenance;
use super::source::Source;
use super::{Recording, RecordingError};
use crate::column::Triad;

impl SensorProvenance {
    /// Provenance of a triad common to all of these logs.
    pub fn of_sources(sources: &[Source], triad: Triad) -> Self {
        let of_source = |source: &Source| {
            let stated = source.read_as.as_ref().and_then(|read_as| read_as.provenance.as_ref());
            stated.map_or_else(Self::default, |stated| stated.of(triad).clone())
        };
        sources.iter().map(of_source).reduce(|one, other| one.common(&other)).unwrap_or_default()
    }
}

impl Recording {
    /// Provenance of a triad: that of the source log, or the common part of several joined logs.
    pub fn provenance(&self, triad: Triad) -> SensorProvenance {
        SensorProvenance::of_sources(&self.sources, triad)
    }

    /// Rejects a log of another sensor, or of differently corrected values.
    pub fn refuse_other_sensor(&self, next: &Self) -> Result<(), RecordingError> {
        for triad in [Triad::Accelerometers, Triad::Gyros] {
            if let Some([here, there]) = self.provenance(triad).contradiction(&next.provenance(triad)) {
                let sensor = match triad {
                    Triad::Accelerometers => "accelerometers",
                    Triad::Gyros => "gyros",
                };
                let (path, others) = (next.paths(), self.paths());
                let [here, there] = [here, there].map(String::into);
                return Err(RecordingError::OtherSensor { path, others, sensor, here, there });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::LoadOptions;
    use super::super::format::{Format, ReadAs};
    use super::super::provenance::{Frame, Provenance, Values};
    use super::*;

    fn recording(gyros: SensorProvenance) -> Recording {
        let provenance = Provenance { gyros, ..Provenance::default() };
        let read_as = ReadAs { format: Format::Ulog, assumed: String::new(), provenance: Some(provenance) };
        let source = Source { read_as: Some(read_as), ..Source::made_by("test") };
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        Recording::from_columns(source, vec![("gx_rads".to_owned(), vec![1.0; 30])], &options).unwrap()
    }

    fn raw(instance: u8, device_id: Option<u32>) -> SensorProvenance {
        SensorProvenance { instance: Some(instance), device_id, values: Values::Raw, frame: Frame::Board }
    }

    #[test]
    fn joins_logs_of_one_sensor_only() {
        let join = |one, other| Recording::join(vec![recording(one), recording(other)]);
        // an autopilot may number its sensors in another order after a restart
        let joined = join(raw(0, Some(7)), raw(1, Some(7))).unwrap();
        assert_eq!(joined.provenance(Triad::Gyros), SensorProvenance { instance: None, ..raw(0, Some(7)) });
        let corrected = SensorProvenance { values: Values::Corrected("PX4".into()), ..raw(0, Some(7)) };
        let vehicle = SensorProvenance { frame: Frame::Vehicle, ..raw(0, Some(7)) };
        for (other, expected) in [
            (raw(0, Some(8)), "device_id 8"),
            (corrected, "corrected by PX4"),
            (vehicle, "axes of the vehicle"),
        ] {
            let error = join(raw(0, Some(7)), other).unwrap_err().to_string();
            assert!(error.contains(expected) && error.contains("\nhelp: "), "{error}");
        }
        assert!(join(raw(0, None), raw(1, None)).unwrap_err().to_string().contains("IMU 1"));
        // the log format states no provenance, so the joined log has none
        let joined = join(raw(0, Some(7)), SensorProvenance::default()).unwrap();
        assert_eq!(joined.provenance(Triad::Gyros), SensorProvenance::default());
    }

    #[test]
    fn survives_a_study_file() {
        for sensor in [SensorProvenance::default(), raw(2, Some(2_818_058))] {
            let corrected = SensorProvenance { values: Values::Corrected("PX4".into()), ..sensor.clone() };
            let written = Provenance { accelerometers: sensor, gyros: corrected };
            let text = serde_json::to_string(&written).unwrap();
            assert_eq!(serde_json::from_str::<Provenance>(&text).unwrap(), written, "{text}");
        }
        // written by an earlier version
        let read: ReadAs = serde_json::from_str(r#"{"format": "ulog", "assumed": "…"}"#).unwrap();
        assert_eq!(read.provenance, None);
    }
}
