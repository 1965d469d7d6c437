//! Preview of a file: its columns and their probable channels, before it is read as a log.

use crate::column::{AXES, Column, MAGNETOMETERS};
use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::column_map::quoted;
use super::error::RecordingError;
use super::guess::{Guess, Guesses, guesses};
use super::load;
use crate::unit::{Unit, spellings_of};

/// Number of values shown per column.
const SHOWN: usize = 4;

/// Channels used by effects, other than the inertial ones and the magnetometers.
const OTHERS: [&str; 3] = ["temp_c", "supply_v", "load_pct"];

/// Columns of a file with their probable channels.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Preview {
    /// Columns in the order of the file.
    pub columns: Vec<ColumnPreview>,
    /// Channels that a column can be mapped to.
    pub targets: Vec<String>,
    /// Possible units of each channel, the SI unit first.
    pub units: BTreeMap<String, Vec<&'static str>>,
}

/// A column of a file with its probable channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ColumnPreview {
    pub name: String,
    /// Name as written in an entry of a column map.
    pub quoted: String,
    pub values: Vec<String>,
    /// Probable channel.
    pub target: Option<String>,
    /// Probable unit.
    pub unit: Option<String>,
    /// Column map entry for them; `None` if the name is sufficient.
    pub spec: Option<String>,
    /// Reason for the guess.
    pub why: String,
    /// True if the name alone determines it.
    pub sure: bool,
}

/// Reads the begin of a file.
///
/// # Errors
///
/// The file cannot be read or is no log.
pub fn preview(path: &Path) -> Result<Preview, RecordingError> {
    let (table, meaning) = load::begin(path)?;
    let columns: Vec<(&str, &[f64])> =
        table.columns.iter().map(|column| (column.name.as_str(), column.values.as_slice())).collect();
    let Guesses { columns: guessed, undecided } = guesses(&columns);
    let is_undecided = |quoted: &str| {
        let mut entries = undecided.iter().flat_map(|group| group.choices.iter().flatten());
        entries.any(|entry| {
            let source = entry.split_once('=').map_or("", |(_, source)| source);
            source.strip_prefix(quoted).is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
        })
    };
    let columns = columns.iter().zip(guessed).map(|((name, values), guess)| {
        let values = values.iter().take(SHOWN).map(|value| match value.is_nan() {
            true => "–".to_owned(),
            false => value.to_string(),
        });
        let (quoted, name, values) = (quoted(name), (*name).to_owned(), values.collect());
        if let Some(format) = meaning.read_as.as_ref().map(|read_as| read_as.format)
            && !meaning.map.is_empty()
        {
            // the mapping used by default
            let mapping = meaning.map.mappings().iter().find(|mapping| mapping.column == name);
            return ColumnPreview {
                name,
                quoted,
                values,
                target: mapping.map(|mapping| mapping.target.clone()),
                unit: mapping.map(|mapping| mapping.unit.symbol().to_owned()),
                spec: None,
                why: match mapping {
                    Some(_) => format!("by the format, {format}"),
                    None => format!("no channel of the format, {format}: kept under its own name"),
                },
                sure: true,
            };
        }
        match guess {
            None => ColumnPreview {
                why: match is_undecided(&quoted) {
                    true => {
                        "another column is as good for the same channel and differs: choose one".to_owned()
                    }
                    false => "not a channel that is known: kept under its own name".to_owned(),
                },
                sure: !is_undecided(&quoted),
                name,
                quoted,
                values,
                target: None,
                unit: None,
                spec: None,
            },
            Some(Guess { target, unit, why, sure, .. }) => {
                let own = target == name && unit.is_none_or(|unit| unit == Unit::of_column(&target).symbol());
                let unit_part = unit.map_or_else(String::new, |unit| format!(":{unit}"));
                let spec = (!own).then(|| format!("{target}={quoted}{unit_part}"));
                ColumnPreview {
                    unit: Some(unit.unwrap_or(Unit::of_column(&target).symbol()).to_owned()),
                    target: Some(target),
                    name,
                    quoted,
                    values,
                    spec,
                    why,
                    sure,
                }
            }
        }
    });
    let text = table.quality.text_columns.iter().map(|name| ColumnPreview {
        name: name.clone(),
        quoted: quoted(name),
        values: Vec::new(),
        target: None,
        unit: None,
        spec: None,
        why: "holds text: excluded".to_owned(),
        sure: true,
    });
    let columns: Vec<ColumnPreview> = columns.chain(text).collect();
    let references = AXES.iter().map(|axis| Column::named(axis).reference());
    let targets =
        ["t_s"].iter().chain(&AXES).chain(&OTHERS).chain(&MAGNETOMETERS).map(|name| (*name).to_owned());
    let targets: Vec<String> =
        targets.chain(references).chain(["still".to_owned(), "segment".to_owned()]).collect();
    let units = targets.iter().map(|target| (target.clone(), spellings_of(Unit::of_column(target))));
    Ok(Preview { columns, units: units.collect(), targets })
}
