//! A fleet: a row for each unit, kept as they come, and the populations of its parts.

use std::collections::{BTreeSet, HashMap};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use fos_data::file::{self, FileError, write_atomically};
use fos_data::statistics::median_of;
use fos_data::text::hexadecimal;
use fos_diagnose::effects::Library;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::estimate::BIAS;
use crate::gathered::{Gathered, GatheredError, GatheredUnit};
use crate::odd::{Distance, discoveries, judge};
use crate::population::{Member, Population};
use crate::row::{Asked, Unit, UnitRow, unit_row};

/// Schema of what is written of a fleet.
pub const SCHEMA: &str = "fos-population/1";

/// Of the units that are called odd at most this share is not, in the mean.
pub const FALSE_ODD: f64 = 0.1;

/// What a fleet comes to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fleet {
    /// [`SCHEMA`].
    pub schema: String,
    /// The program that wrote it.
    pub program: String,
    /// What was asked of every unit.
    pub asked: Asked,
    /// Units that were asked.
    pub units: usize,
    /// SHA-256 of the SHA-256 of their rows, of the JSON of each, by part and unit; hexadecimal.
    pub rows_sha256: String,
    /// Each part, by name.
    pub parts: Vec<PartSummary>,
    /// Units of which nothing, or not everything, could be told.
    pub failed: Vec<FailedUnit>,
}

/// A part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartSummary {
    /// Its name; empty if the fleet names none.
    pub part: String,
    /// Its axes.
    pub axes: Vec<AxisSummary>,
    /// Units that do not belong, the furthest first.
    pub odd: Vec<OddUnit>,
}

/// An axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisSummary {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// Its population; none where too few units tell a coefficient.
    pub population: Option<Population>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without: Option<String>,
    /// White noise, flicker and random walk of the median unit, as in `NoiseLevels`.
    pub median_noise: [f64; 3],
    /// What diagnoses found; none where none was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectShare>,
}

/// An effect in a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectShare {
    /// As in the library.
    pub effect: String,
    /// Units that have it, and units that were asked.
    pub units: [usize; 2],
    /// By how much the error should fall if every unit's model had it: the mean over all units, 0 where it was not found.
    pub mean_reduction: f64,
    /// What it costs on the device, as its file says.
    pub device: String,
}

/// A unit that does not belong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OddUnit {
    /// Its name.
    pub unit: String,
    /// Its lot.
    pub lot: Option<String>,
    /// The axis that shows it best.
    pub column: String,
    /// How far it is there, and in what.
    pub distance: Distance,
    /// How often a unit that belongs would be so far in any of its axes.
    pub p_value: f64,
}

/// A unit that tells nothing, or not everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailedUnit {
    /// Its name.
    pub unit: String,
    /// Why.
    pub reasons: Vec<String>,
}

/// Why the rows of a fleet cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// As the system says.
    #[error("{}: {source}\nhelp: the rows of a fleet are kept there, so that it goes on where it was broken off", path.display())]
    Rows {
        /// Where rows are kept.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no population, or of another schema.
    #[error("{}: no population: {reason}\nhelp: a population of schema {SCHEMA}, made of the units anew", path.display())]
    NotAPopulation {
        /// As it was given.
        path: PathBuf,
        /// What is wrong, with its line and column.
        reason: String,
    },
    /// The rows beside a population are not those that it was made of.
    #[error("{}: {found} rows of {units} units\nhelp: the rows of a population lie beside it under its name with .rows behind it; where they are lost, make the population anew", path.display())]
    OtherRows {
        /// The rows.
        path: PathBuf,
        /// Rows that can be read, of units of the population.
        found: usize,
        /// Units of the population.
        units: usize,
    },
    /// A line of the rows beside a population is none.
    #[error("{}:{line}: no row of a unit: {reason}\nhelp: make the population anew; rows that are whole are taken from there", path.display())]
    NotARow {
        /// The rows.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// Something else is there.
    #[error("{}: there is a file of that name that has no rows of a fleet; it would be lost\nhelp: write to another file, or move that one away", .0.display())]
    NotRows(PathBuf),
    /// As the system says.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Where the rows of the population `population` are kept: beside it, under its name with `.rows` behind it.
pub fn rows_beside(population: &Path) -> PathBuf {
    let mut path = population.as_os_str().to_owned();
    path.push(".rows");
    path.into()
}

/// A row as it is kept, with what it depends on.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    key: String,
    row: UnitRow,
}

/// The rows of `units`, in their order, each looked at once: rows go to `kept_in`, a line of JSON each, as they come, and are taken from
/// there if neither log nor program has changed: `build` tells one program of a version from another. `progress` is told how many are done.
///
/// # Errors
///
/// The rows cannot be kept. A unit that cannot be read is a row that says so.
pub fn rows(
    units: &[Unit],
    asked: &Asked,
    library: &Library,
    program: &str,
    build: &str,
    kept_in: &Path,
    progress: impl Fn(usize) + Sync,
) -> Result<Vec<UnitRow>, FleetError> {
    let failed = |source| FleetError::Rows { path: kept_in.to_owned(), source };
    let known =
        known_rows(kept_in).map_err(failed)?.ok_or_else(|| FleetError::NotRows(kept_in.to_owned()))?;
    let file = OpenOptions::new().create(true).append(true).open(kept_in).map_err(failed)?;
    let (file, done) = (Mutex::new(file), AtomicUsize::new(0));
    let kept: Vec<Kept> = units
        .par_iter()
        .map(|unit| {
            let key = key(unit, asked, library, build);
            let kept = match known.get(&key) {
                Some(row) => Kept { key, row: row.clone() },
                None => {
                    let kept = Kept { key, row: unit_row(unit, asked, library, program) };
                    // whole lines only: another thread may be writing too
                    let line = line_of(&kept);
                    let mut file = file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    file.write_all(&line).and_then(|()| file.flush()).map_err(failed)?;
                    kept
                }
            };
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ok(kept)
        })
        .collect::<Result<_, FleetError>>()?;
    // in the order of the units, each once
    write_atomically(kept_in, &kept.iter().flat_map(line_of).collect::<Vec<u8>>())?;
    Ok(kept.into_iter().map(|kept| kept.row).collect())
}

fn line_of(kept: &Kept) -> Vec<u8> {
    let mut line = serde_json::to_vec(kept).expect("rows have only string keys");
    line.push(b'\n');
    line
}

/// What is kept; a last line that was cut off does not count. None if the file is of something else.
fn known_rows(kept_in: &Path) -> std::io::Result<Option<HashMap<String, UnitRow>>> {
    let file = match File::open(kept_in) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Some(HashMap::new())),
        file => file?,
    };
    let (mut known, mut lines) = (HashMap::new(), 0);
    for line in BufReader::new(file).split(b'\n') {
        known.extend(serde_json::from_slice::<Kept>(&line?).map(|kept| (kept.key, kept.row)));
        lines += 1;
    }
    Ok((lines <= 1 || !known.is_empty()).then_some(known))
}

/// What a row depends on: name, size and time of change of its logs, what is asked, the program, the library.
fn key(unit: &Unit, asked: &Asked, library: &Library, build: &str) -> String {
    let of_file =
        |log: &PathBuf| std::fs::metadata(log).ok().map(|about| (about.len(), about.modified().ok()));
    let about: Vec<_> = unit.logs.iter().map(of_file).collect();
    let mut digest = Sha256::new();
    digest.update(format!("{build} {unit:?} {about:?}"));
    digest.update(serde_json::to_vec(asked).unwrap_or_default());
    if asked.diagnosed {
        digest.update(serde_json::to_vec(library.effects()).unwrap_or_default());
    }
    hexadecimal(&digest.finalize())
}

impl Fleet {
    /// The population in a file and the rows that it was made of, from beside it.
    ///
    /// # Errors
    ///
    /// One of them cannot be read, or they do not belong together: the rows come to another population.
    pub fn read(path: &Path) -> Result<(Self, Vec<UnitRow>), FleetError> {
        let not = |reason: String| FleetError::NotAPopulation { path: path.to_owned(), reason };
        let fleet: Self =
            serde_json::from_slice(&file::read(path)?).map_err(|error| not(error.to_string()))?;
        if fleet.schema != SCHEMA {
            return Err(not(format!("its schema is {:?}", fleet.schema)));
        }
        let mut axes = fleet.parts.iter().flat_map(|part| &part.axes);
        if let Some(axis) = axes.find(|axis| axis.population.as_ref().is_some_and(|found| !found.is_whole()))
        {
            return Err(not(format!("{}: not every coefficient has its numbers", axis.column)));
        }
        let kept_in = rows_beside(path);
        let text = file::read(&kept_in)?;
        let lines: Vec<&[u8]> = text.split(|byte| *byte == b'\n').collect();
        let mut rows = Vec::new();
        for (index, line) in lines.iter().enumerate() {
            let wrong =
                |reason: String| FleetError::NotARow { path: kept_in.clone(), line: index + 1, reason };
            match serde_json::from_slice::<Kept>(line) {
                // a last line that was cut off does not count
                Err(_) if index + 1 == lines.len() => {}
                Err(error) => return Err(wrong(error.to_string())),
                Ok(Kept { row, .. }) => {
                    match row.axes.iter().find(|axis| !axis.estimate.coefficients.is_whole()) {
                        Some(axis) => {
                            return Err(wrong(format!(
                                "{}: not every coefficient has its numbers",
                                axis.estimate.column
                            )));
                        }
                        None => rows.push(row),
                    }
                }
            }
        }
        if digest_of(&Gathered::of(&rows).sorted()) != fleet.rows_sha256 {
            return Err(FleetError::OtherRows { path: kept_in, found: rows.len(), units: fleet.units });
        }
        Ok((fleet, rows))
    }

    /// Writes it to `path`, and beside it `rows`, those that it was made of as JSON, in any order: what [`read`](Self::read) takes.
    ///
    /// # Errors
    ///
    /// One of them is no row, they are not those that it was made of, or a file cannot be written. Nothing is written before all are known
    /// to belong there.
    pub fn write_with_rows(&self, path: &Path, rows: &[String]) -> Result<(), FleetError> {
        let kept_in = rows_beside(path);
        let (mut gathered, mut lines) = (Gathered::default(), Vec::new());
        for (index, row) in rows.iter().enumerate() {
            let wrong = |reason: &dyn ToString| FleetError::NotARow {
                path: kept_in.clone(),
                line: index + 1,
                reason: reason.to_string(),
            };
            let row: UnitRow = serde_json::from_str(row).map_err(|error| wrong(&error))?;
            gathered.add(&row).map_err(|error| wrong(&error))?;
            // no unit has this key: what goes on from here looks at the logs again
            lines.extend(line_of(&Kept { key: String::new(), row }));
        }
        if digest_of(&gathered.sorted()) != self.rows_sha256 {
            return Err(FleetError::OtherRows { path: kept_in, found: rows.len(), units: self.units });
        }
        write_atomically(&kept_in, &lines)?;
        Ok(write_atomically(path, &self.to_bytes())?)
    }

    /// The text of its file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).expect("populations have only string keys");
        text.push(b'\n');
        text
    }

    /// What `rows`, all of which were asked `asked`, come to. Sums are taken in the order of parts and units, whatever that of `rows` is: the same
    /// rows give the same bits.
    pub fn of(rows: &[UnitRow], asked: &Asked, library: &Library, program: &str) -> Self {
        Self::of_units(&Gathered::of(rows).sorted(), asked, library, program)
    }

    /// What rows that were made apart come to: the same bits.
    ///
    /// # Errors
    ///
    /// There is none, or a unit is there twice.
    pub fn of_gathered(gathered: &Gathered, library: &Library, program: &str) -> Result<Self, GatheredError> {
        let (asked, units) = (gathered.asked()?, gathered.sorted());
        Gathered::check_once(&units)?;
        Ok(Self::of_units(&units, asked, library, program))
    }

    fn of_units(units: &[GatheredUnit<'_>], asked: &Asked, library: &Library, program: &str) -> Self {
        let parts = units.chunk_by(|a, b| a.part() == b.part());
        let failed = units.iter().filter(|unit| !unit.failed().is_empty());
        Self {
            schema: SCHEMA.to_owned(),
            program: program.to_owned(),
            asked: asked.clone(),
            units: units.len(),
            rows_sha256: digest_of(units),
            parts: parts.map(|units| part_summary(units, asked, library)).collect(),
            failed: failed
                .map(|unit| FailedUnit { unit: unit.name().to_owned(), reasons: unit.failed().to_vec() })
                .collect(),
        }
    }
}

fn digest_of(units: &[GatheredUnit<'_>]) -> String {
    let mut digest = Sha256::new();
    units.iter().for_each(|unit| digest.update(unit.digest()));
    hexadecimal(&digest.finalize())
}

/// Of a unit, its axis that is furthest from its population, and the p-value of that.
struct Furthest<'a> {
    unit: GatheredUnit<'a>,
    axes: usize,
    column: &'a str,
    distance: Distance,
}

/// An axis of a part, and of its units that have it, by their places, how far they are.
struct JudgedAxis<'a> {
    column: &'a str,
    summary: AxisSummary,
    distances: Vec<(usize, Distance)>,
}

fn part_summary(units: &[GatheredUnit<'_>], asked: &Asked, library: &Library) -> PartSummary {
    let columns: BTreeSet<&str> = units.iter().flat_map(|unit| unit.columns()).collect();
    let columns: Vec<&str> = columns.into_iter().collect();
    let axes: Vec<_> =
        columns.into_par_iter().map(|column| judged_axis(column, units, asked, library)).collect();
    let mut furthest: Vec<Option<Furthest<'_>>> = units.iter().map(|_| None).collect();
    let mut summaries = Vec::new();
    for JudgedAxis { column, summary, distances } in axes {
        for (index, distance) in distances {
            let place = &mut furthest[index];
            let axes = place.as_ref().map_or(1, |before| before.axes + 1);
            match place {
                Some(before) if before.distance.p_value <= distance.p_value => before.axes = axes,
                _ => *place = Some(Furthest { unit: units[index], axes, column, distance }),
            }
        }
        summaries.push(summary);
    }
    PartSummary {
        part: units.first().map_or_else(String::new, |unit| unit.part().to_owned()),
        axes: summaries,
        odd: odd_units(furthest.into_iter().flatten().collect()),
    }
}

fn judged_axis<'a>(
    column: &'a str,
    units: &[GatheredUnit<'_>],
    asked: &Asked,
    library: &Library,
) -> JudgedAxis<'a> {
    let of_units: Vec<_> =
        units.iter().enumerate().filter_map(|(index, unit)| Some((index, unit.axis(column)?))).collect();
    let members: Vec<Member<'_>> = of_units
        .iter()
        .map(|(index, axis)| Member { lot: units[*index].lot(), estimate: &axis.estimate })
        .collect();
    let judged = judge(&members, &names_of(&members, asked));
    let noise = |level: usize| median_of(of_units.iter().map(|(_, axis)| axis.noise[level])).unwrap_or(0.0);
    let without = judged.as_ref().err().map(ToString::to_string);
    let (population, distances) =
        judged.map_or((None, Vec::new()), |judged| (Some(judged.population), judged.distances));
    JudgedAxis {
        column,
        summary: AxisSummary {
            column: column.to_owned(),
            without,
            population,
            median_noise: [0, 1, 2].map(noise),
            effects: effects_of(units.iter().filter_map(|unit| unit.effects(column)), library),
        },
        distances: of_units.iter().map(|(index, _)| *index).zip(distances).collect(),
    }
}

/// Bias and regressors, those that at least three units tell.
fn names_of(members: &[Member<'_>], asked: &Asked) -> Vec<String> {
    let all = std::iter::once(BIAS).chain(asked.regressors.iter().map(String::as_str));
    let told =
        all.filter(|name| members.iter().filter(|member| member.estimate.place(name).is_some()).count() >= 3);
    told.map(str::to_owned).collect()
}

fn odd_units(furthest: Vec<Furthest<'_>>) -> Vec<OddUnit> {
    // of several axes the furthest is further by chance (Bonferroni)
    let p_value = |unit: &Furthest<'_>| (unit.distance.p_value * unit.axes as f64).min(1.0);
    let p_values: Vec<f64> = furthest.iter().map(p_value).collect();
    let mut odd: Vec<OddUnit> = furthest
        .into_iter()
        .zip(discoveries(&p_values, FALSE_ODD))
        .zip(&p_values)
        .filter(|((_, found), _)| *found)
        .map(|((unit, _), p_value)| OddUnit {
            unit: unit.unit.name().to_owned(),
            lot: unit.unit.lot().map(str::to_owned),
            column: unit.column.to_owned(),
            distance: unit.distance,
            p_value: *p_value,
        })
        .collect();
    odd.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then_with(|| a.unit.cmp(&b.unit)));
    odd
}

/// Of each unit that was diagnosed, what was found.
fn effects_of<'a, Found: Iterator<Item = (&'a str, f64)>>(
    diagnoses: impl Iterator<Item = Found>,
    library: &Library,
) -> Vec<EffectShare> {
    let diagnoses: Vec<Vec<(&str, f64)>> = diagnoses.map(Iterator::collect).collect();
    let mut shares: Vec<EffectShare> = Vec::new();
    for (found, predicted_reduction) in diagnoses.iter().flatten() {
        let place = shares.iter().position(|share| share.effect == *found).unwrap_or_else(|| {
            let device = library.get(found).map_or_else(|_| String::new(), |effect| effect.device.clone());
            let units = [0, diagnoses.len()];
            shares.push(EffectShare { effect: (*found).to_owned(), units, mean_reduction: 0.0, device });
            shares.len() - 1
        });
        shares[place].units[0] += 1;
        shares[place].mean_reduction += predicted_reduction / diagnoses.len() as f64;
    }
    shares
        .sort_by(|a, b| b.mean_reduction.total_cmp(&a.mean_reduction).then_with(|| a.effect.cmp(&b.effect)));
    shares
}
