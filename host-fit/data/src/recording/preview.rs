//! Preview of a file: its columns and their probable channels, before it is read as a log.

use crate::column::{AXES, Column, MAGNETOMETERS};
use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::column_map::{ColumnMap, Mapping, quoted};
use super::error::RecordingError;
use super::guess::{Guess, Guesses, guesses};
use super::load;
use super::table::Table;
use crate::statistics::median_of;
use crate::unit::{Affine, STANDARD_GRAVITY_MPS2, Unit, parse_unit, spellings_of};

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
    /// Scale and offset in front of the unit, as in `-32768*0.061`.
    pub arithmetic: Option<String>,
    /// Column map entry for them; `None` if the name is sufficient.
    pub spec: Option<String>,
    /// Reason for the guess.
    pub why: String,
    /// True if the name alone determines it.
    pub sure: bool,
    /// Reason why its values cannot be in this unit.
    pub caution: Option<String>,
}

/// Reads the begin of a file. Columns named in `map` are shown as it reads them, the others as guessed if it is empty.
pub fn preview(path: &Path, map: &ColumnMap) -> Result<Preview, RecordingError> {
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
                arithmetic: None,
                spec: None,
                why: match mapping {
                    Some(_) => format!("by the format, {format}"),
                    None => format!("no channel of the format, {format}: kept under its own name"),
                },
                sure: true,
                caution: None,
            };
        }
        match guess {
            None => ColumnPreview {
                why: match is_undecided(&quoted) {
                    true => {
                        "another column is as good for the same channel and differs: choose one".to_owned()
                    }
                    false => "unknown channel; keeps its name".to_owned(),
                },
                sure: !is_undecided(&quoted),
                name,
                quoted,
                values,
                target: None,
                unit: None,
                arithmetic: None,
                spec: None,
                caution: None,
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
                    arithmetic: None,
                    spec,
                    why,
                    sure,
                    caution: None,
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
        arithmetic: None,
        spec: None,
        why: "holds text: excluded".to_owned(),
        sure: true,
        caution: None,
    });
    let mut columns: Vec<ColumnPreview> = columns.chain(text).collect();
    let is_by_format = !meaning.map.is_empty();
    if !map.is_empty() {
        columns.iter_mut().for_each(|column| apply(map, is_by_format, column));
    }
    // the format converts its own columns: their values in the table are not in the unit that is shown
    if !is_by_format {
        add_cautions(&table, &mut columns);
    }
    let references = AXES.iter().map(|axis| Column::named(axis).reference());
    let targets =
        ["t_s"].iter().chain(&AXES).chain(&OTHERS).chain(&MAGNETOMETERS).map(|name| (*name).to_owned());
    let targets: Vec<String> =
        targets.chain(references).chain(["still".to_owned(), "segment".to_owned()]).collect();
    let units = targets.iter().map(|target| (target.clone(), spellings_of(Unit::of_column(target))));
    Ok(Preview { columns, units: units.collect(), targets })
}

/// Shows a column as `map` reads it.
fn apply(map: &ColumnMap, is_by_format: bool, column: &mut ColumnPreview) {
    if let Some(mapping) = map.mappings().iter().find(|mapping| mapping.column == column.name) {
        let (arithmetic, unit) = parts(mapping, &column.quoted);
        column.unit = Some(unit.unwrap_or(Unit::of_column(&mapping.target).symbol().to_owned()));
        column.arithmetic = arithmetic;
        column.target = Some(mapping.target.clone());
        column.spec = Some(mapping.spec().to_owned());
        (column.why, column.sure) = ("as chosen".to_owned(), true);
    } else if map.ignores(&column.name) {
        (column.target, column.unit) = (None, None);
        column.spec = Some(format!("!{}", column.name));
        (column.why, column.sure) = ("as chosen".to_owned(), true);
    } else {
        let is_replaced = |target: &String| map.mappings().iter().any(|mapping| mapping.target == *target);
        let is_read = is_by_format || column.spec.is_none();
        if !is_read || column.target.as_ref().is_some_and(is_replaced) {
            (column.target, column.unit, column.spec) = (None, None, None);
            (column.why, column.sure) = ("kept under its own name".to_owned(), true);
        }
    }
}

/// Arithmetic and unit of an entry, as they were written.
fn parts(mapping: &Mapping, quoted: &str) -> (Option<String>, Option<String>) {
    let source = mapping.spec().strip_prefix(&format!("{}={quoted}", mapping.target)).unwrap_or_default();
    let mut parts = source.split(':').skip(1).peekable();
    let arithmetic = parts.next_if(|part| part.starts_with(['+', '-', '*', '/']));
    (arithmetic.map(str::to_owned), parts.next().map(str::to_owned))
}

/// Gravity that an accelerometer shows lies within this factor of the standard, unless it moves or counts are read as m/s².
const GRAVITY_WITHIN: f64 = 2.0;

/// Largest rate at the begin of a log, rad/s: 2000 °/s, the widest range of most gyros.
const FASTEST: f64 = 34.9;

/// Adds a caution to columns whose values cannot be in the unit that they are read in, most often raw counts.
fn add_cautions(table: &Table, columns: &mut [ColumnPreview]) {
    let values_of = |column: &ColumnPreview| -> Option<Vec<f64>> {
        let raw = table.columns.iter().find(|raw| raw.name == column.name)?;
        let unit = column.unit.as_deref().and_then(parse_unit).map_or(Affine::IDENTITY, |(_, to_si)| to_si);
        let conversion = match &column.arithmetic {
            Some(chain) => super::column_map::parse_arithmetic(chain)?.then(unit),
            None => unit,
        };
        let mut values = raw.values.clone();
        conversion.apply(&mut values);
        Some(values)
    };
    let kind = |column: &ColumnPreview| -> Option<Unit> {
        let target = column.target.as_deref().filter(|target| AXES.contains(target))?;
        Some(Unit::of_column(target))
    };
    let of_accelerometer: Vec<Vec<f64>> = columns
        .iter()
        .filter(|column| kind(column) == Some(Unit::MetrePerSecondSquared))
        .filter_map(values_of)
        .collect();
    let rows = of_accelerometer.iter().map(Vec::len).min().unwrap_or(0);
    let magnitudes =
        (0..rows).map(|row| of_accelerometer.iter().map(|axis| axis[row] * axis[row]).sum::<f64>().sqrt());
    let magnitude =
        median_of(magnitudes.filter(|magnitude| magnitude.is_finite())).unwrap_or(STANDARD_GRAVITY_MPS2);
    let is_too_weak = of_accelerometer.len() == 3 && magnitude * GRAVITY_WITHIN < STANDARD_GRAVITY_MPS2;
    let is_gravity = !is_too_weak && magnitude <= GRAVITY_WITHIN * STANDARD_GRAVITY_MPS2;
    for column in columns {
        let Some(unit) = kind(column) else { continue };
        let Some(values) = values_of(column) else { continue };
        let typical = median_of(values.iter().map(|value| value.abs()).filter(|value| value.is_finite()));
        let is_whole = column.arithmetic.is_none()
            && column.unit.as_deref().is_none_or(|name| name == unit.symbol())
            && values.iter().all(|value| value.is_nan() || value.fract() == 0.0)
            && values.iter().any(|value| value.is_finite() && *value != values[0]);
        let wrong = match unit {
            Unit::MetrePerSecondSquared if !is_gravity => {
                format!("the accelerometers show {} m/s², and gravity is 9.81 m/s²", three(magnitude))
            }
            Unit::RadianPerSecond if typical.is_some_and(|typical| typical > FASTEST) => {
                format!("{} rad/s is faster than a gyro measures", three(typical.unwrap_or_default()))
            }
            _ if is_whole => "all values are whole numbers".to_owned(),
            _ => continue,
        };
        column.caution = Some(format!("{wrong}: choose the unit; for raw counts enter scale and offset"));
    }
}

/// A number in three significant digits, without an exponent.
fn three(value: f64) -> String {
    let digits = 2 - value.abs().max(1e-9).log10().floor() as i32;
    match usize::try_from(digits) {
        Ok(digits) => format!("{value:.digits$}"),
        Err(_) => format!("{value:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Raw counts of a 16-bit sensor with its zero at 32768, at rest.
    fn counts() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("counts.csv");
        let rows: String = (0..200)
            .map(|row| {
                format!(
                    "{},{},{},{},{}\n",
                    0.005 * f64::from(row),
                    32_786 + row % 3,
                    32_768,
                    34_816 - row % 2,
                    32_771 + row % 5
                )
            })
            .collect();
        std::fs::write(&path, format!("t_s,ax_mps2,ay_mps2,az_mps2,gx_rads\n{rows}")).unwrap();
        (folder, path)
    }

    fn column<'a>(preview: &'a Preview, name: &str) -> &'a ColumnPreview {
        preview.columns.iter().find(|column| column.name == name).unwrap()
    }

    #[test]
    fn cautions_against_raw_counts_read_as_si() {
        let (_folder, path) = counts();
        let found = preview(&path, &ColumnMap::default()).unwrap();
        let caution = |name| column(&found, name).caution.clone().unwrap_or_default();
        assert!(
            caution("ax_mps2").starts_with("the accelerometers show 57973 m/s²"),
            "{}",
            caution("ax_mps2")
        );
        assert!(caution("gx_rads").starts_with("32773 rad/s is faster"), "{}", caution("gx_rads"));
        assert_eq!(caution("t_s"), "");
    }

    #[test]
    fn shows_columns_as_a_map_reads_them() {
        let (_folder, path) = counts();
        let specs = [
            "ax_mps2=ax_mps2:-32768/2048:g",
            "ay_mps2=ay_mps2:-32768/2048:g",
            "az_mps2=az_mps2:-32768/2048:g",
            "!gx_rads",
        ];
        let found = preview(&path, &ColumnMap::from_specs(specs).unwrap()).unwrap();
        for (axis, spec) in ["ax_mps2", "ay_mps2", "az_mps2"].into_iter().zip(specs) {
            let shown = column(&found, axis);
            assert_eq!(shown.caution, None, "1 g");
            assert_eq!((shown.target.as_deref(), shown.unit.as_deref()), (Some(axis), Some("g")));
            assert_eq!(
                (shown.arithmetic.as_deref(), shown.spec.as_deref()),
                (Some("-32768/2048"), Some(spec))
            );
        }
        assert_eq!(column(&found, "gx_rads").spec.as_deref(), Some("!gx_rads"));
        assert_eq!(column(&found, "t_s").target.as_deref(), Some("t_s"), "not named by the map");
    }

    #[test]
    fn whole_numbers_of_rad_s_get_a_caution_and_of_mdps_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let rows: String = (0..200).map(|row| format!("{},{}\n", 0.005 * f64::from(row), row % 7)).collect();
        std::fs::write(&path, format!("t_s,gx_rads\n{rows}")).unwrap();
        let shown = |specs: &[&str]| {
            let found = preview(&path, &ColumnMap::from_specs(specs).unwrap()).unwrap();
            column(&found, "gx_rads").caution.clone()
        };
        assert!(shown(&[]).unwrap().starts_with("all values are whole numbers"));
        assert_eq!(shown(&["gx_rads=gx_rads:mdps"]), None);
    }
}
