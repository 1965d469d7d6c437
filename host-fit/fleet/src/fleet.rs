//! The populations of the parts of a fleet, from one row per unit.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use fos_data::file::keyed_rows::{KeyedRow, KeyedRows, KeyedRowsError};
use fos_data::file::{self, FileError, write_atomically};
use fos_data::statistics::median_of;
use fos_data::text::hexadecimal;
use fos_diagnose::effects::Library;
use fos_fit::noise::NoiseLevels;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::estimate::{BIAS, check_regressors};
use crate::gathered::{Gathered, GatheredError, GatheredUnit, sorted};
use crate::odd::{Distance, assess, devices_needed, discoveries};
use crate::population::{Member, Population};
use crate::row::{Asked, AxisDiagnosis, FoundEffect, UnitRow};
use crate::rows::rows_beside;

/// Schema of a population file.
pub const SCHEMA: &str = "fos-population/1";

/// Expected share of false positives among the units reported as odd (false discovery rate).
pub const FALSE_ODD: f64 = 0.1;

/// Populations, odd units and failed units of a fleet, as written to its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fleet {
    /// [`SCHEMA`].
    pub schema: String,
    /// Program and version that wrote the file, as `fos 1.2.3`.
    pub program: String,
    /// Settings common to all rows.
    pub asked: Asked,
    /// Number of rows, those of failed and duplicate units included.
    pub units: usize,
    /// SHA-256 over the SHA-256 of each row's JSON, in the order of part and unit; hexadecimal.
    pub rows_sha256: String,
    pub parts: Vec<PartSummary>,
    /// Units with no usable log, or with an axis that could not be estimated.
    pub failed: Vec<FailedUnit>,
    /// Units with the same log as another unit of the part; such a log enters the populations once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub duplicates: Vec<DuplicateUnit>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartSummary {
    /// Name of the part; empty if the fleet names no parts.
    pub part: String,
    pub axes: Vec<AxisSummary>,
    /// Units that deviate significantly from their population, the least probable first.
    pub odd: Vec<OddUnit>,
    /// Fewest units with which an odd one can be detected, if the part has fewer. Finding no odd unit is then not conclusive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units_needed: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisSummary {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// None if no coefficient is identifiable from the logs of three units; `without` then has the reason.
    pub population: Option<Population>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<String>,
    /// Medians over the units of white noise, flicker and random walk, as in `NoiseLevels`.
    pub median_noise: [f64; 3],
    /// Effects found by diagnosis, the largest mean reduction first; empty without diagnosis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectShare>,
}

/// An effect in a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectShare {
    pub effect: String,
    /// Number of units with the effect, and number of diagnosed units.
    pub units: [usize; 2],
    /// Predicted reduction if every unit's model had the effect: the mean over all diagnosed units, 0 for units without it.
    pub mean_reduction: f64,
    /// Cost of the effect on the device, from its file.
    pub device: String,
}

/// A unit that deviates significantly from its population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OddUnit {
    pub unit: String,
    pub lot: Option<String>,
    /// Axis with the smallest p-value.
    pub column: String,
    /// Deviation on that axis.
    pub distance: Distance,
    /// Probability that a unit of the population deviates this far on any of its axes (Bonferroni).
    pub p_value: f64,
}

/// A unit without results, or with results for some axes only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailedUnit {
    pub unit: String,
    pub reasons: Vec<String>,
}

/// A unit whose log is identical to that of another unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DuplicateUnit {
    pub part: String,
    pub unit: String,
    /// Unit whose log enters the population.
    pub same_as: String,
}

impl std::fmt::Display for DuplicateUnit {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { unit, same_as, .. } = self;
        write!(out, "{unit} is the same log as {same_as}: counted once.")
    }
}

impl PartSummary {
    /// Explains why the search for odd units is not conclusive; none if it is.
    pub fn not_conclusive(&self) -> Option<String> {
        let needed = self.units_needed?;
        let populations = self.axes.iter().filter_map(|axis| axis.population.as_ref());
        let devices = populations
            .map(|population| population.units)
            .max()
            .map_or_else(|| "no axis has a population".to_owned(), |devices| format!("{devices} were read"));
        Some(format!("Not conclusive. {needed} devices are needed, several in each lot ({devices})."))
    }
}

/// Failure to read or store the rows of a fleet.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    #[error("{}: not a population: {reason}\nhelp: make the population again; its schema is {SCHEMA}", path.display())]
    NotAPopulation {
        path: PathBuf,
        /// Reason with line and column.
        reason: String,
    },
    #[error("{}: {found} rows of {units} devices\nhelp: the rows of a population are beside it, under its name with .rows appended; if they are lost, make the population again", path.display())]
    OtherRows {
        /// File of the rows.
        path: PathBuf,
        /// Number of readable rows.
        found: usize,
        units: usize,
    },
    #[error("{}:{line}: not the row of a device: {reason}\nhelp: make the population again; complete rows are reused", path.display())]
    NotARow {
        /// File of the rows.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        reason: String,
    },
    #[error(transparent)]
    Rows(#[from] KeyedRowsError),
    #[error(transparent)]
    File(#[from] FileError),
}

impl Fleet {
    /// Reads a population and the rows stored beside it.
    pub fn read(path: &Path) -> Result<(Self, Vec<UnitRow>), FleetError> {
        let not = |reason: String| FleetError::NotAPopulation { path: path.to_owned(), reason };
        let fleet: Self =
            serde_json::from_slice(&file::read(path)?).map_err(|error| not(error.to_string()))?;
        if fleet.schema != SCHEMA {
            return Err(not(format!("its schema is {:?}", fleet.schema)));
        }
        check_regressors(&fleet.asked.regressors).map_err(|error| not(error.to_string()))?;
        let mut axes = fleet.parts.iter().flat_map(|part| &part.axes);
        if let Some(axis) =
            axes.find(|axis| axis.population.as_ref().is_some_and(|found| !found.is_complete()))
        {
            return Err(not(format!("{}: a number is missing or not finite", axis.column)));
        }
        let rows_path = rows_beside(path);
        let text = file::read(&rows_path)?;
        let lines: Vec<&[u8]> = text.split(|byte| *byte == b'\n').collect();
        let mut rows = Vec::new();
        for (index, line) in lines.iter().enumerate() {
            let wrong =
                |reason: String| FleetError::NotARow { path: rows_path.clone(), line: index + 1, reason };
            match serde_json::from_slice::<KeyedRow<UnitRow>>(line) {
                // A truncated last line is ignored.
                Err(_) if index + 1 == lines.len() => {}
                Err(error) => return Err(wrong(error.to_string())),
                Ok(KeyedRow { row, .. }) => match row.axes.iter().find(|axis| !axis.estimate.is_complete()) {
                    Some(axis) => {
                        return Err(wrong(format!(
                            "{}: a number is missing or not finite",
                            axis.estimate.column
                        )));
                    }
                    None => rows.push(row),
                },
            }
        }
        if digest_of(&sorted(&gathered(&rows))) != fleet.rows_sha256 {
            return Err(FleetError::OtherRows { path: rows_path, found: rows.len(), units: fleet.units });
        }
        Ok((fleet, rows))
    }

    /// Writes the population to `path`, and beside it its `rows` (JSON, in any order), as [`read`](Self::read) expects them.
    ///
    /// Nothing is written before all rows are checked.
    pub fn write_with_rows(&self, path: &Path, rows: &[String]) -> Result<(), FleetError> {
        let rows_path = rows_beside(path);
        KeyedRows::<UnitRow>::check(&rows_path)?;
        let (mut gathered, mut lines) = (Gathered::default(), Vec::new());
        for (index, row) in rows.iter().enumerate() {
            let wrong = |reason: &dyn ToString| FleetError::NotARow {
                path: rows_path.clone(),
                line: index + 1,
                reason: reason.to_string(),
            };
            let row: UnitRow = serde_json::from_str(row).map_err(|error| wrong(&error))?;
            gathered.add(row.clone()).map_err(|error| wrong(&error))?;
            // No unit has this key, so a later run computes the row again.
            lines.extend(KeyedRow { key: String::new(), row }.line());
        }
        if digest_of(&gathered.in_order()) != self.rows_sha256 {
            return Err(FleetError::OtherRows { path: rows_path, found: rows.len(), units: self.units });
        }
        write_atomically(&rows_path, &lines)?;
        Ok(write_atomically(path, &self.to_bytes())?)
    }

    /// Content of the population file: indented JSON.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).expect("populations have only string keys");
        text.push(b'\n');
        text
    }

    /// Computes the populations of `rows`, all with the settings `asked`. Sums run in the order of part and unit, so the result has the
    /// same bits for any order of `rows`.
    pub fn of(rows: &[UnitRow], asked: &Asked, library: &Library, program: &str) -> Self {
        Self::of_units(&sorted(&gathered(rows)), asked, library, program)
    }

    /// Computes the populations of gathered rows, with the same bits as [`of`](Self::of).
    pub fn of_gathered(gathered: &Gathered, library: &Library, program: &str) -> Result<Self, GatheredError> {
        let asked = gathered.asked()?;
        check_regressors(&asked.regressors)?;
        Ok(Self::of_units(&gathered.each_once()?, asked, library, program))
    }

    fn of_units(units: &[&GatheredUnit], asked: &Asked, library: &Library, program: &str) -> Self {
        let failed = units.iter().filter(|unit| !unit.failed.is_empty());
        let (mut parts, mut compared, mut duplicates) = (Vec::new(), Vec::new(), Vec::new());
        for units in units.chunk_by(|a, b| a.part == b.part) {
            let (units, of_part) = without_duplicates(units);
            duplicates.extend(of_part);
            let (summary, of_part) = part_summary(&units, asked, library);
            parts.push(summary);
            compared.push(of_part);
        }
        add_odd_units(&mut parts, compared);
        Self {
            schema: SCHEMA.to_owned(),
            program: program.to_owned(),
            asked: asked.clone(),
            units: units.len(),
            rows_sha256: digest_of(units),
            parts,
            failed: failed
                .map(|unit| FailedUnit { unit: unit.unit.clone(), reasons: unit.failed.clone() })
                .collect(),
            duplicates,
        }
    }
}

/// Separates the units of a part into those with a log of their own and duplicates of an earlier unit.
fn without_duplicates<'a>(units: &[&'a GatheredUnit]) -> (Vec<&'a GatheredUnit>, Vec<DuplicateUnit>) {
    let (mut first, mut duplicates) = (HashMap::new(), Vec::new());
    let is_new = |unit: &&&'a GatheredUnit| {
        if unit.log_sha256.is_empty() {
            return true;
        }
        let same_as: &str = first.entry(unit.log_sha256.as_str()).or_insert(&unit.unit);
        let is_new = same_as == unit.unit;
        if !is_new {
            let [part, unit, same_as] = [&unit.part, &unit.unit, same_as].map(str::to_owned);
            duplicates.push(DuplicateUnit { part, unit, same_as });
        }
        is_new
    };
    (units.iter().filter(is_new).copied().collect(), duplicates)
}

fn gathered(rows: &[UnitRow]) -> Vec<GatheredUnit> {
    rows.iter().cloned().map(GatheredUnit::of).collect()
}

fn digest_of(units: &[&GatheredUnit]) -> String {
    let mut digest = Sha256::new();
    units.iter().for_each(|unit| digest.update(unit.digest));
    hexadecimal(&digest.finalize())
}

/// A compared unit: its least probable axis, and the p-values of all axes.
struct Compared<'a> {
    unit: &'a GatheredUnit,
    axes: usize,
    column: &'a str,
    distance: Distance,
    /// Probability that a unit of the population deviates this far on any of its axes (Bonferroni).
    p_value: f64,
    /// p-values at a deviation of [`FAR`] standard deviations, for each coefficient of each axis.
    p_values_if_far: Vec<f64>,
}

/// An axis of a part: its summary, and for each unit with this axis its index, its distance and its p-values at a deviation of [`FAR`].
struct AssessedAxis<'a> {
    column: &'a str,
    summary: AxisSummary,
    distances: Vec<(usize, Distance, Vec<f64>)>,
}

/// Compared units of a part, and the number of coefficients per unit over all its axes.
struct OfPart<'a> {
    compared: Vec<Compared<'a>>,
    tests: usize,
}

/// Summarises a part; odd units are added by [`add_odd_units`].
fn part_summary<'a>(
    units: &[&'a GatheredUnit],
    asked: &Asked,
    library: &Library,
) -> (PartSummary, OfPart<'a>) {
    let axes = units.iter().flat_map(|unit| &unit.axes);
    let columns: BTreeSet<&str> = axes.map(|axis| axis.estimate.column.as_str()).collect();
    let columns: Vec<&str> = columns.into_iter().collect();
    let axes: Vec<_> =
        columns.into_par_iter().map(|column| assessed_axis(column, units, asked, library)).collect();
    let mut compared: Vec<Option<Compared<'_>>> = units.iter().map(|_| None).collect();
    let mut summaries = Vec::new();
    for AssessedAxis { column, summary, distances } in axes {
        for (index, distance, if_far) in distances {
            let unit = compared[index].get_or_insert_with(|| Compared {
                unit: units[index],
                axes: 0,
                column,
                p_value: 1.0,
                distance: distance.clone(),
                p_values_if_far: Vec::new(),
            });
            unit.axes += 1;
            unit.p_values_if_far.extend(if_far);
            if distance.p_value < unit.distance.p_value {
                (unit.column, unit.distance) = (column, distance);
            }
        }
        summaries.push(summary);
    }
    let part = units.first().map_or_else(String::new, |unit| unit.part.clone());
    let mut compared: Vec<Compared<'_>> = compared.into_iter().flatten().collect();
    for unit in &mut compared {
        let axes = unit.axes as f64;
        unit.p_value = (unit.distance.p_value * axes).min(1.0);
        unit.p_values_if_far.iter_mut().for_each(|p_value| *p_value *= axes);
    }
    let tests = units.iter().map(|unit| unit.coefficients()).max().unwrap_or(1);
    (PartSummary { part, axes: summaries, odd: Vec::new(), units_needed: None }, OfPart { compared, tests })
}

fn assessed_axis<'a>(
    column: &'a str,
    units: &[&GatheredUnit],
    asked: &Asked,
    library: &Library,
) -> AssessedAxis<'a> {
    let of_units = units.iter().enumerate().filter_map(|(index, unit)| Some((index, unit.axis(column)?)));
    // Axes with a non-finite number are excluded.
    let of_units = of_units.map(|(index, axis)| (index, &axis.estimate));
    let of_units: Vec<_> = of_units.filter(|(_, axis)| axis.is_complete()).collect();
    let members: Vec<Member<'_>> = of_units
        .iter()
        .map(|(index, axis)| Member { lot: units[*index].lot.as_deref(), estimate: &axis.coefficients })
        .collect();
    let assessment = assess(&members, &names_of(&members, asked));
    let noise = |level: fn(&NoiseLevels) -> f64| {
        median_of(of_units.iter().map(|(_, axis)| level(&axis.noise))).unwrap_or(0.0)
    };
    let without = assessment.as_ref().err().map(ToString::to_string);
    let (population, distances) = assessment.map_or((None, Vec::new()), |assessment| {
        let distances: Vec<_> = assessment.distances.into_iter().zip(assessment.p_values_if_far).collect();
        (Some(assessment.population), distances)
    });
    AssessedAxis {
        column,
        summary: AxisSummary {
            column: column.to_owned(),
            without,
            population,
            median_noise: [noise(|of| of.white), noise(|of| of.flicker), noise(|of| of.walk)],
            effects: effects_of(
                units.iter().filter_map(|unit| unit.axis(column)?.diagnosis.as_ref()),
                library,
            ),
        },
        distances: of_units
            .iter()
            .zip(distances)
            .filter(|(_, (distance, _))| distance.coefficients > 0)
            .map(|((index, _), (distance, if_far))| (*index, distance, if_far))
            .collect(),
    }
}

/// The bias and regressors that are identifiable from the logs of at least three units.
fn names_of(members: &[Member<'_>], asked: &Asked) -> Vec<String> {
    let all = std::iter::once(BIAS).chain(asked.regressors.iter().map(String::as_str));
    let identifiable =
        all.filter(|name| members.iter().filter(|member| member.estimate.place(name).is_some()).count() >= 3);
    identifiable.map(str::to_owned).collect()
}

/// Adds the odd units of all parts: over all tests of the fleet, at most [`FALSE_ODD`] of them are false positives. If a part is too small
/// to detect an odd unit, adds the number of units needed.
fn add_odd_units(parts: &mut [PartSummary], of_parts: Vec<OfPart<'_>>) {
    let p_values: Vec<f64> =
        of_parts.iter().flat_map(|part| &part.compared).map(|unit| unit.p_value).collect();
    let mut found = discoveries(&p_values, FALSE_ODD).into_iter();
    // Threshold for a single odd unit.
    let limit = FALSE_ODD / p_values.len() as f64;
    for (part, OfPart { compared, tests }) in parts.iter_mut().zip(of_parts) {
        let units = compared.len();
        let if_far = || compared.iter().flat_map(|unit| &unit.p_values_if_far);
        if 2 * if_far().filter(|p_value| **p_value <= limit).count() <= if_far().count() {
            let of_part = FALSE_ODD * units.max(1) as f64 / p_values.len().max(1) as f64;
            part.units_needed = Some(devices_needed(tests, of_part).max(units + 1));
        }
        let odd = compared.into_iter().filter(|_| found.next().unwrap_or(false));
        part.odd = odd
            .map(|Compared { unit, column, distance, p_value, .. }| OddUnit {
                unit: unit.unit.clone(),
                lot: unit.lot.clone(),
                column: column.to_owned(),
                distance,
                p_value,
            })
            .collect();
        part.odd.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then_with(|| a.unit.cmp(&b.unit)));
    }
}

/// Effects found on the diagnosed units, the largest mean reduction first.
fn effects_of<'a>(diagnoses: impl Iterator<Item = &'a AxisDiagnosis>, library: &Library) -> Vec<EffectShare> {
    let diagnoses: Vec<&AxisDiagnosis> = diagnoses.collect();
    let mut shares: Vec<EffectShare> = Vec::new();
    for FoundEffect { effect, predicted_reduction } in
        diagnoses.iter().flat_map(|diagnosis| &diagnosis.effects)
    {
        let place = shares.iter().position(|share| share.effect == *effect).unwrap_or_else(|| {
            let device = library.get(effect).map_or_else(|_| String::new(), |effect| effect.device.clone());
            let units = [0, diagnoses.len()];
            shares.push(EffectShare { effect: effect.clone(), units, mean_reduction: 0.0, device });
            shares.len() - 1
        });
        shares[place].units[0] += 1;
        shares[place].mean_reduction += predicted_reduction / diagnoses.len() as f64;
    }
    shares
        .sort_by(|a, b| b.mean_reduction.total_cmp(&a.mean_reduction).then_with(|| a.effect.cmp(&b.effect)));
    shares
}
