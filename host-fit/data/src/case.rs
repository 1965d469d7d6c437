//! A case: a folder with up to three logs of one device and their metadata.

use crate::column::Column;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::file::{self, FileError};
use crate::recording::{LoadOptions, Recording, RecordingError, load};
use crate::schema::{Refused, from_json};
use crate::unit::MG_MPS2;

/// The schema that this program writes, and the only one it reads.
pub const SCHEMA: &str = "fos-case/1";

/// `meta.json` of a case folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseMeta {
    /// [`SCHEMA`]; optional in a description written by hand.
    #[serde(default = "this_schema")]
    pub schema: String,
    pub case: String,
    /// Column to be explained.
    pub target: String,
    #[serde(default)]
    pub device: String,
    /// Description of how the device was used.
    #[serde(default)]
    pub setup: String,
    /// Nominal sample rate, Hz.
    pub nominal_rate_hz: f64,
    /// Full scale of the accelerometers, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_full_scale_mps2: Option<f64>,
    /// Full scale of the gyros, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_full_scale_rads: Option<f64>,
    /// Least significant bit of the accelerometers, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_lsb_mps2: Option<f64>,
    /// Least significant bit of the gyros, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_lsb_rads: Option<f64>,
    /// Figures of the data sheet.
    #[serde(default)]
    pub datasheet: DataSheetFigures,
    /// Names of the logs, without ending.
    pub files: CaseFiles,
    /// Description of the logs.
    #[serde(default)]
    pub note: String,
}

/// Noise of an axis on its data sheet, in the axis' unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DataSheet {
    /// Noise density, one-sided, unit/√Hz.
    pub noise_density: f64,
    /// Bias instability B, unit.
    pub bias_instability: f64,
}

/// Figures of a data sheet as they are printed there; any may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DataSheetFigures {
    /// Noise density of the gyros, °/s/√Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_noise_density_dps_rthz: Option<f64>,
    /// Noise density of the accelerometers, µg/√Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_noise_density_ug_rthz: Option<f64>,
    /// Bias instability of the gyros, °/h.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_bias_instability_dph: Option<f64>,
    /// Bias instability of the accelerometers, µg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_bias_instability_ug: Option<f64>,
    /// Temperature coefficient of the gyros, °/s/K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_tco_dps_per_k: Option<f64>,
    /// Temperature coefficient of the accelerometers, mg/K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_tco_mg_per_k: Option<f64>,
}

/// Names of the logs of a case, without ending; up to three.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CaseFiles {
    /// Name of the reference log, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// Name of the log to explain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// Name of the evaluation log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eval: Option<String>,
}

/// A case that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{}:{line}:{column}: not the description of a case: {reason}\nhelp: it needs \"case\", \"target\", \"nominal_rate_hz\" and \"files\"", path.display())]
    Meta {
        path: PathBuf,
        /// Line of the error, from 1.
        line: usize,
        /// Column of the error, from 1.
        column: usize,
        reason: String,
    },
    #[error(
        "{}: schema {found:?}; this program reads {SCHEMA:?}\nhelp: use the program that wrote it", path.display()
    )]
    Schema { path: PathBuf, found: String },
    #[error("{}: \"files\" names no \"field\": there is no log to explain\nhelp: name it, as in \"files\": {{ \"field\": \"log\" }}", path.display())]
    NoField { path: PathBuf },
    #[error("{}: there is none of {name}.parquet, {name}.csv.gz, {name}.csv\nhelp: put the log there, or remove it from \"files\"", folder.display())]
    NoLog { folder: PathBuf, name: String },
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// A case with its logs read.
#[derive(Debug, Clone)]
pub struct Case {
    pub meta: CaseMeta,
    /// Log without the missing effect, if any.
    pub reference: Option<Recording>,
    /// Log to explain.
    pub log: Recording,
    pub evaluation: Option<Recording>,
}

fn this_schema() -> String {
    SCHEMA.to_owned()
}

fn path_of(folder: &Path, name: &str) -> Result<PathBuf, CaseError> {
    let named = ["parquet", "csv.gz", "csv"].map(|ending| folder.join(format!("{name}.{ending}")));
    let found = named.into_iter().find(|path| path.exists());
    found.ok_or_else(|| CaseError::NoLog { folder: folder.to_owned(), name: name.to_owned() })
}

impl CaseMeta {
    /// Reads `meta.json` of a case folder.
    pub fn read(folder: &Path) -> Result<Self, CaseError> {
        let path = folder.join("meta.json");
        let bytes = file::read(&path)?;
        from_json(&bytes, SCHEMA).map_err(|refused| match refused {
            Refused::NotJson { line, column, reason } => CaseError::Meta { path, line, column, reason },
            Refused::Schema(found) => CaseError::Schema { path, found },
        })
    }

    /// Paths of the logs in `folder`, in the order of the roles.
    pub fn paths(&self, folder: &Path) -> Result<Vec<PathBuf>, CaseError> {
        let CaseFiles { baseline, field, eval } = &self.files;
        [baseline, field, eval].into_iter().flatten().map(|name| path_of(folder, name)).collect()
    }

    /// Returns true if the target is a gyro.
    fn is_gyro(&self) -> bool {
        Column::named(&self.target).is_angular_rate()
    }

    /// Full scale of the target, in its unit.
    pub fn full_scale(&self) -> Option<f64> {
        if self.is_gyro() { self.gyro_full_scale_rads } else { self.accel_full_scale_mps2 }
    }

    /// Least significant bit of the target, in its unit.
    pub fn lsb(&self) -> Option<f64> {
        if self.is_gyro() { self.gyro_lsb_rads } else { self.accel_lsb_mps2 }
    }

    /// Noise of the target on the data sheet, if it states both numbers.
    pub fn data_sheet(&self) -> Option<DataSheet> {
        const DPS: f64 = std::f64::consts::PI / 180.0;
        const MICRO_G: f64 = 1e-3 * MG_MPS2;
        let sheet = &self.datasheet;
        Some(match self.is_gyro() {
            true => DataSheet {
                noise_density: sheet.gyro_noise_density_dps_rthz? * DPS,
                bias_instability: sheet.gyro_bias_instability_dph? * DPS / 3600.0,
            },
            false => DataSheet {
                noise_density: sheet.accel_noise_density_ug_rthz? * MICRO_G,
                bias_instability: sheet.accel_bias_instability_ug? * MICRO_G,
            },
        })
    }
}

impl Case {
    /// Reads a case folder.
    pub fn read(folder: &Path) -> Result<Self, CaseError> {
        let meta = CaseMeta::read(folder)?;
        let log = |name: &Option<String>| -> Result<Option<Recording>, CaseError> {
            let Some(name) = name else { return Ok(None) };
            let path = path_of(folder, name)?;
            let options = LoadOptions { rate_hz: Some(meta.nominal_rate_hz), ..LoadOptions::default() };
            Ok(Some(load(path, &options)?))
        };
        let reference = log(&meta.files.baseline)?;
        let evaluation = log(&meta.files.eval)?;
        let log =
            log(&meta.files.field)?.ok_or_else(|| CaseError::NoField { path: folder.join("meta.json") })?;
        Ok(Self { meta, reference, log, evaluation })
    }
}
