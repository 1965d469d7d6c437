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
use crate::odd::{Distance, FAR, devices_needed, discoveries, judge};
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
    pub parts: Vec<PartSummary>,
    /// Units of which nothing, or not everything, could be told.
    pub failed: Vec<FailedUnit>,
    /// Units whose log is that of another unit of the part: in the populations it counts once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub duplicates: Vec<DuplicateUnit>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartSummary {
    /// Its name; empty if the fleet names none.
    pub part: String,
    pub axes: Vec<AxisSummary>,
    /// Units that do not belong, the furthest first.
    pub odd: Vec<OddUnit>,
    /// So many units are needed to find an odd one, and there are fewer: that none is called odd is not conclusive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units_needed: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisSummary {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// Its population; none where too few units tell a coefficient.
    pub population: Option<Population>,
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
    pub unit: String,
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
    pub unit: String,
    pub reasons: Vec<String>,
}

/// A unit whose log is that of another one, bit by bit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DuplicateUnit {
    pub part: String,
    pub unit: String,
    /// The unit whose log counts.
    pub same_as: String,
}

impl std::fmt::Display for DuplicateUnit {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { unit, same_as, .. } = self;
        write!(out, "{unit} is the same log as {same_as}: counted once.")
    }
}

impl PartSummary {
    /// A sentence that says why the search for odd units is not conclusive, if it is not.
    pub fn not_conclusive(&self) -> Option<String> {
        let needed = self.units_needed?;
        let populations = self.axes.iter().filter_map(|axis| axis.population.as_ref());
        let devices = populations
            .map(|population| population.units)
            .max()
            .map_or_else(|| "no axis has a population".to_owned(), |devices| format!("{devices} devices"));
        Some(format!(
            "Not conclusive: {devices}; to find one that is {FAR} standard deviations off, at least {needed} are needed, and lots of several devices each."
        ))
    }
}

/// Why the rows of a fleet cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    #[error("{}: {source}\nhelp: the rows of a fleet are stored there, so that interrupted runs resume", path.display())]
    Rows {
        /// Where rows are kept.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no population, or of another schema.
    #[error("{}: not a population: {reason}\nhelp: make the population again; its schema is {SCHEMA}", path.display())]
    NotAPopulation {
        path: PathBuf,
        /// What is wrong, with its line and column.
        reason: String,
    },
    /// The rows beside a population are not those that it was made of.
    #[error("{}: {found} rows of {units} devices\nhelp: the rows of a population are beside it, under its name with .rows appended; if they are lost, make the population again", path.display())]
    OtherRows {
        /// The rows.
        path: PathBuf,
        /// Rows that can be read, of units of the population.
        found: usize,
        /// Units of the population.
        units: usize,
    },
    /// A line of the rows beside a population is none.
    #[error("{}:{line}: not the row of a device: {reason}\nhelp: make the population again; complete rows are reused", path.display())]
    NotARow {
        /// The rows.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        reason: String,
    },
    /// Something else is there.
    #[error("{}: a file of that name has other content than the rows of a fleet, and would be lost\nhelp: write to another file, or move that one away", .0.display())]
    NotRows(PathBuf),
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
            return Err(not(format!("{}: a number is missing or not finite", axis.column)));
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
                Ok(Kept { row, .. }) => match row.axes.iter().find(|axis| !axis.estimate.is_whole()) {
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
        let failed = units.iter().filter(|unit| !unit.failed().is_empty());
        let (mut parts, mut compared, mut duplicates) = (Vec::new(), Vec::new(), Vec::new());
        for units in units.chunk_by(|a, b| a.part() == b.part()) {
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
                .map(|unit| FailedUnit { unit: unit.name().to_owned(), reasons: unit.failed().to_vec() })
                .collect(),
            duplicates,
        }
    }
}

/// The units of a part whose logs are not those of an earlier one, and those whose logs are.
fn without_duplicates<'a>(units: &[GatheredUnit<'a>]) -> (Vec<GatheredUnit<'a>>, Vec<DuplicateUnit>) {
    let (mut first, mut duplicates) = (HashMap::new(), Vec::new());
    let is_new = |unit: &&GatheredUnit<'a>| {
        let Some(log) = unit.log() else { return true };
        let same_as = *first.entry(log).or_insert(unit.name());
        let is_new = same_as == unit.name();
        if !is_new {
            let [part, unit, same_as] = [unit.part(), unit.name(), same_as].map(str::to_owned);
            duplicates.push(DuplicateUnit { part, unit, same_as });
        }
        is_new
    };
    (units.iter().filter(is_new).copied().collect(), duplicates)
}

fn digest_of(units: &[GatheredUnit<'_>]) -> String {
    let mut digest = Sha256::new();
    units.iter().for_each(|unit| digest.update(unit.digest()));
    hexadecimal(&digest.finalize())
}

/// A unit that was compared with its populations: its axis that is least probable, with the p-values of all axes together.
struct Compared<'a> {
    unit: GatheredUnit<'a>,
    axes: usize,
    column: &'a str,
    distance: Distance,
    /// Probability that a unit that belongs is so far in any of its axes (Bonferroni).
    p_value: f64,
    /// p-values that it would have if it were far off in a coefficient of an axis.
    p_values_if_far: Vec<f64>,
}

/// An axis of a part, and of its units that have it, by their places, how far they are and which p-value they would have if they were far.
struct JudgedAxis<'a> {
    column: &'a str,
    summary: AxisSummary,
    distances: Vec<(usize, Distance, Vec<f64>)>,
}

/// The units of a part that were compared, and the coefficients that one of them has on all its axes.
struct OfPart<'a> {
    compared: Vec<Compared<'a>>,
    tests: usize,
}

/// A part without its odd units, and what they are found by.
fn part_summary<'a>(
    units: &[GatheredUnit<'a>],
    asked: &Asked,
    library: &Library,
) -> (PartSummary, OfPart<'a>) {
    let columns: BTreeSet<&str> = units.iter().flat_map(|unit| unit.columns()).collect();
    let columns: Vec<&str> = columns.into_iter().collect();
    let axes: Vec<_> =
        columns.into_par_iter().map(|column| judged_axis(column, units, asked, library)).collect();
    let mut compared: Vec<Option<Compared<'_>>> = units.iter().map(|_| None).collect();
    let mut summaries = Vec::new();
    for JudgedAxis { column, summary, distances } in axes {
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
    let part = units.first().map_or_else(String::new, |unit| unit.part().to_owned());
    let mut compared: Vec<Compared<'_>> = compared.into_iter().flatten().collect();
    for unit in &mut compared {
        let axes = unit.axes as f64;
        unit.p_value = (unit.distance.p_value * axes).min(1.0);
        unit.p_values_if_far.iter_mut().for_each(|p_value| *p_value *= axes);
    }
    let tests = units.iter().map(|unit| unit.coefficients()).max().unwrap_or(1);
    (PartSummary { part, axes: summaries, odd: Vec::new(), units_needed: None }, OfPart { compared, tests })
}

fn judged_axis<'a>(
    column: &'a str,
    units: &[GatheredUnit<'_>],
    asked: &Asked,
    library: &Library,
) -> JudgedAxis<'a> {
    let of_units = units.iter().enumerate().filter_map(|(index, unit)| Some((index, unit.axis(column)?)));
    // a number that is not finite says nothing
    let of_units: Vec<_> = of_units.filter(|(_, axis)| axis.is_finite()).collect();
    let members: Vec<Member<'_>> = of_units
        .iter()
        .map(|(index, axis)| Member { lot: units[*index].lot(), estimate: &axis.estimate })
        .collect();
    let judged = judge(&members, &names_of(&members, asked));
    let noise = |level: usize| median_of(of_units.iter().map(|(_, axis)| axis.noise[level])).unwrap_or(0.0);
    let without = judged.as_ref().err().map(ToString::to_string);
    let (population, distances) = judged.map_or((None, Vec::new()), |judged| {
        let distances: Vec<_> = judged.distances.into_iter().zip(judged.p_values_if_far).collect();
        (Some(judged.population), distances)
    });
    JudgedAxis {
        column,
        summary: AxisSummary {
            column: column.to_owned(),
            without,
            population,
            median_noise: [0, 1, 2].map(noise),
            effects: effects_of(units.iter().filter_map(|unit| unit.effects(column)), library),
        },
        distances: of_units
            .iter()
            .zip(distances)
            .filter(|(_, (distance, _))| distance.coefficients > 0)
            .map(|((index, _), (distance, if_far))| (*index, distance, if_far))
            .collect(),
    }
}

/// Bias and regressors, those that at least three units tell.
fn names_of(members: &[Member<'_>], asked: &Asked) -> Vec<String> {
    let all = std::iter::once(BIAS).chain(asked.regressors.iter().map(String::as_str));
    let told =
        all.filter(|name| members.iter().filter(|member| member.estimate.place(name).is_some()).count() >= 3);
    told.map(str::to_owned).collect()
}

/// The odd units of all parts: at most [`FALSE_ODD`] of them belong, over all tests of the fleet; and where none could be found, how many
/// units that would take.
fn add_odd_units(parts: &mut [PartSummary], of_parts: Vec<OfPart<'_>>) {
    let p_values: Vec<f64> =
        of_parts.iter().flat_map(|part| &part.compared).map(|unit| unit.p_value).collect();
    let mut found = discoveries(&p_values, FALSE_ODD).into_iter();
    // an odd unit that is the only one has to come below this
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
                unit: unit.name().to_owned(),
                lot: unit.lot().map(str::to_owned),
                column: column.to_owned(),
                distance,
                p_value,
            })
            .collect();
        part.odd.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then_with(|| a.unit.cmp(&b.unit)));
    }
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
