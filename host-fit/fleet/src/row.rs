//! A unit in one row: the coefficients estimated from its logs, or the reasons for their absence.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::PathBuf;

use fos_core::{StillnessLimits, Transform};
use fos_data::catch_panic::catch_panic;
use fos_data::column::Triad;
use fos_data::recording::{LoadOptions, Recording, Source, load};
use fos_data::stillness;
use fos_data::text::hexadecimal;
use fos_diagnose::detect::{Question, Verdict, diagnose};
use fos_diagnose::effects::{Inputs, Library, Regressor};
use fos_fit::fit::InputSpec;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::estimate::{AxisEstimate, EstimateError, estimate, from_reference};

/// Settings common to all units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// Regressors whose coefficients are compared between units, beside the bias: `temp_c`, `temp_c * temp_c`, ….
    pub regressors: Vec<String>,
    /// Every axis is also diagnosed, which takes most of the time.
    pub diagnosed: bool,
    pub read: LoadOptions,
}

/// A unit and its logs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unit {
    /// Name, unique in the fleet.
    pub name: String,
    /// Part, such as `bmi270`; units of different parts are never compared. If empty, all units are of one part.
    pub part: String,
    /// Production lot, if known.
    pub lot: Option<String>,
    /// Logs of the unit, used together.
    pub logs: Vec<PathBuf>,
}

/// A unit and the estimates from its logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitRow {
    /// Name of the unit, from [`Unit`].
    pub unit: String,
    /// Part of the unit, from [`Unit`].
    pub part: String,
    /// Lot of the unit, from [`Unit`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lot: Option<String>,
    /// Program and version that made the row.
    pub program: String,
    /// Settings; rows with different settings do not form a fleet.
    pub asked: Asked,
    /// SHA-256 of the log, hexadecimal; for several logs the SHA-256 of their digests, one per line. Empty if no log could be read.
    pub sha256: String,
    /// Summary of the logs; none if no log could be read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LogSummary>,
    /// Axes that could be estimated.
    pub axes: Vec<AxisRow>,
    /// Reasons why the logs or an axis could not be used, each once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<String>,
}

/// Summary of the logs of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogSummary {
    /// Number of rows.
    pub rows: usize,
    /// Time from the first row to the last, s.
    pub seconds: f64,
    /// True sampling rate, Hz.
    pub rate_hz: f64,
    /// Lowest and highest temperature, °C; none without a temperature column.
    pub temperature_c: Option<[f64; 2]>,
    /// Lowest and highest value of every input of the regressors and of its column, by their texts. Temperatures are relative to
    /// [`REFERENCE_C`](crate::REFERENCE_C).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub inputs: BTreeMap<String, [f64; 2]>,
    /// Limits for the detection of rest; none without all six axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stillness: Option<StillnessLimits<f64>>,
    /// Correction applied to the values before they were logged; none if they are raw or the log does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corrected_by: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisRow {
    #[serde(flatten)]
    pub estimate: AxisEstimate,
    /// Result of the diagnosis, if one was made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<AxisDiagnosis>,
}

/// Result of the diagnosis of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisDiagnosis {
    /// States whether an effect is missing.
    pub verdict: Verdict,
    /// Missing effects without a doubt against them.
    pub effects: Vec<FoundEffect>,
}

/// An effect that was found on a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundEffect {
    pub effect: String,
    /// Predicted relative reduction of the error in the band of the effect.
    pub predicted_reduction: f64,
}

impl UnitRow {
    /// Row of a column, if the axis could be estimated.
    pub fn axis(&self, column: &str) -> Option<&AxisRow> {
        self.axes.iter().find(|axis| axis.estimate.column == column)
    }
}

/// Computes the row of a unit. It cannot fail: the row has the reasons, and a panic on the data of a log is one of them, so that one log
/// never ends a fleet. An unreadable log is excluded and reported in the row.
pub fn unit_row(unit: &Unit, asked: &Asked, library: &Library, program: &str) -> UnitRow {
    row_of(unit, unit.logs.iter().map(|log| load(log, &asked.read)), asked, library, program)
}

/// Computes the row of [`unit_row`] from logs that were read, or the reasons why they could not be; `unit.logs` is not
/// used.
pub fn row_of<E: Display>(
    unit: &Unit,
    read: impl IntoIterator<Item = Result<Recording, E>>,
    asked: &Asked,
    library: &Library,
    program: &str,
) -> UnitRow {
    let mut row = UnitRow {
        unit: unit.name.clone(),
        part: unit.part.clone(),
        lot: unit.lot.clone(),
        program: program.to_owned(),
        asked: asked.clone(),
        sha256: String::new(),
        log: None,
        axes: Vec::new(),
        failed: Vec::new(),
    };
    let mut logs: Vec<Recording> = Vec::new();
    let mut read = read.into_iter();
    loop {
        match catch_panic(|| read.next()) {
            Ok(None) => break,
            Ok(Some(Ok(log))) => match logs.iter().find(|other| is_same(other, &log)) {
                Some(other) => row.failed.push(format!(
                    "{} is the same log as {}: counted once\nhelp: give each log of a device once",
                    path_of(&log),
                    path_of(other)
                )),
                None => logs.push(log),
            },
            Ok(Some(Err(error))) => row.failed.push(error.to_string()),
            Err(panic) => row.failed.push(unusable("read", &panic)),
        }
    }
    if !logs.is_empty() {
        match catch_panic(|| Recording::join(logs)) {
            Ok(Ok(joined)) => fill(&mut row, &joined, asked, library),
            Ok(Err(error)) => row.failed.push(error.to_string()),
            Err(panic) => row.failed.push(unusable("joined", &panic)),
        }
    }
    row
}

fn unusable(what: &str, panic: &str) -> String {
    format!(
        "the log cannot be {what}: {panic}\nhelp: this is a defect of the program; report it with the log, the other logs are not affected"
    )
}

fn is_same(one: &Recording, other: &Recording) -> bool {
    let digest = digest_of(&one.sources);
    !digest.is_empty() && digest == digest_of(&other.sources)
}

fn path_of(log: &Recording) -> String {
    log.sources.first().map_or_else(String::new, |source| source.path.clone())
}

/// Digest of the only source, or of all digests. Empty for data that do not come from files.
fn digest_of(sources: &[Source]) -> String {
    match sources {
        several if several.iter().any(|source| source.sha256.is_empty()) => String::new(),
        [only] => only.sha256.clone(),
        several => {
            let mut digest = Sha256::new();
            several.iter().for_each(|source| digest.update(format!("{}\n", source.sha256)));
            hexadecimal(&digest.finalize())
        }
    }
}

fn fill(row: &mut UnitRow, recording: &Recording, asked: &Asked, library: &Library) {
    row.sha256 = digest_of(&recording.sources);
    match catch_panic(|| summary_of(recording, asked)) {
        Ok(summary) => row.log = Some(summary),
        Err(panic) => row.failed.push(unusable("summarised", &panic)),
    }
    let axes = match recording.axes() {
        Ok(axes) => axes,
        Err(error) => return row.failed.push(error.to_string()),
    };
    let empty = recording.quality.empty_axes.iter().filter_map(|axis| recording.axis(axis).err());
    row.failed.extend(empty.map(|error| error.to_string()));
    for column in &axes {
        let axis = catch_panic(|| axis_of(recording, column, asked, library))
            .unwrap_or_else(|panic| Err(unusable("estimated", &panic)));
        match axis {
            Ok(axis) => row.axes.push(axis),
            Err(reason) if !row.failed.contains(&reason) => row.failed.push(reason),
            Err(_) => {}
        }
    }
}

fn summary_of(recording: &Recording, asked: &Asked) -> LogSummary {
    let stillness = stillness::limits(recording, &(0..recording.n_rows()));
    LogSummary {
        rows: recording.n_rows(),
        seconds: recording.duration_s(),
        rate_hz: recording.rate.true_hz,
        temperature_c: recording.channel("temp_c").ok().and_then(|channel| range(&channel.values)),
        inputs: ranges(recording, &asked.regressors),
        stillness: stillness.filter(|limits| {
            let values = [limits.accel_variance, limits.gyro_variance, limits.gyro_deviation];
            values.iter().chain(&limits.gyro_at_rest).all(|value| value.is_finite())
        }),
        corrected_by: [Triad::Accelerometers, Triad::Gyros]
            .into_iter()
            .find_map(|triad| recording.provenance(triad).corrected_by().map(str::to_owned)),
    }
}

fn axis_of(recording: &Recording, column: &str, asked: &Asked, library: &Library) -> Result<AxisRow, String> {
    let estimate = estimate(recording, column, &asked.regressors, None)
        .map_err(|error: EstimateError| error.to_string())?;
    if !estimate.is_complete() {
        return Err(format!(
            "{column}: its coefficients are not finite\nhelp: check the log for values that are far too large"
        ));
    }
    let diagnosis = asked.diagnosed.then(|| diagnosed(recording, column, library)).transpose()?;
    Ok(AxisRow { estimate, diagnosis })
}

/// Lowest and highest finite value, if there is one.
fn range(values: &[f64]) -> Option<[f64; 2]> {
    let finite = values.iter().copied().filter(|value| value.is_finite()).map(|value| [value; 2]);
    finite.reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
}

/// Ranges of the inputs of all valid regressors whose columns are logged.
fn ranges(recording: &Recording, regressors: &[String]) -> BTreeMap<String, [f64; 2]> {
    let log = from_reference(recording);
    let inputs = Inputs::new(&log);
    let mut ranges = BTreeMap::new();
    for regressor in regressors.iter().filter_map(|text| Regressor::parse(text).ok()) {
        for input in regressor.inputs() {
            let column = InputSpec { column: input.column.clone(), transform: Transform::Identity };
            for spec in [input, &column].into_iter().filter(|spec| spec.column.is_some() || *spec == input) {
                let seen = inputs.input(spec).ok().and_then(|values| range(&values));
                ranges.extend(seen.map(|seen| (spec.to_string(), seen)));
            }
        }
    }
    ranges
}

fn diagnosed(recording: &Recording, column: &str, library: &Library) -> Result<AxisDiagnosis, String> {
    let question = Question::new(recording, column, library);
    let answer = diagnose(&question).map_err(|error| error.to_string())?;
    let believed = answer.findings.iter().filter(|finding| finding.doubt.is_none());
    let effects = believed.map(|finding| FoundEffect {
        effect: finding.effect.clone(),
        predicted_reduction: finding.predicted_reduction,
    });
    Ok(AxisDiagnosis { verdict: answer.verdict, effects: effects.collect() })
}
