//! Meaning of the columns of a table: the channel of each, and the reason for the assignment.

use super::super::column_map::{ColumnMap, quoted};
use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::stream::{Stream, stamps};
use super::super::table::Table;
use super::{ReadAs, xsens};
use crate::unit::{Affine, parse_unit};

/// Channels of the columns, and the reason for the assignment.
#[derive(Debug, Default)]
pub(in super::super) struct Meaning {
    /// The user's map, extended by recognised columns.
    pub(in super::super) map: ColumnMap,
    /// Format and assumptions; `None` for the log format.
    pub(in super::super) read_as: Option<ReadAs>,
    /// Column and unit of separate timestamps of the gyros.
    pub(in super::super) gyro_clock: Option<(String, &'static str)>,
    /// Column of a clock that wraps, and its modulus.
    pub(in super::super) counter: Option<(String, f64)>,
    /// Column map entries that may be right, but are not certain.
    pub(in super::super) perhaps: Vec<String>,
    /// The same, but applied: the file has no header, and the values are clear.
    pub(in super::super) assumed_map: Vec<String>,
    /// Error unless the user decides: equally good candidates for a channel that differ.
    pub(in super::super) undecided: Option<RecordingError>,
}

/// The user's map, with recognised entries added for other channels.
pub(super) fn filled<T: AsRef<str>>(
    map: &ColumnMap,
    table: &Table,
    entries: Vec<(T, String, String)>,
) -> ColumnMap {
    let mut filled = map.clone();
    for (target, column, how) in entries {
        let target = target.as_ref();
        let is_told = map.column_of(target) != target || map.ignores(&column);
        if !is_told && table.index_of(&column).is_some() {
            // a test parses all of these entries
            let added = filled.add(&format!("{target}={}:{how}", quoted(&column)));
            debug_assert!(added.is_ok(), "{added:?}");
        }
    }
    filled
}

impl Meaning {
    /// The user's map, and nothing else.
    pub(in super::super) fn of_user(options: &LoadOptions) -> Self {
        Self { map: options.columns.clone(), ..Self::default() }
    }

    /// Unwraps the clock of the table.
    pub(in super::super) fn unwrap_clock(&self, table: &mut Table) {
        if let Some((column, modulus)) = &self.counter
            && let Some(at) = table.index_of(column)
        {
            xsens::unwrap(&mut table.columns[at].values, *modulus);
        }
    }

    /// Streams of the sensors, each with its own timestamps, if the gyros have a separate clock; `None` otherwise.
    pub(in super::super) fn streams(&self, table: &Table) -> Option<Vec<Stream>> {
        let (gyro_clock, gyro_unit) = self.gyro_clock.as_ref()?;
        let gyro_clock = table.index_of(gyro_clock)?;
        let clock = table.index_of(self.map.column_of("t_s"))?;
        let mapped = self.map.mappings().iter().find(|mapping| mapping.target == "t_s");
        let to_s = mapped.map_or(Affine::IDENTITY, |mapping| mapping.conversion);
        let gyro_to_s = parse_unit(gyro_unit).map_or(Affine::IDENTITY, |(_, conversion)| conversion);
        let of = |clock: usize, to_s: Affine, is_gyro: bool| {
            let mut seconds = table.columns[clock].values.clone();
            to_s.apply(&mut seconds);
            let stamps_ns = stamps(&seconds);
            let mut kept: Vec<bool> = stamps_ns.iter().map(Option::is_some).collect();
            // skip a row that repeats the sample before it
            for row in 1..stamps_ns.len() {
                kept[row] &= stamps_ns[row] != stamps_ns[row - 1];
            }
            let keep = |values: &[f64]| -> Vec<f64> {
                values.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(value, _)| *value).collect()
            };
            let columns = self
                .map
                .mappings()
                .iter()
                .filter(|mapping| mapping.target != "t_s" && mapping.target.starts_with('g') == is_gyro);
            let columns = columns.filter_map(|mapping| {
                let mut values = keep(&table.columns[table.index_of(&mapping.column)?].values);
                mapping.conversion.apply(&mut values);
                Some((mapping.target.clone(), values))
            });
            let columns: Vec<(String, Vec<f64>)> = columns.collect();
            let stamps_ns = stamps_ns.iter().zip(&kept).filter(|(_, kept)| **kept);
            Stream {
                name: if is_gyro { "gyroscope" } else { "accelerometer" }.to_owned(),
                stamps_ns: stamps_ns.filter_map(|(stamp, _)| *stamp).collect(),
                columns,
            }
        };
        Some(
            [of(clock, to_s, false), of(gyro_clock, gyro_to_s, true)]
                .into_iter()
                .filter(|stream| !stream.columns.is_empty())
                .collect(),
        )
    }
}
