//! Logs: read from files, or made from arrays.

use std::path::PathBuf;
use std::sync::Arc;

use fos_data::column::Column as Name;
use fos_data::disturbance;
use fos_data::recording::{
    self as data, Boundary, ColumnMap, KNOWN_FORMATS, LoadOptions, Source, write_columns,
};
use fos_data::stillness;
use fos_data::unit::Unit;
use numpy::PyArray1;
use pyo3::prelude::*;
use serde_json::json;
use sha2::{Digest as _, Sha256};

use crate::arrays::Column;
use crate::error::{py_error, raised};
use crate::work;

/// Measured data of one sensor.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Recording {
    pub(crate) log: Arc<data::Recording>,
    pub(crate) read: LoadOptions,
}

/// Options for reading a log.
pub(crate) fn options(
    py: Python<'_>,
    map: &[String],
    rate_hz: Option<f64>,
    format: Option<&str>,
    topic: Option<String>,
    (strict, keep_moved): (bool, bool),
) -> PyResult<LoadOptions> {
    let columns = ColumnMap::from_specs(map);
    let columns = columns.map_err(|error| py_error(py, "RecordingError", &error.to_string()))?;
    let format = format.map(str::parse).transpose();
    let format = format.map_err(|error| py_error(py, "RecordingError", &format!("{error}")))?;
    Ok(LoadOptions { columns, rate_hz, format, topic, strict, keep_moved })
}

/// Reads a log in any known format.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of `fos_imu.read`")]
pub(crate) fn load(
    py: Python<'_>,
    path: PathBuf,
    map: Vec<String>,
    rate_hz: Option<f64>,
    format: Option<String>,
    topic: Option<String>,
    strict: bool,
    keep_moved: bool,
) -> PyResult<Recording> {
    let read = options(py, &map, rate_hz, format.as_deref(), topic, (strict, keep_moved))?;
    let log = work::run(py, || data::load(&path, &read))?.map_err(raised(py))?;
    Ok(Recording { log: Arc::new(log), read })
}

/// Supported formats: identifier and description.
#[pyfunction]
pub(crate) fn formats() -> Vec<(String, String)> {
    KNOWN_FORMATS.iter().map(|known| (known.id.to_owned(), known.name.to_owned())).collect()
}

/// Makes a log from columns in memory, identified by a digest of their names and values.
pub(crate) fn of_columns(
    name: &str,
    columns: Vec<(String, Vec<f64>)>,
    read: &LoadOptions,
) -> Result<data::Recording, data::RecordingError> {
    let mut digest = Sha256::new();
    for (name, values) in &columns {
        digest.update((name.len() as u64).to_le_bytes());
        digest.update(name.as_bytes());
        digest.update((values.len() as u64).to_le_bytes());
        for value in values {
            digest.update(value.to_le_bytes());
        }
    }
    let sha256 = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    let source = Source { sha256, ..Source::made_by(name) };
    data::Recording::from_columns(source, columns, read)
}

#[pymethods]
impl Recording {
    /// Makes a log from columns with names of the log format.
    #[staticmethod]
    fn from_columns(
        py: Python<'_>,
        name: &str,
        columns: Vec<(String, Column<'_>)>,
        map: Vec<String>,
        rate_hz: Option<f64>,
        keep_moved: bool,
    ) -> PyResult<Self> {
        let read = options(py, &map, rate_hz, None, None, (false, keep_moved))?;
        let columns: Vec<_> = columns.iter().map(|(name, values)| (name.clone(), values.to_vec())).collect();
        let log = work::run(py, || of_columns(name, columns, &read))?.map_err(raised(py))?;
        Ok(Self { log: Arc::new(log), read })
    }

    /// All properties except the columns, as JSON.
    fn summary(&self) -> String {
        let log = &self.log;
        let channels: Vec<_> = log
            .channels()
            .iter()
            .map(|channel| {
                json!({
                    "name": channel.name,
                    "unit": channel.unit.label(),
                    "label": Name::named(&channel.name).label(),
                    "missing": channel.n_missing(),
                })
            })
            .collect();
        let segments: Vec<[usize; 2]> = log.segments.iter().map(|s| [s.rows.start, s.rows.end]).collect();
        let joined = log.alignment.as_ref().map_or_else(String::new, ToString::to_string);
        let read_as = log.sources.iter().filter_map(|source| source.read_as.as_ref());
        let quality = log.quality.to_string();
        let notes: Vec<String> = read_as
            .map(ToString::to_string)
            .chain(joined.lines().chain(quality.lines()).map(str::to_owned))
            .collect();
        json!({
            "sources": log.sources,
            "n_rows": log.n_rows(),
            "duration_s": log.duration_s(),
            "rate_hz": log.rate.true_hz,
            "period_s": log.rate.period_s,
            "jitter_s": log.rate.jitter_s,
            "samples_missing": log.samples_missing(),
            "segments": segments,
            "channels": channels,
            "notes": notes,
        })
        .to_string()
    }

    /// Detected rest, the method of detection, and descriptions of detected motion on a device meant to be at rest.
    fn stillness<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray1<bool>>, String, Vec<String>)> {
        let log = Arc::clone(&self.log);
        let (still, known_by, moved) = work::run(py, move || {
            let stillness = stillness::find(&log);
            let moved = disturbance::describe_disturbances(&log, &stillness.disturbances);
            (stillness.still, stillness.known_by.describe(), moved)
        })?;
        Ok((PyArray1::from_vec(py, still), known_by.to_owned(), moved))
    }

    /// Timestamps, s.
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.log.time_s)
    }

    /// Values of a channel, in its unit; NaN for empty cells.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let channel = self.log.channel(name).map_err(raised(py))?;
        Ok(PyArray1::from_slice(py, &channel.values))
    }

    /// Rest as stated in the log.
    fn still<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        self.log.still.as_ref().map(|still| PyArray1::from_slice(py, still))
    }

    /// Column of an axis named `gx` or by its column.
    pub(crate) fn axis(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        Ok(self.log.axis(name).map_err(raised(py))?.name.clone())
    }

    /// Writes the log as `.csv`, `.csv.gz` or `.parquet`.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let log = &self.log;
        work::run(py, || {
            let still: Option<Vec<f64>> = log
                .still
                .as_ref()
                .map(|still| still.iter().map(|still| f64::from(u8::from(*still))).collect());
            // Gaps visible in the timestamps are found again from them.
            let mut label = 0.0;
            let labels = log.segments.iter().flat_map(|segment| {
                let by_stamps = matches!(segment.boundary, Boundary::Gap | Boundary::Pause | Boundary::Start);
                label += if by_stamps { 0.0 } else { 1.0 };
                vec![label; segment.rows.len()]
            });
            let labels: Vec<f64> = labels.collect();
            let segment = labels.last().is_some_and(|last| *last > 0.0).then_some(labels);
            let mut columns = vec![("t_s", log.time_s.as_slice())];
            columns.extend(log.channels().iter().map(|c| (c.name.as_str(), c.values.as_slice())));
            columns.extend(still.as_ref().map(|still| ("still", still.as_slice())));
            columns.extend(segment.as_ref().map(|segment| ("segment", segment.as_slice())));
            write_columns(&path, &columns)
        })?
        .map_err(raised(py))
    }
}

/// Unit in the name of a column, for people.
pub(crate) fn unit_of(column: &str) -> &'static str {
    Unit::of_column(column).label()
}
