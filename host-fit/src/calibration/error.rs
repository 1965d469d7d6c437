//! Errors of a calibration.

use fos_data::file::FileError;
use fos_simulate::PlanError;

/// A calibration failed.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// A case cannot be simulated.
    #[error("case {case}: {source}")]
    Plan {
        /// Index in the suite, from 0.
        case: usize,
        /// Impossible part of the plan.
        source: PlanError,
    },
    /// A case cannot be diagnosed.
    #[error("case {case}: {source}")]
    Diagnose {
        /// Index in the suite, from 0.
        case: usize,
        /// Error of the diagnosis.
        source: Box<fos_diagnose::detect::DiagnoseError>,
    },
    /// An outcome cannot be stored.
    #[error(transparent)]
    File(#[from] FileError),
}
