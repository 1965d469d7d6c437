//! Writes columns of numbers as Parquet.

use std::fs::File;
use std::io;
use std::sync::Arc;

use parquet::basic::{Compression as ParquetCompression, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// Rows encoded together.
const ROW_GROUP: usize = 1 << 20;

/// Writes every column as doubles, preserving all bits.
pub(super) fn write(file: &File, columns: &[(&str, &[f64])]) -> io::Result<()> {
    write_parquet(file, columns).map_err(|error| match error {
        // the error of the system is inside
        ParquetError::External(inner) => {
            inner.downcast::<io::Error>().map_or_else(io::Error::other, |inner| *inner)
        }
        other => io::Error::other(other),
    })
}

fn write_parquet(file: &File, columns: &[(&str, &[f64])]) -> Result<(), ParquetError> {
    let field = |name: &str| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE);
        field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = columns.iter().map(|(name, _)| field(name)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("log").with_fields(fields).build()?;
    let properties =
        WriterProperties::builder().set_compression(ParquetCompression::ZSTD(ZstdLevel::default())).build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let n_rows = columns.first().map_or(0, |(_, values)| values.len());
    for start in (0..n_rows).step_by(ROW_GROUP) {
        let rows = start..(start + ROW_GROUP).min(n_rows);
        let mut group = writer.next_row_group()?;
        for (_, values) in columns {
            let Some(mut column) = group.next_column()? else { break };
            column.typed::<DoubleType>().write_batch(&values[rows.clone()], None, None)?;
            column.close()?;
        }
        group.close()?;
    }
    writer.close().map(drop)
}
