//! Column map: the channel of each column of a log, and the conversion of its numbers to SI units.

use std::path::Path;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::file::{self, FileError};
use crate::unit::{Affine, Unit, known_units, parse_unit};

/// Maps columns of a log to channels.
///
/// One entry per channel, as on a command line:
///
/// ```text
/// target=column[:arithmetic][:unit]     this column is that channel
/// !column                               ignore this column
/// ```
///
/// `arithmetic` is the conversion printed in data sheets, applied from left to right (no precedence), each of `+ - * /`
/// with a number: `/340+36.53`, `-32768*0.061`. `unit` is the unit of the result; without it the numbers are in the unit
/// stated by the target's name (`gx_rads`: rad/s). A target may replace a column of its own name. A column with a `:` in
/// its name is quoted, `"acc:x"`; a quote within quotes is doubled.
///
/// ```
/// use fos_data::recording::ColumnMap;
/// let map = ColumnMap::from_specs([
///     "t_s=time:us",
///     "gx_rads=gyro_x:mdps",
///     "ax_mps2=acc_x:g",
///     "temp_c=T:/340+36.53:degC",
///     "gy_rads=gy_cnt:-32768*0.061:mdps",
///     "!debug",
/// ])?;
/// assert_eq!(map.column_of("gx_rads"), "gyro_x");
/// # Ok::<(), fos_data::recording::MapError>(())
/// ```
///
/// The same as a TOML file, where an entry may have a long form:
///
/// ```toml
/// ignore = ["debug"]
/// [columns]
/// gx_rads = "gyro_x:mdps"
/// ax_mps2 = { column = "acc:x", arithmetic = "-32768*0.061", unit = "mg" }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<String>", into = "Vec<String>")]
pub struct ColumnMap {
    mappings: Vec<Mapping>,
    ignored: Vec<String>,
}

/// One channel of a [`ColumnMap`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mapping {
    pub(super) target: String,
    pub(super) column: String,
    pub(super) unit: Unit,
    pub(super) conversion: Affine,
    /// Entry as written, `target=column…`.
    spec: String,
}

impl Mapping {
    /// The entry as it was written.
    pub(super) fn spec(&self) -> &str {
        &self.spec
    }
}

/// Reason why a column map is invalid.
#[derive(Debug, Error)]
pub enum MapError {
    #[error(
        "column map \"{spec}\": not an entry\nhelp: write target=column[:arithmetic][:unit], as in gx_rads=gyro_x:mdps, or !column to leave a column out"
    )]
    Form { spec: String },
    #[error(
        "column map \"{spec}\": unknown unit \"{unit}\"\nhelp: known are {}. For raw counts give the scale, as in gx_rads=gx:-32768*0.061:mdps",
        known_units()
    )]
    UnknownUnit { spec: String, unit: String },
    /// Arithmetic that is not a chain of `+ - * /` with finite numbers.
    #[error(
        "column map \"{spec}\": cannot read the arithmetic \"{arithmetic}\"\nhelp: write a chain of + - * / with numbers, applied from left to right, as in -32768*0.061"
    )]
    Arithmetic { spec: String, arithmetic: String },
    #[error(
        "column map \"{spec}\": {target} is in {}, and \"{unit}\" cannot be converted to it\nhelp: check the unit, or the channel that the column stands for",
        expected.symbol()
    )]
    WrongKind {
        spec: String,
        /// Channel in the log format, such as `gx_rads`.
        target: String,
        expected: Unit,
        unit: String,
    },
    #[error(
        "column map: {target} is given twice (columns \"{first}\" and \"{second}\")\nhelp: keep one of them"
    )]
    Twice {
        /// Channel in the log format, such as `gx_rads`.
        target: String,
        first: String,
        second: String,
    },
    /// Invalid TOML, or TOML not of the documented form.
    #[error("column map: {0}\nhelp: write a table [columns] of channel = \"column:unit\"")]
    Toml(#[from] toml::de::Error),
    #[error("column map {0}")]
    File(#[from] FileError),
    #[error("column map {path}: it is no text\nhelp: write a table [columns] of channel = \"column:unit\"")]
    NotText { path: String },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TomlMap {
    #[serde(default)]
    ignore: Vec<String>,
    #[serde(default)]
    columns: toml::Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TomlMapping {
    column: String,
    arithmetic: Option<String>,
    unit: Option<String>,
}

impl ColumnMap {
    /// Builds a map from entries as given on a command line.
    pub fn from_specs<S: AsRef<str>>(specs: impl IntoIterator<Item = S>) -> Result<ColumnMap, MapError> {
        let mut map = ColumnMap::default();
        for spec in specs {
            map.add(spec.as_ref())?;
        }
        Ok(map)
    }

    /// Builds a map from the text of a TOML file.
    pub fn from_toml(text: &str) -> Result<ColumnMap, MapError> {
        let file: TomlMap = toml::from_str(text)?;
        let mut map = ColumnMap::default();
        for column in file.ignore {
            map.ignore(&column)?;
        }
        for (target, value) in file.columns {
            match value {
                toml::Value::String(source) => map.add_source(&target, &source)?,
                table => {
                    let long: TomlMapping = table.try_into()?;
                    map.add_mapping(&target, &long.column, long.arithmetic.as_deref(), long.unit.as_deref())?;
                }
            }
        }
        Ok(map)
    }

    /// Builds a map from a TOML file.
    pub fn from_file(path: &Path) -> Result<ColumnMap, MapError> {
        let text = String::from_utf8(file::read(path)?)
            .map_err(|_| MapError::NotText { path: path.display().to_string() })?;
        ColumnMap::from_toml(&text)
    }

    /// Adds one entry, as given on a command line.
    pub fn add(&mut self, spec: &str) -> Result<(), MapError> {
        let form = || MapError::Form { spec: spec.to_owned() };
        if let Some(column) = spec.strip_prefix('!') {
            return self.ignore(column);
        }
        let (target, source) = spec.split_once('=').ok_or_else(form)?;
        self.add_source(target, source)
    }

    fn ignore(&mut self, column: &str) -> Result<(), MapError> {
        if column.is_empty() {
            return Err(MapError::Form { spec: "!".to_owned() });
        }
        self.ignored.push(column.to_owned());
        Ok(())
    }

    /// Adds `target` from the text after the `=` of an entry.
    fn add_source(&mut self, target: &str, source: &str) -> Result<(), MapError> {
        let form = || MapError::Form { spec: format!("{target}={source}") };
        let (column, rest) = split_column(source).ok_or_else(form)?;
        let mut parts = rest.split(':').skip(1).peekable();
        let arithmetic = parts.next_if(|part| part.trim_start().starts_with(['+', '-', '*', '/']));
        let unit = parts.next();
        if parts.next().is_some() {
            return Err(form());
        }
        self.add_mapping(target, &column, arithmetic, unit)
    }

    fn add_mapping(
        &mut self,
        target: &str,
        column: &str,
        arithmetic: Option<&str>,
        unit: Option<&str>,
    ) -> Result<(), MapError> {
        // normalised, so that the entry reads back as itself
        let (target, arithmetic, unit) = (target.trim(), arithmetic.map(str::trim), unit.map(str::trim));
        let mut spec = format!("{target}={}", quoted(column));
        for part in [arithmetic, unit].into_iter().flatten() {
            spec.push(':');
            spec.push_str(part);
        }
        if target.is_empty() || target.starts_with('!') || target.contains('=') || column.is_empty() {
            return Err(MapError::Form { spec });
        }
        if let Some(first) = self.mappings.iter().find(|mapping| mapping.target == target) {
            return Err(MapError::Twice {
                target: target.to_owned(),
                first: first.column.clone(),
                second: column.to_owned(),
            });
        }
        let mut conversion = match arithmetic {
            None => Affine::IDENTITY,
            Some(chain) => parse_arithmetic(chain)
                .ok_or_else(|| MapError::Arithmetic { spec: spec.clone(), arithmetic: chain.to_owned() })?,
        };
        let expected = Unit::of_column(target);
        let mut stored = expected;
        if let Some(unit) = unit {
            let (kind, to_si) = parse_unit(unit)
                .ok_or_else(|| MapError::UnknownUnit { spec: spec.clone(), unit: unit.to_owned() })?;
            if expected != Unit::Unstated && kind != expected {
                let unit = unit.to_owned();
                return Err(MapError::WrongKind { spec, target: target.to_owned(), expected, unit });
            }
            conversion = conversion.then(to_si);
            stored = kind;
        }
        self.mappings.push(Mapping {
            target: target.to_owned(),
            column: column.to_owned(),
            unit: stored,
            conversion,
            spec,
        });
        Ok(())
    }

    /// Column of the log that holds `target`: the mapped one, else the one of that name.
    pub fn column_of<'a>(&'a self, target: &'a str) -> &'a str {
        self.mappings.iter().find(|mapping| mapping.target == target).map_or(target, |found| &found.column)
    }

    /// Returns true if `column` is ignored.
    pub fn ignores(&self, column: &str) -> bool {
        self.ignored.iter().any(|name| name == column)
    }

    /// Entries, as given on a command line.
    pub fn specs(&self) -> Vec<String> {
        let ignored = self.ignored.iter().map(|column| format!("!{column}"));
        self.mappings.iter().map(|mapping| mapping.spec.clone()).chain(ignored).collect()
    }

    /// Returns true if the map has no entry.
    pub fn is_empty(&self) -> bool {
        self.mappings.is_empty() && self.ignored.is_empty()
    }

    pub(super) fn mappings(&self) -> &[Mapping] {
        &self.mappings
    }

    /// Returns true if `column` is the source of a channel.
    pub(super) fn uses(&self, column: &str) -> bool {
        self.mappings.iter().any(|mapping| mapping.column == column)
    }

    pub(super) fn ignored(&self) -> &[String] {
        &self.ignored
    }
}

impl TryFrom<Vec<String>> for ColumnMap {
    type Error = MapError;
    fn try_from(specs: Vec<String>) -> Result<ColumnMap, MapError> {
        ColumnMap::from_specs(specs)
    }
}

impl From<ColumnMap> for Vec<String> {
    fn from(map: ColumnMap) -> Vec<String> {
        map.specs()
    }
}

/// Column at the begin of `"acc:x":mg`, and the remaining text; `None` if a quote is not closed.
fn split_column(text: &str) -> Option<(String, &str)> {
    let Some(mut quoted) = text.trim_start().strip_prefix('"') else {
        let end = text.find(':').unwrap_or(text.len());
        return Some((text[..end].trim().to_owned(), &text[end..]));
    };
    let mut column = String::new();
    loop {
        let (part, rest) = quoted.split_once('"')?;
        column.push_str(part);
        match rest.strip_prefix('"') {
            Some(rest) => {
                column.push('"');
                quoted = rest;
            }
            None if rest.trim_start().is_empty() || rest.trim_start().starts_with(':') => {
                return Some((column, rest.trim_start()));
            }
            None => return None,
        }
    }
}

/// Quotes a column name for an entry, if needed.
pub(super) fn quoted(column: &str) -> String {
    if column.contains(':') || column.starts_with('"') || column.trim() != column {
        format!("\"{}\"", column.replace('"', "\"\""))
    } else {
        column.to_owned()
    }
}

/// Parses `-32768*0.061` to a straight line; `None` if it is not a chain of operators with finite numbers.
pub(super) fn parse_arithmetic(chain: &str) -> Option<Affine> {
    let bytes = Some(chain.as_bytes()).filter(|bytes| !bytes.is_empty())?;
    let mut line = Affine::IDENTITY;
    let mut at = 0;
    while at < bytes.len() {
        // a sign right after an operator or an exponent belongs to the number
        let end = (at + 2..bytes.len())
            .find(|&i| b"+-*/".contains(&bytes[i]) && !b"eE".contains(&bytes[i - 1]))
            .unwrap_or(bytes.len());
        let number: f64 = chain.get(at + 1..end)?.trim().parse().ok()?;
        let step = match bytes[at] {
            b'+' => Affine { scale: 1.0, offset: number },
            b'-' => Affine { scale: 1.0, offset: -number },
            b'*' => Affine { scale: number, offset: 0.0 },
            b'/' => Affine { scale: 1.0 / number, offset: 0.0 },
            _ => return None,
        };
        line = line.then(step);
        at = end;
    }
    (line.scale.is_finite() && line.offset.is_finite() && line.scale != 0.0).then_some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(spec: &str, cell: f64) -> f64 {
        let map = ColumnMap::from_specs([spec]).expect(spec);
        let mut values = [cell];
        map.mappings()[0].conversion.apply(&mut values);
        values[0]
    }

    #[test]
    fn arithmetic_runs_from_left_to_right() {
        // MPU-6050 register map: temperature in degC = raw / 340 + 36.53
        assert!((value("temp_c=raw:/340+36.53:degC", -3920.0) - 25.000588235294118).abs() < 1e-12);
        assert_eq!(value("x=raw:-32768*0.5", 32770.0), 1.0);
        assert_eq!(value("x=raw:*-2e-1+1", 10.0), -1.0);
        assert_eq!(value("x=raw", 0.1), 0.1);
    }

    #[test]
    fn counts_with_a_scale_and_an_offset_become_si() {
        let rate = value("gx_rads=gx:-32768*0.061:mdps", 32768.0 + 1000.0);
        assert!((rate - 61.0e-3_f64.to_radians()).abs() < 1e-15);
    }

    #[test]
    fn rejects_a_unit_of_the_wrong_kind() {
        let error = ColumnMap::from_specs(["gx_rads=gyro:g"]).unwrap_err();
        assert!(matches!(error, MapError::WrongKind { .. }), "{error}");
        assert!(error.to_string().contains("gx_rads is in rad/s"), "{error}");
    }

    #[test]
    fn invalid_map_entries_state_the_remedy() {
        for (spec, hint) in [
            ("gx_rads", "target=column"),
            ("=x", "target=column"),
            ("gx_rads=", "target=column"),
            ("!", "target=column"),
            ("gx_rads=a:b:c:d", "target=column"),
            ("gx_rads=\"a:b", "target=column"),
            ("gx_rads=\"a\"b:dps", "target=column"),
            ("gx_rads=gyro:rpm", "mdps"),
            ("gx_rads=gyro:*", "arithmetic"),
            ("gx_rads=gyro:*x:dps", "arithmetic"),
            ("gx_rads=gyro:/0:dps", "arithmetic"),
            ("gx_rads=gyro:*0:dps", "arithmetic"),
            ("gx_rads=gyro:+inf:dps", "arithmetic"),
        ] {
            let message = ColumnMap::from_specs([spec]).unwrap_err().to_string();
            assert!(message.contains(hint), "{spec}: {message}");
        }
    }

    #[test]
    fn maps_columns_of_any_name() {
        for column in ["plain", "acc:x", "\"", "a\"b", "\"a\":\"b\"", " padded ", "::"] {
            let mut map = ColumnMap::default();
            map.add_mapping("x", column, None, None).unwrap();
            let again = ColumnMap::from_specs(map.specs()).unwrap();
            assert_eq!((again.column_of("x"), &again), (column, &map));
        }
        for toml in [
            "ignore = [\" a\", \"!\"]",
            "[columns]\n\" x \" = { column = \"a\", arithmetic = \" *2 \", unit = \" mg \" }",
        ] {
            let map = ColumnMap::from_toml(toml).unwrap();
            assert_eq!(ColumnMap::from_specs(map.specs()).unwrap(), map, "{toml}");
        }
        for toml in ["ignore = [\"\"]", "[columns]\n\"!x\" = \"a\"", "[columns]\n\"x=y\" = \"a\""] {
            assert!(matches!(ColumnMap::from_toml(toml), Err(MapError::Form { .. })), "{toml}");
        }
    }

    #[test]
    fn one_channel_from_two_columns_is_refused() {
        let error = ColumnMap::from_specs(["gx_rads=a", "gx_rads=b"]).unwrap_err();
        assert!(matches!(error, MapError::Twice { .. }));
    }

    #[test]
    fn toml_map_equals_the_command_line() {
        let toml = r#"
            ignore = ["debug"]
            [columns]
            ax_mps2 = { column = "acc:x", arithmetic = "-32768*0.061", unit = "mg" }
            gx_rads = "gyro_x:mdps"
        "#;
        let specs = ["ax_mps2=\"acc:x\":-32768*0.061:mg", "gx_rads=gyro_x:mdps", "!debug"];
        let map = ColumnMap::from_toml(toml).unwrap();
        assert_eq!(map.specs(), specs);
        assert_eq!(map, ColumnMap::from_specs(specs).unwrap());
        assert!(ColumnMap::from_toml("[colums]\na = \"b\"").is_err());
    }
}
