//! A fleet read back: its populations, and the rows beside them.

use std::path::{Path, PathBuf};

use fos_data::file::{FileError, read};
use fos_data::statistics::median_of;

use crate::fleet::{AxisSummary, Fleet, Kept, SCHEMA};
use crate::population::Population;
use crate::row::{AxisRow, UnitRow};

/// Relative difference of what was written and read and is computed anew: some roundings.
const ROUNDING: f64 = 1e-9;

/// Why a fleet cannot be read back.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// A file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// There are no rows.
    #[error(
        "{source}\nhelp: the rows of a population lie beside it; move both, or make the population of its logs again"
    )]
    NoRows {
        /// As the system says.
        source: FileError,
    },
    /// A file that holds something else.
    #[error("{}: no population: {reason}\nhelp: make it of its logs again", path.display())]
    Population {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A line that is no row.
    #[error("{}:{line}: no row of a unit: {reason}\nhelp: make the population of its logs again; rows that are whole are taken over", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// Rows of other logs, or of another time.
    #[error("{}: rows of another population than {}: {reason}\nhelp: make the population of its logs again, which writes both", rows.display(), population.display())]
    OfAnother {
        /// The rows.
        rows: PathBuf,
        /// The population.
        population: PathBuf,
        /// By what it shows.
        reason: String,
    },
}

/// Where the rows of the population `population` are kept: beside it, under its name with `.rows` behind it.
pub fn rows_beside(population: &Path) -> PathBuf {
    let mut path = population.as_os_str().to_owned();
    path.push(".rows");
    path.into()
}

impl Fleet {
    /// What was written to `path`.
    ///
    /// # Errors
    ///
    /// It cannot be read, is of another schema, or its populations are not whole.
    pub fn read(path: &Path) -> Result<Self, StoredError> {
        let wrong = |reason: String| StoredError::Population { path: path.to_owned(), reason };
        let fleet: Self = serde_json::from_slice(&read(path)?).map_err(|error| wrong(error.to_string()))?;
        if fleet.schema != SCHEMA {
            return Err(wrong(format!("its schema is {:?}, and not {SCHEMA:?}", fleet.schema)));
        }
        for axis in fleet.parts.iter().flat_map(|part| &part.axes) {
            if axis.population.as_ref().is_some_and(|population| !is_whole(population)) {
                return Err(wrong(format!("{}: not every coefficient has its numbers", axis.column)));
            }
        }
        Ok(fleet)
    }

    /// The rows that this fleet, read from `population`, is of.
    ///
    /// # Errors
    ///
    /// They are not there, cannot be read, or are those of another fleet.
    pub fn read_rows(&self, population: &Path) -> Result<Vec<UnitRow>, StoredError> {
        let path = rows_beside(population);
        let bytes = read(&path).map_err(|source| StoredError::NoRows { source })?;
        let mut rows = Vec::new();
        for (index, line) in
            bytes.split(|byte| *byte == b'\n').enumerate().filter(|(_, line)| !line.is_empty())
        {
            let wrong = |reason: String| StoredError::Row { path: path.clone(), line: index + 1, reason };
            let row = serde_json::from_slice::<Kept>(line).map_err(|error| wrong(error.to_string()))?.row;
            if let Some(axis) = row.axes.iter().find(|axis| !is_square(axis)) {
                let column = &axis.estimate.column;
                return Err(wrong(format!("{column}: not every coefficient has its numbers")));
            }
            rows.push(row);
        }
        let another =
            |reason| StoredError::OfAnother { rows: path, population: population.to_owned(), reason };
        self.is_of(&rows).map_err(another)?;
        Ok(rows)
    }

    /// Whether it is what `rows` come to, by what can be held against them without estimating anew; else what shows that it is not.
    fn is_of(&self, rows: &[UnitRow]) -> Result<(), String> {
        if rows.len() != self.units {
            return Err(format!("{} rows, and a population of {} units", rows.len(), self.units));
        }
        if let Some(row) = rows.iter().find(|row| self.parts.iter().all(|part| part.part != row.part)) {
            return Err(format!(
                "the unit {:?} is of the part {:?}, which it does not have",
                row.unit, row.part
            ));
        }
        let failed = rows.iter().filter(|row| !row.failed.is_empty()).count();
        if failed != self.failed.len() {
            return Err(format!(
                "{failed} rows of units that tell not everything, and {} there",
                self.failed.len()
            ));
        }
        for part in &self.parts {
            let of_part = || rows.iter().filter(|row| row.part == part.part);
            for axis in &part.axes {
                let column = &axis.column;
                let of_axis: Vec<&AxisRow> = of_part()
                    .flat_map(|row| &row.axes)
                    .filter(|found| found.estimate.column == *column)
                    .collect();
                if !has_noise_of(axis, &of_axis) {
                    return Err(format!("{column}: its median noise is not that of the rows"));
                }
                let members = axis.population.as_ref().map_or(0, |population| population.units);
                if members > of_axis.len() {
                    return Err(format!("{column}: {members} units, of which {} have rows", of_axis.len()));
                }
            }
            let has_row = |unit: &str| of_part().any(|row| row.unit == unit);
            if let Some(odd) = part.odd.iter().find(|odd| !has_row(&odd.unit)) {
                return Err(format!("the unit {:?} has no row", odd.unit));
            }
        }
        Ok(())
    }
}

/// Medians over the rows, of numbers that no two logs share: those of other rows are others.
fn has_noise_of(axis: &AxisSummary, rows: &[&AxisRow]) -> bool {
    let levels = [
        median_of(rows.iter().map(|row| row.estimate.noise.white)),
        median_of(rows.iter().map(|row| row.estimate.noise.flicker)),
        median_of(rows.iter().map(|row| row.estimate.noise.walk)),
    ];
    let is_near = |stored: f64, now: f64| (stored - now).abs() <= ROUNDING * now.abs();
    axis.median_noise.iter().zip(levels).all(|(stored, now)| is_near(*stored, now.unwrap_or(0.0)))
}

fn is_square(axis: &AxisRow) -> bool {
    let estimate = &axis.estimate.coefficients;
    let n = estimate.names.len();
    estimate.values.len() == n && has_size(&estimate.covariance, n)
}

fn is_whole(population: &Population) -> bool {
    let n = population.names.len();
    let matrices = [&population.mean_covariance, &population.between_lots, &population.between_units];
    n > 0
        && population.mean.len() == n
        && population.scatter.len() == n
        && matrices.iter().all(|matrix| has_size(matrix, n))
        && population.lots.iter().all(|lot| lot.mean.len() == n && has_size(&lot.covariance, n))
}

fn has_size(matrix: &[Vec<f64>], n: usize) -> bool {
    matrix.len() == n && matrix.iter().all(|row| row.len() == n)
}
