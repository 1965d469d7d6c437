//! What the populations of a fleet need of its rows: a fifth of their memory, merged from processes and machines in any order.

use std::ops::Range;

use indexmap::IndexSet;
use serde::{Deserialize, Serialize};
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::estimate::Estimate;
use crate::row::{Asked, AxisRow, UnitRow};

/// Schema of [`Gathered::to_bytes`].
const SCHEMA: &str = "fos-gathered/2";

/// Bytes of the digest of a log: enough that no two logs share one by chance.
const LOG_DIGEST: usize = 16;

/// Of white noise, flicker and random walk a level each.
const LEVELS: usize = 3;

/// Why rows are no fleet.
#[derive(Debug, thiserror::Error)]
pub enum GatheredError {
    #[error("the fleet is empty\nhelp: give a row for each device")]
    Nothing,
    /// Two were asked different things.
    #[error(
        "the devices {first:?} and {other:?} were asked different things: {what}\nhelp: ask all devices for the same regressors, diagnosed or not, and read all logs alike"
    )]
    Asked {
        first: String,
        /// One that was asked something else.
        other: String,
        /// Both, in words.
        what: String,
    },
    /// A unit is there twice.
    #[error(
        "the device {unit:?}{} is there twice\nhelp: one row for each device of a part; name them apart, as `lot/unit`, and give all logs of one to one row",
        of_part(part)
    )]
    Twice { unit: String, part: String },
    /// A row has not all numbers that it speaks of.
    #[error(
        "the row of {unit:?}: {column}: a number is missing or not finite\nhelp: use the rows of this version as they were made"
    )]
    NotWhole { unit: String, column: String },
    /// Bytes that are no gathered rows.
    #[error("not gathered rows: {0}\nhelp: gather the rows again with this version")]
    NotGathered(String),
}

fn of_part(part: &str) -> String {
    if part.is_empty() { String::new() } else { format!(" of {part:?}") }
}

/// What populations need of rows. Whatever the order in which rows come and what was gathered apart is merged, it comes to the same bits:
/// nothing is added up before all is there, and then by part and unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathered {
    /// What all were asked; none of no rows.
    asked: Option<Asked>,
    /// Texts that many units have in common, each once.
    texts: IndexSet<String>,
    /// What rows have numbers of, each once.
    shapes: IndexSet<Shape>,
    units: Vec<Held>,
}

/// The axes of a unit, in the order of their numbers.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
struct Shape(Vec<AxisShape>);

#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
struct AxisShape {
    column: u32,
    names: Vec<u32>,
    diagnosed: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Held {
    unit: Box<str>,
    part: u32,
    lot: Option<u32>,
    /// The place of its shape.
    shape: u32,
    /// SHA-256 of its row.
    digest: [u8; 32],
    /// The start of the SHA-256 of its row's `sha256`; none where no log could be read.
    log: Option<[u8; LOG_DIGEST]>,
    /// Of each axis the coefficients, the lower half of their covariance, row by row, and the noise levels.
    numbers: Box<[f64]>,
    /// What was found on its axes.
    found: Box<[Found]>,
    failed: Box<[String]>,
}

/// An effect that was found on an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Found {
    /// The place of the axis.
    axis: u16,
    effect: u32,
    predicted_reduction: f64,
}

/// As bytes: what was asked is JSON, which may grow.
#[derive(Serialize, Deserialize)]
struct Written<'a> {
    schema: &'a str,
    asked: Option<String>,
    texts: Vec<String>,
    shapes: Vec<Shape>,
    units: Vec<Held>,
}

/// A unit of those that were gathered.
#[derive(Clone, Copy)]
pub(crate) struct GatheredUnit<'a> {
    of: &'a Gathered,
    held: &'a Held,
}

pub(crate) struct GatheredAxis {
    pub(crate) estimate: Estimate,
    /// White noise, flicker and random walk.
    pub(crate) noise: [f64; LEVELS],
}

impl GatheredAxis {
    pub(crate) fn is_finite(&self) -> bool {
        self.estimate.is_whole() && self.noise.iter().all(|level| level.is_finite())
    }
}

impl Gathered {
    pub fn len(&self) -> usize {
        self.units.len()
    }

    pub fn is_empty(&self) -> bool {
        self.units.is_empty()
    }

    /// Takes what populations need of a row.
    ///
    /// # Errors
    ///
    /// It was asked something else, or has not all of its numbers; nothing of it is taken then.
    pub fn add(&mut self, row: &UnitRow) -> Result<(), GatheredError> {
        // a row from a file does not know how strictly its log was read
        let mut asked = row.asked.clone();
        asked.read.strict = false;
        self.check_asked(&asked, &row.unit)?;
        if let Some(axis) = row.axes.iter().find(|axis| !axis.estimate.is_whole()) {
            let (unit, column) = (row.unit.clone(), axis.estimate.column.clone());
            return Err(GatheredError::NotWhole { unit, column });
        }
        self.asked.get_or_insert(asked);
        self.take(row);
        Ok(())
    }

    /// As [`add`](Self::add) of a row that is known to be as all are.
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
                found.push(Found {
                    axis: place as u16,
                    effect: self.text(&effect.effect),
                    predicted_reduction: effect.predicted_reduction,
                });
            }
        }
        let held = Held {
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
        self.units.push(held);
    }

    /// Takes what was gathered apart.
    ///
    /// # Errors
    ///
    /// It was asked something else; nothing of it is taken then.
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
        self.units.extend(other.units.into_iter().map(|mut held| {
            held.part = text(held.part);
            held.lot = held.lot.map(text);
            held.shape = shapes[held.shape as usize];
            held.found.iter_mut().for_each(|found| found.effect = text(found.effect));
            held
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

    /// What [`to_bytes`](Self::to_bytes) has written.
    ///
    /// # Errors
    ///
    /// It has not, or another version has.
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
        if rest.is_empty() && gathered.is_whole() { Ok(gathered) } else { Err(not(&"it is damaged")) }
    }

    /// Every place that it speaks of is there, and every number.
    fn is_whole(&self) -> bool {
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

    /// What rows of which all were asked the same come to, however often a unit is there.
    pub(crate) fn of(rows: &[UnitRow]) -> Self {
        let mut gathered = Self::default();
        rows.iter().for_each(|row| gathered.take(row));
        gathered
    }

    /// What all were asked.
    ///
    /// # Errors
    ///
    /// There is no row.
    pub(crate) fn asked(&self) -> Result<&Asked, GatheredError> {
        self.asked.as_ref().ok_or(GatheredError::Nothing)
    }

    /// The units by part and name.
    pub(crate) fn sorted(&self) -> Vec<GatheredUnit<'_>> {
        let mut units: Vec<_> = self.units.iter().map(|held| GatheredUnit { of: self, held }).collect();
        // what tells units of one name apart, where that is no error
        units.sort_by_key(|unit| (unit.part(), unit.name(), unit.held.digest));
        units
    }

    /// No unit is there twice.
    ///
    /// # Errors
    ///
    /// One is.
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
    /// How many numbers it has.
    fn numbers(&self) -> usize {
        let n = self.names.len();
        n + n * (n + 1) / 2 + LEVELS
    }
}

impl<'a> GatheredUnit<'a> {
    pub(crate) fn name(self) -> &'a str {
        &self.held.unit
    }

    pub(crate) fn part(self) -> &'a str {
        &self.of.texts[self.held.part as usize]
    }

    pub(crate) fn lot(self) -> Option<&'a str> {
        self.held.lot.map(|lot| self.of.texts[lot as usize].as_str())
    }

    /// SHA-256 of its row.
    pub(crate) fn digest(self) -> &'a [u8; 32] {
        &self.held.digest
    }

    /// Digest of its log, to compare with those of others.
    pub(crate) fn log(self) -> Option<[u8; LOG_DIGEST]> {
        self.held.log
    }

    /// Coefficients that its log tells, of all axes.
    pub(crate) fn coefficients(self) -> usize {
        self.shape().iter().map(|axis| axis.names.len()).sum()
    }

    /// Why something of it could not be told.
    pub(crate) fn failed(self) -> &'a [String] {
        &self.held.failed
    }

    /// The axes that could be estimated.
    pub(crate) fn columns(self) -> impl Iterator<Item = &'a str> {
        self.shape().iter().map(move |axis| self.of.texts[axis.column as usize].as_str())
    }

    pub(crate) fn axis(self, column: &str) -> Option<GatheredAxis> {
        let (place, numbers) = self.place(column)?;
        let shape = &self.shape()[place];
        let n = shape.names.len();
        let (values, rest) = self.held.numbers[numbers].split_at(n);
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

    /// The effects that were found on an axis, with the shares that should go with each; none where it was not diagnosed.
    pub(crate) fn effects(self, column: &str) -> Option<impl Iterator<Item = (&'a str, f64)>> {
        let (place, _) = self.place(column)?;
        let found = self.held.found.iter().filter(move |found| usize::from(found.axis) == place);
        let named = found
            .map(move |found| (self.of.texts[found.effect as usize].as_str(), found.predicted_reduction));
        self.shape()[place].diagnosed.then_some(named)
    }

    fn shape(self) -> &'a [AxisShape] {
        &self.of.shapes[self.held.shape as usize].0
    }

    /// The place of an axis, and where its numbers are.
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
