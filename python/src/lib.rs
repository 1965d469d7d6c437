//! Engine of the Python package `fos_imu`: logs, fits, studies, diagnoses, noise, the predictor of a device. It
//! exchanges arrays and JSON; the public classes are in `python/fos_imu`.
//!
//! | file | subject |
//! |---|---|
//! | `error` | errors of the engine as exceptions, with file, line, column and remedy |
//! | `work` | a long call on its own thread: other threads continue, Ctrl-C ends it |
//! | `arrays` | NumPy arrays as columns of a log, and back |
//! | `recording`, `simulation` | logs |
//! | `figures` | figures of results as SVG |
//! | `calibration` | calibration by hand and on a turntable |
//! | `options`, `study`, `diagnosis`, `noise` | fits, added effects, findings, noise levels |
//! | `fleet` | a row for each unit, and populations of the rows |
//! | `predictor` | an image on fos-core in f32 |
//! | `series` | a model of any output and inputs, for the regressor |

#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod arrays;
mod calibration;
mod diagnosis;
mod error;
mod figures;
mod fleet;
mod noise;
mod options;
mod predictor;
mod recording;
mod series;
mod simulation;
mod study;
mod work;

use pyo3::prelude::*;

/// The engine.
#[pymodule]
mod _engine {
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "that is its name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use crate::calibration::{calibrate, calibrate_on_turntable};
    #[pymodule_export]
    use crate::diagnosis::{diagnose, effects};
    #[pymodule_export]
    use crate::figures::draw;
    #[pymodule_export]
    use crate::fleet::{Fleet, Rows, recording_row, unit_row};
    #[pymodule_export]
    use crate::noise::{imu_yaml, noise};
    #[pymodule_export]
    use crate::options::fit_defaults;
    #[pymodule_export]
    use crate::predictor::{Predictor, validity_names};
    #[pymodule_export]
    use crate::recording::{Recording, formats, load};
    #[pymodule_export]
    use crate::series::{SeriesModel, fit_series};
    #[pymodule_export]
    use crate::simulation::{simulate, simulate_case};
    #[pymodule_export]
    use crate::study::{Evaluated, Study, fit, load_study};
}
