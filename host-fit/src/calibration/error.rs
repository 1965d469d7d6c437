//! Why a calibration ends without figures.

use fos_data::file::FileError;
use fos_simulate::PlanError;

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// A case cannot be simulated.
    #[error("case {case}: {source}")]
    Plan {
        /// Place in the suite, from 0.
        case: usize,
        /// What of its plan is impossible.
        source: PlanError,
    },
    /// A case cannot be diagnosed.
    #[error("case {case}: {source}")]
    Diagnose {
        /// Place in the suite, from 0.
        case: usize,
        /// Why there is no answer.
        source: Box<fos_diagnose::detect::DiagnoseError>,
    },
    /// What came out cannot be kept.
    #[error(transparent)]
    File(#[from] FileError),
}
