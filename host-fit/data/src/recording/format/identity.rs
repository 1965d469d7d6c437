//! Name of a format in options and studies, and the record of how a log was read.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::super::provenance::Provenance;
use super::known::{FormatKnowledge, KNOWN_FORMATS};
use super::names::Format;

#[derive(Debug, Error)]
#[error("\"{name}\": not a format that is known\nhelp: known are {known}")]
pub struct UnknownFormat {
    name: String,
    known: String,
}

impl Format {
    pub fn knowledge(self) -> &'static FormatKnowledge {
        // a test ensures that the list has every format
        KNOWN_FORMATS.iter().find(|known| known.format == self).unwrap_or(&KNOWN_FORMATS[0])
    }

    pub fn id(self) -> &'static str {
        self.knowledge().id
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.knowledge().name)
    }
}

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        let found = KNOWN_FORMATS.iter().find(|known| known.id == name).map(|known| known.format);
        found.ok_or_else(|| {
            let known: Vec<&str> = KNOWN_FORMATS.iter().map(|known| known.id).collect();
            UnknownFormat { name: name.to_owned(), known: known.join(", ") }
        })
    }
}

impl Serialize for Format {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.id())
    }
}

impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?.parse().map_err(serde::de::Error::custom)
    }
}

/// Format as which a log was read, and the assumptions made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ReadAs {
    #[cfg_attr(feature = "page-types", ts(as = "String"))]
    pub format: Format,
    /// Columns, units, clock, frame, gravity, corrections already applied: in words.
    pub assumed: String,
    /// Sensor, corrections and frame of the inertial values; absent in studies of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

impl fmt::Display for ReadAs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "read as {}: {}", self.format, self.assumed)?;
        match &self.provenance {
            Some(provenance) => write!(f, "; {provenance}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::known::{may_be_log, may_be_log_within};
    use super::*;

    #[test]
    fn every_format_is_known_by_its_name() {
        for known in KNOWN_FORMATS {
            assert_eq!(known.id.parse::<Format>().unwrap(), known.format);
            assert_eq!(known.format.id(), known.id);
        }
        // every listed ending may be a log
        for known in KNOWN_FORMATS {
            let files = known.files.split([',', ' ']).filter(|word| word.starts_with('.'));
            files.for_each(|ending| assert!(may_be_log(&format!("a{ending}")), "{}: {ending}", known.id));
        }
        assert!(may_be_log("LOG.BIN") && may_be_log("a.ulg.gz") && !may_be_log("a.gz") && !may_be_log("bin"));
        assert!(may_be_log_within("a/LOG.BIN") && may_be_log_within("a.ulg.gz") && may_be_log_within("a.gz"));
        assert!(
            !may_be_log_within("a.parquet") && !may_be_log_within("a.zip") && !may_be_log_within("a.yaml")
        );
        let error = "cvs".parse::<Format>().unwrap_err().to_string();
        assert!(error.contains("ulog, dataflash"), "{error}");
    }
}
