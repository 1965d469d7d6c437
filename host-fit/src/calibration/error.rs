//! Why a calibration ends without figures.

use fos_data::file::FileError;
use fos_simulate::PlanError;

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// A case cannot be simulated.
    #[error("case {case}: {source}")]
    Plan {
        /// Its number.
        case: usize,
        /// Why.
        source: PlanError,
    },
    /// A case cannot be diagnosed.
    #[error("case {case}: {source}")]
    Diagnose {
        /// Its number.
        case: usize,
        /// Why.
        source: Box<fos_diagnose::detect::DiagnoseError>,
    },
    /// What came out cannot be kept.
    #[error(transparent)]
    File(#[from] FileError),
}
