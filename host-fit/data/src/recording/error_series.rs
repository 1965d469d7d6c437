//! Measured error of one axis.

use std::borrow::Cow;

use super::Recording;
use super::channel::Channel;
use super::error::RecordingError;
use crate::closest::closest;
use crate::column::{AXES, Column};
use crate::unit::Unit;

/// Measured error of one axis, before the offset is subtracted: y_raw(n) = measured(n) − reference(n).
#[derive(Clone, Debug)]
pub struct ErrorSeries<'a> {
    /// Name of the measured channel.
    pub channel: String,
    pub unit: Unit,
    /// One value per row, in `unit`; NaN where the measurement or the reference is missing.
    pub values: Cow<'a, [f64]>,
    pub reference: Reference,
}

impl ErrorSeries<'_> {
    /// Returns true if the values show the bias itself rather than only its changes; see
    /// [`Recording::is_bias_known`].
    pub fn is_bias_known(&self) -> bool {
        self.reference != Reference::Constant || !Column::named(&self.channel).is_specific_force()
    }
}

/// True value that the measurement is compared with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Nothing was subtracted: the log is static, and the constant true value becomes part of the offset.
    Constant,
    /// Name of the channel with the logged true value.
    Channel(String),
}

impl Recording {
    /// Channel of an axis, by its full name (`gx_rads`) or its short one (`gx`, `ay`).
    pub fn axis(&self, axis: &str) -> Result<&Channel, RecordingError> {
        let full = match axis {
            "ax" | "ay" | "az" => format!("{axis}_mps2"),
            "gx" | "gy" | "gz" => format!("{axis}_rads"),
            other => other.to_owned(),
        };
        self.channel(&full).map_err(|error| match error {
            RecordingError::NoChannel { name, closest: None, available } => {
                let short = available.iter().filter(|name| AXES.contains(&name.as_str()));
                let short = short.filter_map(|name| name.split('_').next());
                RecordingError::NoChannel {
                    closest: closest(&name, short).map(str::to_owned),
                    name,
                    available,
                }
            }
            error => error,
        })
    }

    /// Returns true if the log shows the bias of an axis itself rather than only its changes. An accelerometer at rest
    /// without a reference shows a component of gravity too, which depends on the orientation.
    pub fn is_bias_known(&self, column: &str) -> bool {
        !Column::named(column).is_specific_force() || self.channel(&Column::named(column).reference()).is_ok()
    }

    /// Measured minus reference for an axis (named as for [`Recording::axis`]). The reference is the channel
    /// `ref_<name>` if the log has it, else a constant.
    pub fn error_series(&self, axis: &str) -> Result<ErrorSeries<'_>, RecordingError> {
        let measured = self.axis(axis)?;
        let name = measured.column().reference();
        let truth = self.channels().iter().find(|channel| channel.name == name);
        for channel in [Some(measured), truth].into_iter().flatten() {
            if channel.values.iter().all(|value| !value.is_finite()) {
                let (path, name, rows) = (self.paths(), channel.name.clone(), self.n_rows());
                return Err(RecordingError::NoValues { path, name, rows });
            }
        }
        let (values, reference) = match truth {
            None => (Cow::Borrowed(&measured.values[..]), Reference::Constant),
            Some(truth) => {
                let difference =
                    measured.values.iter().zip(truth.values.iter()).map(|(m, r)| m - r).collect();
                (Cow::Owned(difference), Reference::Channel(name))
            }
        };
        Ok(ErrorSeries { channel: measured.name.clone(), unit: measured.unit, values, reference })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Source};
    use super::*;

    fn recording(names: &[&str]) -> Recording {
        let columns =
            names.iter().enumerate().map(|(i, name)| (name.to_string(), vec![i as f64; 3])).collect();
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    #[test]
    fn the_reference_is_subtracted_where_there_is_one() {
        let log = recording(&["ref_gx_rads", "gx_rads"]);
        let error = log.error_series("gx").unwrap();
        assert_eq!(*error.values, [1.0; 3]);
        assert_eq!(error.reference, Reference::Channel("ref_gx_rads".into()));
    }

    #[test]
    fn error_without_a_reference_is_the_measurement() {
        let log = recording(&["ref_gy_rads", "gx_rads"]);
        let error = log.error_series("gx_rads").unwrap();
        assert_eq!(*error.values, [1.0; 3]);
        assert_eq!(error.reference, Reference::Constant);
    }

    #[test]
    fn rejects_a_channel_without_a_number_by_name() {
        // the message used to state "0 rows at rest" and advise a longer log
        for (hollow, expected) in
            [("gx_rads", "test: gx_rads: every cell of its 3 rows"), ("ref_gx_rads", "ref_gx_rads: every")]
        {
            let log = recording(&["ref_gx_rads", "gx_rads"]).with_values(hollow, vec![f64::NAN; 3]);
            let message = log.error_series("gx").unwrap_err().to_string();
            assert!(message.contains(expected) && message.contains("help: "), "{message}");
        }
    }

    #[test]
    fn unknown_axis_suggests_the_closest() {
        let message = recording(&["gx_rads", "temp_c"]).error_series("gy").unwrap_err().to_string();
        assert!(message.contains("did you mean \"gx_rads\"?"), "{message}");
    }
}
