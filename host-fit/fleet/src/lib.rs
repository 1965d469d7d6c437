#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod coefficient;
mod estimate;
mod fleet;
mod folder;
mod gathered;
mod information;
mod odd;
mod population;
mod row;
mod rows;
mod ship;
mod tails;

pub use estimate::{AxisEstimate, BIAS, Estimate, EstimateError, REFERENCE_C, check_regressors, estimate};
pub use fleet::{
    AxisSummary, DuplicateUnit, EffectShare, FALSE_ODD, FailedUnit, Fleet, FleetError, OddUnit, PartSummary,
    SCHEMA,
};
pub use folder::{FolderError, UNITS, units_in};
pub use gathered::{Gathered, GatheredError};
pub use odd::{Assessment, Distance, FAR, assess, devices_needed, discoveries};
pub use population::{Lot, Member, Population, PopulationError, Scatter};
pub use row::{Asked, AxisDiagnosis, AxisRow, FoundEffect, LogSummary, Unit, UnitRow, row_of, unit_row};
pub use rows::{rows, rows_beside};
pub use ship::{ShipError, Shipment, ShippedUnit, known_of};

/// The program that makes rows and populations: the same version gives the same bits, from the command line, in Python, on a cluster.
pub const PROGRAM: &str = concat!("fos ", env!("CARGO_PKG_VERSION"));
