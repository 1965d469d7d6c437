//! Rows of a fleet: what populations need of them, in one order whatever order they came in.

use serde_json::to_vec;
use sha2::{Digest, Sha256};

use crate::estimate::EstimateError;
use crate::row::{Asked, AxisRow, UnitRow};

/// Rows that do not form a fleet.
#[derive(Debug, thiserror::Error)]
pub enum GatheredError {
    #[error("the fleet is empty\nhelp: give a row for each device")]
    Nothing,
    #[error(
        "the devices {first:?} and {other:?} were asked different things: {what}\nhelp: ask all devices for the same regressors, diagnosed or not, and read all logs alike"
    )]
    Asked { first: String, other: String, what: String },
    #[error(
        "the device {unit:?}{} is there twice\nhelp: one row for each device of a part; name them apart, as `lot/unit`, and give all logs of one to one row",
        suffix_of_part(part)
    )]
    Twice { unit: String, part: String },
    #[error(
        "the row of {unit:?}: {column}: a number is missing or not finite\nhelp: use the rows of this version as they were made"
    )]
    NotWhole { unit: String, column: String },
    #[error(transparent)]
    Regressors(#[from] EstimateError),
}

fn suffix_of_part(part: &str) -> String {
    if part.is_empty() { String::new() } else { format!(" of {part:?}") }
}

/// Data of rows for [`Fleet`](crate::Fleet). The result has the same bits for any order of rows: nothing is summed before
/// all rows are present, and then in the order of part and unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathered {
    /// Settings of all rows; none without rows.
    asked: Option<Asked>,
    units: Vec<GatheredUnit>,
}

/// Data of a row for populations.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GatheredUnit {
    pub(crate) unit: String,
    pub(crate) part: String,
    pub(crate) lot: Option<String>,
    /// SHA-256 of the log, hexadecimal, for the detection of duplicates; empty if no log could be read.
    pub(crate) log_sha256: String,
    pub(crate) axes: Vec<AxisRow>,
    /// Reasons for missing results.
    pub(crate) failed: Vec<String>,
    /// SHA-256 of the row's JSON.
    pub(crate) digest: [u8; 32],
}

impl Gathered {
    pub fn len(&self) -> usize {
        self.units.len()
    }

    pub fn is_empty(&self) -> bool {
        self.units.is_empty()
    }

    /// Adds a row.
    ///
    /// A row with other settings or without a number is refused and not added.
    pub fn add(&mut self, row: UnitRow) -> Result<(), GatheredError> {
        // Rows from a file do not record the strictness of the read.
        let mut asked = row.asked.clone();
        asked.read.strict = false;
        if let (Some(of_first), Some(first)) = (&self.asked, self.units.first())
            && asked != *of_first
        {
            let (first, what) = (first.unit.clone(), difference(of_first, &asked));
            return Err(GatheredError::Asked { first, other: row.unit, what });
        }
        if let Some(axis) = row.axes.iter().find(|axis| !axis.estimate.is_complete()) {
            let column = axis.estimate.column.clone();
            return Err(GatheredError::NotWhole { unit: row.unit, column });
        }
        self.asked.get_or_insert(asked);
        self.units.push(GatheredUnit::of(row));
        Ok(())
    }

    /// Settings of all rows.
    pub(crate) fn asked(&self) -> Result<&Asked, GatheredError> {
        self.asked.as_ref().ok_or(GatheredError::Nothing)
    }

    /// Units by part and name.
    pub(crate) fn in_order(&self) -> Vec<&GatheredUnit> {
        sorted(&self.units)
    }

    /// Units by part and name, each once.
    pub(crate) fn each_once(&self) -> Result<Vec<&GatheredUnit>, GatheredError> {
        let units = self.in_order();
        let twice =
            units.windows(2).find(|pair| (&pair[0].part, &pair[0].unit) == (&pair[1].part, &pair[1].unit));
        match twice {
            Some(pair) => {
                Err(GatheredError::Twice { unit: pair[0].unit.clone(), part: pair[0].part.clone() })
            }
            None => Ok(units),
        }
    }
}

/// Returns units by part and name. The digest orders units of the same name, where duplicates are allowed.
pub(crate) fn sorted(units: &[GatheredUnit]) -> Vec<&GatheredUnit> {
    let mut sorted: Vec<&GatheredUnit> = units.iter().collect();
    sorted.sort_by(|a, b| (&a.part, &a.unit, a.digest).cmp(&(&b.part, &b.unit, b.digest)));
    sorted
}

impl GatheredUnit {
    pub(crate) fn of(row: UnitRow) -> Self {
        let digest = Sha256::digest(to_vec(&row).expect("rows have only string keys")).into();
        let UnitRow { unit, part, lot, sha256, axes, failed, .. } = row;
        Self { unit, part, lot, log_sha256: sha256, axes, failed, digest }
    }

    /// Number of identified coefficients over all axes.
    pub(crate) fn coefficients(&self) -> usize {
        self.axes.iter().map(|axis| axis.estimate.coefficients.names.len()).sum()
    }

    pub(crate) fn axis(&self, column: &str) -> Option<&AxisRow> {
        self.axes.iter().find(|axis| axis.estimate.column == column)
    }
}

fn difference(first: &Asked, other: &Asked) -> String {
    if first.regressors != other.regressors {
        format!("regressors {:?} and {:?}", first.regressors, other.regressors)
    } else if first.diagnosed != other.diagnosed {
        format!("diagnosed {} and {}", first.diagnosed, other.diagnosed)
    } else {
        "other columns, rate, format or sensor of the log".to_owned()
    }
}
