//! Reasons why a log gives no calibration.

use crate::triad::UNKNOWNS;

/// A log that cannot be calibrated from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    #[error(
        "{path}: neither ax_mps2, ay_mps2, az_mps2 nor gx_rads, gy_rads, gz_rads as numbers, nor the same in counts (ax_cnt …); \
         columns: {}\nhelp: name them in the column map, as in ax_mps2=acc_x:g; counts need no scale, as in ax_cnt=raw_x",
        columns.join(", ")
    )]
    NoTriad { path: String, columns: Vec<String> },
    #[error(
        "{column} repeats one value, {value:?}: stuck or not connected\nhelp: check the wiring, the driver and the column map of this axis"
    )]
    StuckAxis { column: String, value: f64 },
    #[error(
        "no accelerometer with three axes: gravity is the reference of a calibration by hand\nhelp: a gyro alone is calibrated on a turntable, with `rate_table`"
    )]
    NoAccelerometer,
    #[error(
        "no rest of at least {shortest_s:.1} s in {duration_s:.0} s\nhelp: lay the device down in each orientation and take the hand away for 3 s"
    )]
    NoRest { shortest_s: f64, duration_s: f64 },
    #[error(
        "{}: bias and sensitivity are indistinguishable\n\
         help: record 12 orientations or more: each face down once, and six askew on edges and corners; next: {next}",
        if *rests == 1 { "one rest in one orientation".to_owned() } else { format!("all {rests} rests lie within {spread_deg:.0}° of one orientation") }
    )]
    OneOrientation { rests: usize, spread_deg: f64, next: String },
    #[error(
        "{orientations} distinct orientations for {UNKNOWNS} unknowns leave no redundancy: the residual would be 0 and the \
         intervals unknown{excluded}\nhelp: record {more} more at least; next: {next}"
    )]
    NoRedundancy { orientations: usize, more: usize, next: String, excluded: String },
    #[error("not identifiable from these orientations: {}\nhelp: record {next}", parameters.join(", "))]
    NotIdentifiable { parameters: Vec<String>, next: String },
    #[error(
        "the accelerometer shows {found:.3} m/s² at rest, not gravity ({gravity:.3} m/s²){excluded}\n\
         help: {}",
        if *found < 2.0 { "if its unit is g, name it in the column map, as in ax_mps2=ax_mps2:g; values without gravity (linear acceleration) cannot be calibrated" }
        else { "name the unit in the column map, as in ax_mps2=ax_mps2:mg, or pass counts as ax_cnt, ay_cnt, az_cnt" }
    )]
    NotGravity { found: f64, gravity: f64, excluded: String },
    #[error(
        "no ellipsoid fits the rests: after {iterations} iterations the residual is {residual_mps2:.2} m/s²\nhelp: check the units and the order of the axes; record again with 3 s of rest in each orientation"
    )]
    NoFit { iterations: usize, residual_mps2: f64 },
    #[error(
        "no gyro with three axes in the log: a turntable calibrates gyros\nhelp: name its columns in the column map, as in gx_rads=gyro_x:dps"
    )]
    NoGyro,
    #[error(
        "no stretch of constant rate near {} rad/s; constant rates found: {}\nhelp: check the stated rate and the unit of the gyro; a plateau lasts {shortest_s:.1} s at least",
        listed(stated), if found.is_empty() { "none".to_owned() } else { listed(found) }
    )]
    NoPlateau { stated: Vec<f64>, found: Vec<f64>, shortest_s: f64 },
    #[error(
        "{plateaus} plateaus leave {degrees_of_freedom:.1} degrees of freedom, {FEWEST_DEGREES} are needed for intervals\n\
         help: record {more} more at least, in other orientations on the turntable{}",
        if *has_rest { "" } else { ", and 10 s at rest for the bias" }
    )]
    FewPlateaus { plateaus: usize, degrees_of_freedom: f64, more: usize, has_rest: bool },
    #[error("{rate} rad/s is no rate of a turntable\nhelp: state its magnitude, as in 33.3333rpm or 90dps")]
    BadRate { rate: f64 },
}

/// Fewest degrees of freedom of a turntable calibration: with 3, Student's t is 1.6 times the normal quantile, with 1 6.5 times.
pub(crate) const FEWEST_DEGREES: usize = 3;

fn listed(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.4}")).collect::<Vec<_>>().join(", ")
}
