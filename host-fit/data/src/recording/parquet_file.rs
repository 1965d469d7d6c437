//! Reads Parquet: every column of numbers, flags or instants as f64.

use std::collections::HashMap;
use std::path::Path;

use half::f16;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType, FixedLenByteArray};
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader};
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::schema::types::ColumnDescriptor;

use super::column_map::ColumnMap;
use super::error::RecordingError;
use super::parquet_input::Ending;
use super::table::{Column, Table, check_names, column_name, must_be_numeric};
use crate::catch_panic::catch_panic;

/// Number of cells decoded at once: large enough to be fast, small compared with the data.
const BATCH_CELLS: usize = 65_536;

/// Maximum number of cells reserved in advance: an hour at 200 Hz.
const MAX_AHEAD: usize = 720_000;

/// Interpretation of the cells of a column.
enum Kind {
    /// Numbers, flags; integers are divided by `divisor`, which is a power of ten for decimals.
    Numbers { unsigned: bool, divisor: f64 },
    /// 16-bit floats.
    Halves,
    /// Instants as seconds since the first one, subtracted as integers so that no digit is lost.
    Seconds { per_second: f64, first: Option<i64> },
    /// Labels: each distinct value gets a number, in order of appearance.
    Labels(HashMap<Vec<u8>, f64>),
}

/// A column of the file to read.
struct Selected {
    /// Index of its first leaf among those of the file.
    index: usize,
    /// True if cells may be empty.
    optional: bool,
    kind: Kind,
    empty: u64,
}

/// Reads a whole file, or its first `rows`.
pub(super) fn read(
    path: &Path,
    input: impl ChunkReader + 'static,
    map: &ColumnMap,
    rows: Option<usize>,
) -> Result<Table, RecordingError> {
    let failed = |source: ParquetError| match source.to_string().contains("encrypt") {
        true => RecordingError::OtherFormat {
            path: path.to_owned(),
            is: format!("the Parquet file is encrypted ({source})"),
            help: "write it again without encryption",
        },
        false => RecordingError::Parquet { path: path.to_owned(), source },
    };
    let reader = library(|| SerializedFileReader::new(Ending(input))).map_err(failed)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let fields = schema.root_schema().get_fields();
    let names: Vec<String> =
        fields.iter().enumerate().map(|(i, field)| column_name(field.name(), i)).collect();
    check_names(path, &names)?;

    let mut table = Table::default();
    let mut selected: Vec<Selected> = Vec::new();
    let mut index = 0;
    for (i, (field, name)) in fields.iter().zip(&names).enumerate() {
        // a nested field has several leaf columns, and is no number
        let first = index;
        while index < schema.num_columns() && schema.get_column_root_idx(index) == i {
            index += 1;
        }
        if map.ignores(name) {
            table.ignored.push(name.clone());
            continue;
        }
        let kind = match field.is_primitive() && index == first + 1 {
            true => kind_of(&schema.column(first), name == map.column_of("segment")),
            false => None,
        };
        let Some(kind) = kind else {
            if must_be_numeric(name, map) {
                return Err(RecordingError::TextColumn {
                    path: path.to_owned(),
                    column: name.clone(),
                    first: None,
                });
            }
            table.quality.text_columns.push(name.clone());
            continue;
        };
        let optional = schema.column(first).max_def_level() > 0;
        selected.push(Selected { index: first, optional, kind, empty: 0 });
        table.columns.push(Column { name: name.clone(), values: Vec::new() });
    }
    if selected.is_empty() {
        let problem = "no column holds numbers".into();
        return Err(RecordingError::NotALog { path: path.to_owned(), problem });
    }

    for group in reader.metadata().row_groups() {
        for (column, selected) in table.columns.iter().zip(&selected) {
            if let Some(codec) = not_unpacked(group.column(selected.index).compression()) {
                return Err(RecordingError::OtherFormat {
                    path: path.to_owned(),
                    is: format!(
                        "column \"{}\" is compressed by {codec}, which is not read here",
                        column.name
                    ),
                    help: REWRITE,
                });
            }
        }
    }

    let most = rows.unwrap_or(usize::MAX);
    for group in 0..reader.num_row_groups() {
        let group = library(|| reader.get_row_group(group)).map_err(failed)?;
        let start = table.n_rows();
        let stated = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let rows = stated.min(most - start);
        if rows == 0 {
            continue;
        }
        // ignored columns are not even decoded
        for (column, selected) in table.columns.iter_mut().zip(&mut selected) {
            let cells = library(|| group.get_column_reader(selected.index)).map_err(failed)?;
            append(cells, selected, &mut column.values, rows).map_err(failed)?;
            let found = column.values.len() - start;
            if found != rows {
                let text =
                    format!("column \"{}\" has {found} cells where the file declares {rows}", column.name);
                return Err(failed(ParquetError::General(text)));
            }
        }
    }
    // the row count of the metadata is not trusted for allocation, so the final size is only known now
    table.columns.iter_mut().for_each(|column| column.values.shrink_to_fit());
    table.quality.rows_in_file = table.n_rows() as u64;
    for (i, selected) in selected.iter().enumerate() {
        table.note_missing_cells(i, selected.empty);
    }
    Ok(table)
}

/// Instructions for rewriting a file with a supported codec.
const REWRITE: &str = "write it again with zstd, Snappy, gzip or uncompressed: in Python, pyarrow.parquet.write_table(pyarrow.parquet.read_table(\"a.parquet\"), \"b.parquet\", compression=\"zstd\")";

/// Name of the codec if the library was built without it (docs/decisions/libraries.md).
fn not_unpacked(codec: Compression) -> Option<&'static str> {
    match codec {
        Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::GZIP(_) | Compression::ZSTD(_) => None,
        Compression::BROTLI(_) => Some("Brotli"),
        Compression::LZ4 | Compression::LZ4_RAW => Some("LZ4"),
        Compression::LZO => Some("LZO"),
    }
}

/// Calls the library, which panics on some damaged metadata, such as a column offset before the begin of the file.
fn library<T>(call: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    catch_panic(call)
        .unwrap_or_else(|panic| Err(ParquetError::General(format!("the file is damaged ({panic})"))))
}

/// Interpretation of a column; `None` if it is not numeric.
///
/// Newer writers state the meaning by the logical type, older ones by the converted type alone.
fn kind_of(column: &ColumnDescriptor, is_segment: bool) -> Option<Kind> {
    use ConvertedType as Old;
    if column.max_rep_level() > 0 {
        return None;
    }
    let seconds = |per_second| Some(Kind::Seconds { per_second, first: None });
    let integers = |unsigned| Some(Kind::Numbers { unsigned, divisor: 1.0 });
    let decimals = |scale: i32| Some(Kind::Numbers { unsigned: false, divisor: 10.0_f64.powi(scale) });
    let physical = column.physical_type();
    match physical {
        Physical::BOOLEAN | Physical::FLOAT | Physical::DOUBLE => integers(false),
        Physical::INT96 => seconds(1e9),
        Physical::INT32 | Physical::INT64 => match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(stamp)), _) => match stamp.unit {
                TimeUnit::MILLIS => seconds(1e3),
                TimeUnit::MICROS => seconds(1e6),
                TimeUnit::NANOS => seconds(1e9),
            },
            (Some(LogicalType::Integer(integer)), _) => integers(!integer.is_signed),
            (Some(LogicalType::Decimal(decimal)), _) => decimals(decimal.scale),
            (None, Old::TIMESTAMP_MILLIS) => seconds(1e3),
            (None, Old::TIMESTAMP_MICROS) => seconds(1e6),
            (None, Old::UINT_8 | Old::UINT_16 | Old::UINT_32 | Old::UINT_64) => integers(true),
            (None, Old::DECIMAL) => decimals(column.type_scale()),
            (None, Old::NONE | Old::INT_8 | Old::INT_16 | Old::INT_32 | Old::INT_64) => integers(false),
            // a date, a time of the day
            _ => None,
        },
        Physical::FIXED_LEN_BYTE_ARRAY => match column.logical_type_ref() {
            Some(LogicalType::Float16) if column.type_length() == 2 => Some(Kind::Halves),
            Some(LogicalType::Decimal(decimal)) if column.type_length() <= 16 => decimals(decimal.scale),
            _ => None,
        },
        Physical::BYTE_ARRAY => {
            let is_text = matches!(column.logical_type_ref(), Some(LogicalType::String))
                || column.converted_type() == Old::UTF8;
            (is_segment && is_text).then(|| Kind::Labels(HashMap::new()))
        }
    }
}

/// Appends the first `rows` cells of a column to `values`; empty ones become NaN.
fn append(
    cells: ColumnReader,
    selected: &mut Selected,
    values: &mut Vec<f64>,
    rows: usize,
) -> Result<(), ParquetError> {
    let Selected { optional, kind, empty, .. } = selected;
    let into = Into { values, rows, optional: *optional, empty };
    match cells {
        ColumnReader::BoolColumnReader(cells) => into.read(cells, |&cell| f64::from(u8::from(cell))),
        ColumnReader::Int32ColumnReader(cells) => {
            into.read(cells, |&cell| kind.integer(cell.into(), cell.cast_unsigned().into()))
        }
        ColumnReader::Int64ColumnReader(cells) => {
            into.read(cells, |&cell| kind.integer(cell, cell.cast_unsigned()))
        }
        ColumnReader::Int96ColumnReader(cells) => into.read(cells, |cell| kind.integer(cell.to_nanos(), 0)),
        ColumnReader::FloatColumnReader(cells) => into.read(cells, |&cell| f64::from(cell)),
        ColumnReader::DoubleColumnReader(cells) => into.read(cells, |&cell| cell),
        ColumnReader::ByteArrayColumnReader(cells) => {
            into.read(cells, |cell: &ByteArray| kind.bytes(cell.data()))
        }
        ColumnReader::FixedLenByteArrayColumnReader(cells) => {
            into.read(cells, |cell: &FixedLenByteArray| kind.bytes(cell.data()))
        }
    }
}

impl Kind {
    /// Value of an integer cell, passed both as signed and unsigned.
    fn integer(&mut self, cell: i64, unsigned_cell: u64) -> f64 {
        match self {
            Self::Numbers { unsigned: true, divisor } => unsigned_cell as f64 / *divisor,
            Self::Numbers { unsigned: false, divisor } => cell as f64 / *divisor,
            Self::Seconds { per_second, first } => {
                // in i128, since the span of two i64 may not fit in one
                let since = i128::from(cell) - i128::from(*first.get_or_insert(cell));
                since as f64 / *per_second
            }
            Self::Halves | Self::Labels(_) => f64::NAN,
        }
    }

    /// Value of a byte cell: a label, a 16-bit float, or a big-endian decimal.
    fn bytes(&mut self, cell: &[u8]) -> f64 {
        match self {
            Self::Labels(labels) => {
                let next = labels.len() as f64;
                // most cells repeat the one before them
                match labels.get(cell) {
                    Some(&label) => label,
                    None => *labels.entry(cell.to_vec()).or_insert(next),
                }
            }
            Self::Halves => cell.try_into().map_or(f64::NAN, |bytes| f16::from_le_bytes(bytes).to_f64()),
            Self::Numbers { divisor, .. } => {
                let sign = cell.first().map_or(0, |&byte| i128::from(byte.cast_signed() >> 7));
                let whole = cell.iter().fold(sign, |whole, &byte| (whole << 8) | i128::from(byte));
                whole as f64 / *divisor
            }
            Self::Seconds { .. } => f64::NAN,
        }
    }
}

/// Destination of the cells of a column.
struct Into<'a> {
    values: &'a mut Vec<f64>,
    rows: usize,
    optional: bool,
    empty: &'a mut u64,
}

impl Into<'_> {
    fn read<T: DataType>(
        self,
        mut cells: ColumnReaderImpl<T>,
        mut number: impl FnMut(&T::T) -> f64,
    ) -> Result<(), ParquetError> {
        let mut left = self.rows;
        // the metadata of the file may be wrong
        self.values.reserve(left.min(MAX_AHEAD));
        let (mut found, mut levels) = (Vec::new(), Vec::new());
        while left > 0 {
            crate::interrupt::check();
            found.clear();
            levels.clear();
            let (batch, levels_wanted) = (left.min(BATCH_CELLS), self.optional.then_some(&mut levels));
            let (read, ..) = library(|| cells.read_records(batch, levels_wanted, None, &mut found))?;
            if read == 0 {
                break;
            }
            left -= read;
            if self.optional {
                // a level for every cell, a value only for those that are not empty
                let mut found = found.iter();
                for &level in &levels {
                    let cell = if level > 0 { found.next() } else { None };
                    *self.empty += u64::from(cell.is_none());
                    self.values.push(cell.map_or(f64::NAN, &mut number));
                }
            } else {
                self.values.extend(found.iter().map(&mut number));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::sync::Arc;

    use parquet::data_type::{
        BoolType, ByteArrayType, DoubleType, FixedLenByteArrayType, FloatType, Int32Type, Int64Type,
    };
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
    use parquet::schema::parser::parse_message_type;

    use super::super::{Boundary, LoadOptions, load};
    use super::*;
    use crate::unit::Unit;

    /// Writes one row group with columns in the order of the schema.
    fn file(schema: &str, write: impl FnOnce(&mut SerializedRowGroupWriter<'_, File>)) -> tempfile::TempPath {
        let path = tempfile::Builder::new().suffix(".parquet").tempfile().unwrap();
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = Arc::new(WriterProperties::default());
        let mut writer = SerializedFileWriter::new(path.reopen().unwrap(), schema, properties).unwrap();
        let mut group = writer.next_row_group().unwrap();
        write(&mut group);
        group.close().unwrap();
        writer.close().unwrap();
        path.into_temp_path()
    }

    /// Writes the next column; `None` is an empty cell.
    fn put<T: DataType>(group: &mut SerializedRowGroupWriter<'_, File>, cells: &[Option<T::T>]) {
        let mut column = group.next_column().unwrap().unwrap();
        let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
        let values: Vec<T::T> = cells.iter().flatten().cloned().collect();
        column.typed::<T>().write_batch(&values, Some(&levels), None).unwrap();
        column.close().unwrap();
    }

    fn all<T: Clone>(cells: &[T]) -> Vec<Option<T>> {
        cells.iter().cloned().map(Some).collect()
    }

    #[test]
    fn instants_flags_integers_labels_and_nulls_are_understood() {
        // 2023-11-14 in ns, where f64 would round timestamps to 256 ns
        let instants: Vec<i64> = (0..6).map(|i| 1_700_000_000_000_000_001 + i * 5_000_000).collect();
        let schema = "message log {
            required int64 time (TIMESTAMP(NANOS, true));
            optional int32 gx (INTEGER(16, true));
            required float temp_c;
            required boolean still;
            required binary segment (STRING);
            required binary note (STRING);
        }";
        let path = file(schema, |group| {
            put::<Int64Type>(group, &all(&instants));
            put::<Int32Type>(group, &[Some(100), None, Some(-3), Some(4), Some(5), Some(6)]);
            put::<FloatType>(group, &all(&[0.1; 6]));
            put::<BoolType>(group, &all(&[true, true, true, false, false, true]));
            put::<ByteArrayType>(group, &all(&["a", "a", "b", "b", "b", "b"].map(ByteArray::from)));
            put::<ByteArrayType>(group, &all(&["x"; 6].map(ByteArray::from)));
        });
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

    #[test]
    fn any_flipped_bit_is_read_or_rejected() {
        let path = file("message log { required double t_s; optional int32 gx; }", |group| {
            put::<DoubleType>(group, &all(&[0.0, 0.005, 0.01]));
            put::<Int32Type>(group, &[Some(1), None, Some(3)]);
        });
        let bytes = std::fs::read(&path).unwrap();
        let mut damaged = 0;
        for bit in 0..8 * bytes.len() {
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&path, changed).unwrap();
            match read(&path, File::open(&path).unwrap(), &ColumnMap::default(), None) {
                Ok(table) => {
                    assert!(
                        table.columns.iter().all(|column| column.values.len() == table.n_rows()),
                        "{bit}"
                    );
                }
                Err(error) => damaged += usize::from(error.to_string().contains("the file is damaged (")),
            }
        }
        // otherwise the library no longer panics, and containment can go
        assert!(damaged > 0);
    }

    #[test]
    fn a_list_longer_than_the_file_ends_with_the_file() {
        let path = file("message log { required double t_s; }", |group| {
            put::<DoubleType>(group, &all(&[0.0, 0.005, 0.01]));
        });
        let mut bytes = std::fs::read(&path).unwrap();
        // in the first page header (Thrift, compact protocol): field 15, a list of 2³¹ − 1 numbers of 8 bytes
        bytes[4..11].copy_from_slice(&[0xf9, 0xf7, 0xff, 0xff, 0xff, 0xff, 0x07]);
        std::fs::write(&path, bytes).unwrap();
        let error = read(&path, File::open(&path).unwrap(), &ColumnMap::default(), None).unwrap_err();
        assert!(error.to_string().contains("end of file"), "{error}");
    }

    #[test]
    fn reads_numbers_of_every_kind_and_ignores_others() {
        let schema = "message log {
            required int64 old_stamp (TIMESTAMP_MICROS);
            required int32 small (UINT_32);
            required int64 large (INTEGER(64, false));
            required int32 cents (DECIMAL(9, 2));
            required fixed_len_byte_array(3) mills (DECIMAL(6, 3));
            required fixed_len_byte_array(2) half (FLOAT16);
            required int32 day (DATE);
            required group point { required double x; required double y; }
            repeated double list;
            required double last;
        }";
        let bytes = |bytes: &[u8]| FixedLenByteArray::from(bytes.to_vec());
        let path = file(schema, |group| {
            put::<Int64Type>(group, &all(&[5_000_000, 4_000_000]));
            put::<Int32Type>(group, &all(&[7, -1]));
            put::<Int64Type>(group, &all(&[7, -1]));
            put::<Int32Type>(group, &all(&[1234, -50]));
            put::<FixedLenByteArrayType>(group, &all(&[bytes(&[0, 1, 0]), bytes(&[0xff, 0xff, 0xfe])]));
            put::<FixedLenByteArrayType>(
                group,
                &all(&[f16::from_f64(-1.5), f16::MAX].map(|half| bytes(&half.to_le_bytes()))),
            );
            put::<Int32Type>(group, &all(&[1, 2]));
            put::<DoubleType>(group, &all(&[1.0, 2.0]));
            put::<DoubleType>(group, &all(&[1.0, 2.0]));
            let mut list = group.next_column().unwrap().unwrap();
            list.typed::<DoubleType>()
                .write_batch(&[1.0, 2.0, 3.0], Some(&[1; 3]), Some(&[0, 1, 0]))
                .unwrap();
            list.close().unwrap();
            put::<DoubleType>(group, &all(&[3.0, 4.0]));
        });
        let table = read(&path, File::open(&path).unwrap(), &ColumnMap::default(), None).unwrap();
        let found: Vec<_> =
            table.columns.iter().map(|column| (column.name.as_str(), column.values.as_slice())).collect();
        let expected: [(&str, &[f64]); 7] = [
            ("old_stamp", &[0.0, -1.0]),
            ("small", &[7.0, 4_294_967_295.0]),
            ("large", &[7.0, 18_446_744_073_709_551_615.0]),
            ("cents", &[12.34, -0.5]),
            ("mills", &[0.256, -0.002]),
            ("half", &[-1.5, 65_504.0]),
            ("last", &[3.0, 4.0]),
        ];
        assert_eq!(found, expected);
        assert_eq!(table.quality.text_columns, ["day", "point", "list"]);
        let first = read(&path, File::open(&path).unwrap(), &ColumnMap::default(), Some(1)).unwrap();
        assert_eq!(first.columns[1].values, [7.0]);
    }
}
