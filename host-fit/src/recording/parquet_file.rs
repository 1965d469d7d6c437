//! Reads Parquet: every column of numbers, flags or instants as f64.

use std::collections::HashMap;
use std::path::Path;

use arrow_array::{Array, ArrayRef, Float64Array, Int64Array, StringArray};
use arrow_cast::cast;
use arrow_schema::{ArrowError, DataType, TimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::errors::ParquetError;
use parquet::file::reader::ChunkReader;

use super::column_map::ColumnMap;
use super::error::RecordingError;
use super::table::{Column, Table, check_names, column_name, must_be_numeric};

/// Rows decoded at once: enough to be quick, little beside the data.
const BATCH_ROWS: usize = 65_536;

/// How a column becomes numbers.
enum Kind {
    Numbers,
    /// An instant or a duration: seconds since the first one, taken as integers so that no digit is lost.
    Seconds {
        per_second: f64,
        first: Option<i64>,
    },
    /// Each different content gets a number, in order of appearance.
    Labels(HashMap<String, f64>),
}

/// Reads a whole file, or its first `rows`.
pub(super) fn read(
    path: &Path,
    input: impl ChunkReader + 'static,
    map: &ColumnMap,
    rows: Option<usize>,
) -> Result<Table, RecordingError> {
    let failed = |source: ParquetError| RecordingError::Parquet { path: path.to_owned(), source };
    let builder = ParquetRecordBatchReaderBuilder::try_new(input).map_err(failed)?;
    let fields = builder.schema().fields().clone();
    let names: Vec<String> =
        fields.iter().enumerate().map(|(i, field)| column_name(field.name(), i)).collect();
    check_names(path, &names)?;

    let mut table = Table::default();
    let mut kinds = Vec::new();
    let mut selected = Vec::new();
    let n_rows = usize::try_from(builder.metadata().file_metadata().num_rows()).unwrap_or(0);
    for (i, (field, name)) in fields.iter().zip(&names).enumerate() {
        if map.ignores(name) {
            continue;
        }
        let Some(kind) = kind_of(field.data_type(), name == map.column_of("segment")) else {
            if must_be_numeric(name, map) {
                return Err(RecordingError::TextColumn { path: path.to_owned(), column: name.clone() });
            }
            table.quality.text_columns.push(name.clone());
            continue;
        };
        kinds.push(kind);
        selected.push(i);
        table.columns.push(Column { name: name.clone(), values: Vec::with_capacity(n_rows) });
    }
    if selected.is_empty() {
        let problem = "no column holds numbers".into();
        return Err(RecordingError::NotALog { path: path.to_owned(), problem });
    }

    // columns that are left out are not even decoded
    let projection = ProjectionMask::roots(builder.parquet_schema(), selected);
    let builder = builder.with_projection(projection).with_batch_size(BATCH_ROWS);
    let builder = match rows {
        Some(rows) => builder.with_limit(rows),
        None => builder,
    };
    let reader = builder.build().map_err(failed)?;
    let mut empty = vec![0; table.columns.len()];
    for batch in reader {
        crate::interrupt::check();
        let batch = batch.map_err(|error| failed(error.into()))?;
        for (i, array) in batch.columns().iter().enumerate() {
            append(array, &mut kinds[i], &mut table.columns[i].values)
                .map_err(|error| failed(error.into()))?;
            empty[i] += array.null_count() as u64;
        }
    }
    table.quality.rows_in_file = table.n_rows() as u64;
    for (i, empty) in empty.into_iter().enumerate() {
        table.note_missing_cells(i, empty);
    }
    Ok(table)
}

/// How to read a column of this type; `None` if it holds nothing that is a number.
fn kind_of(data_type: &DataType, is_segment: bool) -> Option<Kind> {
    let seconds = |unit: &TimeUnit| {
        let per_second = match unit {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e3,
            TimeUnit::Microsecond => 1e6,
            TimeUnit::Nanosecond => 1e9,
        };
        Kind::Seconds { per_second, first: None }
    };
    match data_type {
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(seconds(unit)),
        DataType::Dictionary(_, values) => kind_of(values, is_segment),
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View if is_segment => {
            Some(Kind::Labels(HashMap::new()))
        }
        number if number.is_numeric() || *number == DataType::Boolean => Some(Kind::Numbers),
        _ => None,
    }
}

/// Adds the cells of `array` to `values`; null becomes NaN.
fn append(array: &ArrayRef, kind: &mut Kind, values: &mut Vec<f64>) -> Result<(), ArrowError> {
    match kind {
        Kind::Numbers => {
            let numbers = cast(array, &DataType::Float64)?;
            let numbers: &Float64Array = downcast(&numbers)?;
            if numbers.null_count() == 0 {
                values.extend_from_slice(numbers.values());
            } else {
                values.extend(numbers.iter().map(|cell| cell.unwrap_or(f64::NAN)));
            }
        }
        Kind::Seconds { per_second, first } => {
            let ticks = cast(array, &DataType::Int64)?;
            let ticks: &Int64Array = downcast(&ticks)?;
            values.extend(ticks.iter().map(|cell| {
                cell.map_or(f64::NAN, |tick| {
                    // in i128, since the span of two i64 may not fit in one
                    let since = i128::from(tick) - i128::from(*first.get_or_insert(tick));
                    since as f64 / *per_second
                })
            }));
        }
        Kind::Labels(labels) => {
            let texts = cast(array, &DataType::Utf8)?;
            let texts: &StringArray = downcast(&texts)?;
            values.extend(texts.iter().map(|cell| {
                cell.map_or(f64::NAN, |text| {
                    let next = labels.len() as f64;
                    *labels.entry(text.to_owned()).or_insert(next)
                })
            }));
        }
    }
    Ok(())
}

fn downcast<T: 'static>(array: &ArrayRef) -> Result<&T, ArrowError> {
    array.as_any().downcast_ref().ok_or_else(|| {
        ArrowError::CastError(format!("a column of type {} did not convert", array.data_type()))
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow_array::{BooleanArray, Float32Array, Int16Array, RecordBatch, TimestampNanosecondArray};
    use parquet::arrow::ArrowWriter;

    use super::super::{Boundary, LoadOptions, Unit, load};
    use super::*;

    #[test]
    fn instants_flags_integers_labels_and_nulls_are_understood() {
        // 2023-11-14 in ns, where f64 would round stamps to 256 ns
        let instants: Vec<i64> = (0..6).map(|i| 1_700_000_000_000_000_001 + i * 5_000_000).collect();
        let batch = RecordBatch::try_from_iter([
            ("time", Arc::new(TimestampNanosecondArray::from(instants)) as ArrayRef),
            ("gx", Arc::new(Int16Array::from(vec![Some(100), None, Some(-3), Some(4), Some(5), Some(6)]))),
            ("temp_c", Arc::new(Float32Array::from(vec![0.1_f32; 6]))),
            ("still", Arc::new(BooleanArray::from(vec![true, true, true, false, false, true]))),
            ("segment", Arc::new(StringArray::from(vec!["a", "a", "b", "b", "b", "b"]))),
            ("note", Arc::new(StringArray::from(vec!["x"; 6]))),
        ])
        .unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.parquet");
        let mut writer =
            ArrowWriter::try_new(std::fs::File::create(&path).unwrap(), batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();

        let columns = ColumnMap::from_specs(["t_s=time", "gx_rads=gx:/131:dps"]).unwrap();
        let log = load(&path, &LoadOptions { columns, ..LoadOptions::default() }).unwrap();
        assert_eq!(log.time_s, [0.0, 0.005, 0.01, 0.015, 0.02, 0.025]);
        assert_eq!(log.quality.text_columns, ["note"]);
        assert_eq!(log.still_rows(), [0..2, 2..3, 5..6]);
        assert_eq!((log.segments[1].rows.start, log.segments[1].boundary), (2, Boundary::SegmentColumn));
        let rate = log.channel("gx_rads").unwrap();
        assert_eq!((rate.unit, rate.n_missing()), (Unit::RadianPerSecond, 1));
        assert!((rate.values[0] - (100.0_f64 / 131.0).to_radians()).abs() < 1e-15);
        assert_eq!(log.channel("temp_c").unwrap().values[0], f64::from(0.1_f32));
        assert_eq!(log.quality.missing_cells[0].empty, 1);
    }
}
