//! Rows that were made apart, in other processes or on other machines, brought together.

use std::collections::HashSet;

use crate::row::{Asked, UnitRow};

/// Why rows are no fleet.
#[derive(Debug, thiserror::Error)]
pub enum GatheredError {
    /// There is none.
    #[error("there is no row of a unit\nhelp: a row for each unit of the fleet")]
    Nothing,
    /// Two were asked different things.
    #[error(
        "the units {first:?} and {other:?} were asked different things: {what}\nhelp: ask all units for the same regressors, diagnosed or not, and read all logs alike"
    )]
    Asked {
        /// A unit.
        first: String,
        /// One that was asked something else.
        other: String,
        /// Both, in words.
        what: String,
    },
    /// A unit is there twice.
    #[error(
        "the unit {unit:?}{} is there twice\nhelp: one row for each unit of a part; name them apart, as `lot/unit`",
        of_part(part)
    )]
    Twice {
        /// Its name.
        unit: String,
        /// Its part.
        part: String,
    },
}

fn of_part(part: &str) -> String {
    if part.is_empty() { String::new() } else { format!(" of {part:?}") }
}

/// What all of `rows` were asked.
///
/// # Errors
///
/// There is no row, two were asked different things, a unit is there twice.
pub fn asked_of(rows: &[UnitRow]) -> Result<Asked, GatheredError> {
    let first = rows.first().ok_or(GatheredError::Nothing)?;
    // a row from a file does not know how strictly its log was read
    let asked = |row: &UnitRow| {
        let mut asked = row.asked.clone();
        asked.read.strict = false;
        asked
    };
    let of_first = asked(first);
    let mut seen = HashSet::new();
    for row in rows {
        if asked(row) != of_first {
            return Err(GatheredError::Asked {
                first: first.unit.clone(),
                other: row.unit.clone(),
                what: difference(&first.asked, &row.asked),
            });
        }
        if !seen.insert((&row.part, &row.unit)) {
            return Err(GatheredError::Twice { unit: row.unit.clone(), part: row.part.clone() });
        }
    }
    Ok(of_first)
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
