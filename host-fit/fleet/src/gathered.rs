//! The part of the rows that populations need: a fifth of their memory, merged from processes and machines in any order.

use std::ops::Range;

use indexmap::IndexSet;
use serde::{Deserialize, Serialize};
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::estimate::{Estimate, EstimateError};
use crate::row::{Asked, AxisRow, UnitRow};

/// Schema of [`Gathered::to_bytes`].
const SCHEMA: &str = "fos-gathered/2";

/// Bytes of the digest of a log: enough that no two logs share one by chance.
const LOG_DIGEST: usize = 16;

/// Noise levels per axis: white noise, flicker and random walk.
const LEVELS: usize = 3;

/// Rows that do not form a fleet.
#[derive(Debug, thiserror::Error)]
pub enum GatheredError {
    #[error("the fleet is empty\nhelp: give a row for each device")]
    Nothing,
    /// Two units have different settings.
    #[error(
        "the devices {first:?} and {other:?} were asked different things: {what}\nhelp: ask all devices for the same regressors, diagnosed or not, and read all logs alike"
    )]
    Asked {
        first: String,
        /// A unit with other settings.
        other: String,
        /// Description of both settings.
        what: String,
    },
    /// A unit occurs twice.
    #[error(
        "the device {unit:?}{} is there twice\nhelp: one row for each device of a part; name them apart, as `lot/unit`, and give all logs of one to one row",
        suffix_of_part(part)
    )]
    Twice { unit: String, part: String },
    /// A row lacks numbers.
    #[error(
        "the row of {unit:?}: {column}: a number is missing or not finite\nhelp: use the rows of this version as they were made"
    )]
    NotWhole { unit: String, column: String },
    /// The regressors of the rows are invalid.
    #[error(transparent)]
    Regressors(#[from] EstimateError),
    /// Bytes that are not gathered rows.
    #[error("not gathered rows: {0}\nhelp: gather the rows again with this version")]
    NotGathered(String),
}

fn suffix_of_part(part: &str) -> String {
    if part.is_empty() { String::new() } else { format!(" of {part:?}") }
}

/// Data of rows for [`Fleet`](crate::Fleet). The result has the same bits for any order of rows and merges: nothing is summed before all
/// rows are present, and then in the order of part and unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathered {
    /// Settings of all rows; none without rows.
    asked: Option<Asked>,
    /// Distinct names (columns, coefficients, effects, parts, lots).
    texts: IndexSet<String>,
    /// Distinct sets of axes and coefficients.
    shapes: IndexSet<Shape>,
    units: Vec<StoredUnit>,
}

/// Axes of a unit, in the order of their numbers.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
struct Shape(Vec<AxisShape>);

#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
struct AxisShape {
    column: u32,
    names: Vec<u32>,
    diagnosed: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct StoredUnit {
    unit: Box<str>,
    part: u32,
    lot: Option<u32>,
    /// Index of the shape.
    shape: u32,
    /// SHA-256 of the row's JSON.
    digest: [u8; 32],
    /// First bytes of the SHA-256 of the row's `sha256`; none if no log could be read.
    log: Option<[u8; LOG_DIGEST]>,
    /// For each axis the coefficients, the lower triangle of their covariance by rows, and the noise levels.
    numbers: Box<[f64]>,
    /// Effects found on the axes.
    found: Box<[FoundOnAxis]>,
    failed: Box<[String]>,
}

/// An effect that was found on an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct FoundOnAxis {
    /// Index of the axis.
    axis: u16,
    effect: u32,
    predicted_reduction: f64,
}

/// Serialised form. The settings are JSON so that fields can be added.
#[derive(Serialize, Deserialize)]
struct Written<'a> {
    schema: &'a str,
    asked: Option<String>,
    texts: Vec<String>,
    shapes: Vec<Shape>,
    units: Vec<StoredUnit>,
}

/// View of one gathered unit.
#[derive(Clone, Copy)]
pub(crate) struct GatheredUnit<'a> {
    of: &'a Gathered,
    stored: &'a StoredUnit,
}

pub(crate) struct GatheredAxis {
    pub(crate) estimate: Estimate,
    /// White noise, flicker and random walk.
    pub(crate) noise: [f64; LEVELS],
}

impl GatheredAxis {
    pub(crate) fn is_finite(&self) -> bool {
        self.estimate.is_complete() && self.noise.iter().all(|level| level.is_finite())
    }
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
    /// # Errors
    ///
    /// The row has other settings or lacks numbers; it is then not added.
    pub fn add(&mut self, row: &UnitRow) -> Result<(), GatheredError> {
        // Rows from a file do not record the strictness of the read.
        let mut asked = row.asked.clone();
        asked.read.strict = false;
        self.check_asked(&asked, &row.unit)?;
        if let Some(axis) = row.axes.iter().find(|axis| !axis.estimate.is_complete()) {
            let (unit, column) = (row.unit.clone(), axis.estimate.column.clone());
            return Err(GatheredError::NotWhole { unit, column });
        }
        self.asked.get_or_insert(asked);
        self.take(row);
        Ok(())
    }

    /// Adds a row that is already checked.
    fn take(&mut self, row: &UnitRow) {
        let shape = row.axes.iter().map(|axis| AxisShape {
            column: self.text(&axis.estimate.column),
            names: axis.estimate.coefficients.names.iter().map(|name| self.text(name)).collect(),
            diagnosed: axis.diagnosis.is_some(),
        });
        let shape = Shape(shape.collect());
        let numbers = row.axes.iter().flat_map(numbers_of).collect();
        let mut found = Vec::new();
        for (place, axis) in row.axes.iter().enumerate() {
            for effect in axis.diagnosis.iter().flat_map(|diagnosis| &diagnosis.effects) {
                found.push(FoundOnAxis {
                    axis: place as u16,
                    effect: self.text(&effect.effect),
                    predicted_reduction: effect.predicted_reduction,
                });
            }
        }
        let stored = StoredUnit {
            unit: row.unit.as_str().into(),
            part: self.text(&row.part),
            lot: row.lot.as_deref().map(|lot| self.text(lot)),
            shape: self.shapes.insert_full(shape).0 as u32,
            digest: Sha256::digest(serde_json::to_vec(row).expect("rows have only string keys")).into(),
            log: log_digest(&row.sha256),
            numbers,
            found: found.into(),
            failed: row.failed.clone().into(),
        };
        self.units.push(stored);
    }

    /// Adds rows gathered elsewhere.
    ///
    /// # Errors
    ///
    /// They have other settings; nothing is then added.
    pub fn merge(&mut self, other: Self) -> Result<(), GatheredError> {
        let (Some(asked), Some(first)) = (other.asked, other.units.first()) else { return Ok(()) };
        self.check_asked(&asked, &first.unit)?;
        self.asked.get_or_insert(asked);
        let texts: Vec<u32> = other.texts.iter().map(|text| self.text(text)).collect();
        let text = |index: u32| texts[index as usize];
        let shapes: Vec<u32> = other
            .shapes
            .iter()
            .map(|Shape(axes)| {
                let axes = axes.iter().map(|axis| AxisShape {
                    column: text(axis.column),
                    names: axis.names.iter().map(|name| text(*name)).collect(),
                    diagnosed: axis.diagnosed,
                });
                self.shapes.insert_full(Shape(axes.collect())).0 as u32
            })
            .collect();
        self.units.extend(other.units.into_iter().map(|mut stored| {
            stored.part = text(stored.part);
            stored.lot = stored.lot.map(text);
            stored.shape = shapes[stored.shape as usize];
            stored.found.iter_mut().for_each(|found| found.effect = text(found.effect));
            stored
        }));
        Ok(())
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        let written = Written {
            schema: SCHEMA,
            asked: self.asked.as_ref().map(|asked| json!(asked).to_string()),
            texts: self.texts.iter().cloned().collect(),
            shapes: self.shapes.iter().cloned().collect(),
            units: self.units.clone(),
        };
        postcard::to_extend(&written, Vec::new()).expect("memory has room for it")
    }

    /// Reads the bytes of [`to_bytes`](Self::to_bytes).
    ///
    /// # Errors
    ///
    /// The bytes are damaged, or of another version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, GatheredError> {
        let not = |reason: &dyn ToString| GatheredError::NotGathered(reason.to_string());
        let (schema, _) = postcard::take_from_bytes::<&str>(bytes).map_err(|error| not(&error))?;
        if schema != SCHEMA {
            return Err(not(&"of another version"));
        }
        let (written, rest) = postcard::take_from_bytes::<Written<'_>>(bytes).map_err(|error| not(&error))?;
        let asked = written.asked.map(|asked| serde_json::from_str(&asked)).transpose();
        let asked = asked.map_err(|error| not(&error))?;
        let gathered = Self {
            asked,
            texts: written.texts.into_iter().collect(),
            shapes: written.shapes.into_iter().collect(),
            units: written.units,
        };
        if rest.is_empty() && gathered.is_complete() { Ok(gathered) } else { Err(not(&"it is damaged")) }
    }

    /// All indices are in range, and all numbers are present.
    fn is_complete(&self) -> bool {
        let text = |index: &u32| (*index as usize) < self.texts.len();
        let shapes = self.shapes.iter().flat_map(|shape| &shape.0);
        shapes.into_iter().all(|axis| text(&axis.column) && axis.names.iter().all(text))
            && self.units.iter().all(|unit| {
                text(&unit.part)
                    && unit.lot.iter().all(text)
                    && self.shapes.get_index(unit.shape as usize).is_some_and(|Shape(axes)| {
                        let numbers = axes.iter().map(|axis| axis.numbers()).sum::<usize>();
                        unit.numbers.len() == numbers
                            && unit
                                .found
                                .iter()
                                .all(|found| text(&found.effect) && usize::from(found.axis) < axes.len())
                    })
            })
    }

    /// Gathers rows with the same settings, without a check for duplicates.
    pub(crate) fn of(rows: &[UnitRow]) -> Self {
        let mut gathered = Self::default();
        rows.iter().for_each(|row| gathered.take(row));
        gathered
    }

    /// Settings of all rows.
    ///
    /// # Errors
    ///
    /// There are no rows.
    pub(crate) fn asked(&self) -> Result<&Asked, GatheredError> {
        self.asked.as_ref().ok_or(GatheredError::Nothing)
    }

    /// Units by part and name.
    pub(crate) fn sorted(&self) -> Vec<GatheredUnit<'_>> {
        let mut units: Vec<_> = self.units.iter().map(|stored| GatheredUnit { of: self, stored }).collect();
        // The digest orders units of the same name, where duplicates are allowed.
        units.sort_by_key(|unit| (unit.part(), unit.name(), unit.stored.digest));
        units
    }

    /// Checks that every unit occurs once.
    ///
    /// # Errors
    ///
    /// A unit occurs twice.
    pub(crate) fn check_once(units: &[GatheredUnit<'_>]) -> Result<(), GatheredError> {
        let twice = units
            .windows(2)
            .find(|pair| (pair[0].part(), pair[0].name()) == (pair[1].part(), pair[1].name()));
        match twice {
            Some(pair) => {
                Err(GatheredError::Twice { unit: pair[0].name().to_owned(), part: pair[0].part().to_owned() })
            }
            None => Ok(()),
        }
    }

    fn check_asked(&self, asked: &Asked, of: &str) -> Result<(), GatheredError> {
        match (&self.asked, self.units.first()) {
            (Some(of_first), Some(first)) if asked != of_first => Err(GatheredError::Asked {
                first: first.unit.to_string(),
                other: of.to_owned(),
                what: difference(of_first, asked),
            }),
            _ => Ok(()),
        }
    }

    fn text(&mut self, text: &str) -> u32 {
        match self.texts.get_index_of(text) {
            Some(index) => index as u32,
            None => self.texts.insert_full(text.to_owned()).0 as u32,
        }
    }
}

impl AxisShape {
    /// Number of values per unit: coefficients, lower triangle of the covariance, noise levels.
    fn numbers(&self) -> usize {
        let n = self.names.len();
        n + n * (n + 1) / 2 + LEVELS
    }
}

impl<'a> GatheredUnit<'a> {
    pub(crate) fn name(self) -> &'a str {
        &self.stored.unit
    }

    pub(crate) fn part(self) -> &'a str {
        &self.of.texts[self.stored.part as usize]
    }

    pub(crate) fn lot(self) -> Option<&'a str> {
        self.stored.lot.map(|lot| self.of.texts[lot as usize].as_str())
    }

    /// SHA-256 of the row.
    pub(crate) fn digest(self) -> &'a [u8; 32] {
        &self.stored.digest
    }

    /// Digest of the log, for the detection of duplicates.
    pub(crate) fn log(self) -> Option<[u8; LOG_DIGEST]> {
        self.stored.log
    }

    /// Number of identified coefficients over all axes.
    pub(crate) fn coefficients(self) -> usize {
        self.shape().iter().map(|axis| axis.names.len()).sum()
    }

    /// Reasons for missing results.
    pub(crate) fn failed(self) -> &'a [String] {
        &self.stored.failed
    }

    /// Columns of the estimated axes.
    pub(crate) fn columns(self) -> impl Iterator<Item = &'a str> {
        self.shape().iter().map(move |axis| self.of.texts[axis.column as usize].as_str())
    }

    pub(crate) fn axis(self, column: &str) -> Option<GatheredAxis> {
        let (place, numbers) = self.place(column)?;
        let shape = &self.shape()[place];
        let n = shape.names.len();
        let (values, rest) = self.stored.numbers[numbers].split_at(n);
        let (covariance, noise) = rest.split_at(n * (n + 1) / 2);
        let at = |row: usize, column: usize| {
            let (row, column) = (row.max(column), row.min(column));
            covariance[row * (row + 1) / 2 + column]
        };
        let names = shape.names.iter().map(|name| self.of.texts[*name as usize].clone()).collect();
        let covariance = (0..n).map(|row| (0..n).map(|column| at(row, column)).collect()).collect();
        let estimate = Estimate { names, values: values.to_vec(), covariance };
        Some(GatheredAxis { estimate, noise: noise.try_into().ok()? })
    }

    /// Effects found on an axis, with their predicted reductions; none if the axis was not diagnosed.
    pub(crate) fn effects(self, column: &str) -> Option<impl Iterator<Item = (&'a str, f64)>> {
        let (place, _) = self.place(column)?;
        let found = self.stored.found.iter().filter(move |found| usize::from(found.axis) == place);
        let named = found
            .map(move |found| (self.of.texts[found.effect as usize].as_str(), found.predicted_reduction));
        self.shape()[place].diagnosed.then_some(named)
    }

    fn shape(self) -> &'a [AxisShape] {
        &self.of.shapes[self.stored.shape as usize].0
    }

    /// Index of an axis, and the range of its numbers.
    fn place(self, column: &str) -> Option<(usize, Range<usize>)> {
        let mut start = 0;
        for (place, (axis, name)) in self.shape().iter().zip(self.columns()).enumerate() {
            let end = start + axis.numbers();
            if name == column {
                return Some((place, start..end));
            }
            start = end;
        }
        None
    }
}

fn log_digest(sha256: &str) -> Option<[u8; LOG_DIGEST]> {
    let digest = Sha256::digest(sha256);
    (!sha256.is_empty()).then(|| std::array::from_fn(|place| digest[place]))
}

fn numbers_of(axis: &AxisRow) -> impl Iterator<Item = f64> {
    let estimate = &axis.estimate.coefficients;
    let covariance = estimate.covariance.iter().enumerate().flat_map(|(row, values)| &values[..=row]);
    let noise = &axis.estimate.noise;
    estimate.values.iter().chain(covariance).copied().chain([noise.white, noise.flicker, noise.walk])
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
