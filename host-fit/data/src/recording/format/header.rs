//! Units stated in the headers of columns, in the spellings of programs and people.

use std::path::Path;

use super::super::column_map::quoted;
use super::super::error::RecordingError;
use super::super::guess::{force_unit, gravity};
use super::super::load_options::LoadOptions;
use super::super::table::Table;
use super::found::Entry;
use crate::column::ACCELEROMETERS;
use crate::unit::{Affine, Unit, parse_unit, spellings_of};

/// Splits a header into name and unit: `gyro_x [mdps]` is `gyro_x` in `mdps`, `time in ms` is `time` in `ms`. An index,
/// as in `gyroADC[0]`, is no unit.
pub(super) fn split(column: &str) -> (&str, Option<&str>) {
    let column = column.trim();
    let bracketed = [('(', ')'), ('[', ']')].into_iter().find_map(|(open, close)| {
        let (name, unit) = column.strip_suffix(close)?.rsplit_once(open)?;
        let is_unit = !unit.trim().chars().all(|letter| letter.is_ascii_digit());
        is_unit.then(|| (name.trim_end(), unit.trim()))
    });
    let after_in = || column.rsplit_once(" in ").map(|(name, unit)| (name.trim_end(), unit.trim()));
    match bracketed.or_else(after_in) {
        Some((name, unit)) => (name, Some(unit)),
        None => (column, None),
    }
}

/// Column map spelling of a unit stated in a header; `None` if it is no unit of `target`.
pub(super) fn spelling(stated: &str, target: &str) -> Option<&'static str> {
    // UTF-8 text once decoded as Latin-1 has an extra letter before ° and ²
    let plain = stated.trim().to_lowercase().replace(['â', '·', '*'], "").replace('\u{3bc}', "µ");
    let plain = plain.replace("⁻", "-").replace('¹', "1");
    // `rad s^-1` is `rad/s`, `m s^-2` is `m/s^2`
    let mut words = plain.split_whitespace();
    let plain = match (words.next(), words.next(), words.next()) {
        (Some(above), Some("s^-1" | "s-1"), None) => format!("{above}/s"),
        (Some(above), Some("s^-2" | "s-2" | "s-²"), None) => format!("{above}/s2"),
        (Some(above), Some("h^-1" | "h-1"), None) => format!("{above}/h"),
        _ => plain.split_whitespace().collect(),
    };
    let is_field = target.starts_with("mag");
    let known = match plain.as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" => "s",
        "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => "ms",
        "us" | "µs" | "usec" | "micros" | "microsecond" | "microseconds" => "us",
        "ns" | "nsec" | "nanos" | "nanosecond" | "nanoseconds" => "ns",
        // the last: ² in a text whose encoding was lost
        "m/s2" | "m/s^2" | "m/s²" | "m/s/s" | "mps2" | "m/s\u{fffd}" => "m/s2",
        "g" | "gauss" if is_field => "gauss",
        "mg" | "mgauss" if is_field => "mgauss",
        "g" => "g",
        "mg" => "mg",
        "rad/s" | "rad/sec" | "rads" | "radps" | "radians/s" => "rad/s",
        "mrad/s" => "mrad/s",
        "deg/s" | "deg/sec" | "degrees/s" | "degps" | "dps" | "°/s" | "\u{fffd}/s" => "dps",
        "mdeg/s" | "mdps" => "mdps",
        "deg/h" | "deg/hr" | "dph" | "°/h" => "deg/h",
        "degc" | "°c" | "c" | "celsius" | "\u{fffd}c" => "degC",
        "degf" | "°f" | "f" | "fahrenheit" => "degF",
        "k" | "kelvin" => "K",
        "ut" | "µt" | "microtesla" | "\u{fffd}t" => "uT",
        "mt" => "mT",
        "v" => "V",
        "mv" => "mV",
        "%" => "%",
        _ => return None,
    };
    let (unit, _) = parse_unit(known)?;
    (unit == Unit::of_column(target)).then_some(known)
}

/// Returns true for a unit of any quantity in a log, in brackets or not.
pub(in super::super) fn is_unit(text: &str) -> bool {
    let text = text.trim().trim_matches(['[', ']', '(', ')']);
    let targets = ["t_s", "ax_mps2", "gx_rads", "mag_x_ut", "temp_c", "supply_v", "load_pct"];
    targets.iter().any(|target| spelling(text, target).is_some())
}

/// Unit of a column: as stated in its header, else `default`. A stated unit that does not fit `target` is refused.
pub(super) fn unit_of(
    path: &Path,
    column: &str,
    target: &'static str,
    default: &'static str,
) -> Result<&'static str, RecordingError> {
    let Some(stated) = split(column).1 else { return Ok(default) };
    spelling(stated, target).ok_or_else(|| RecordingError::HeaderUnit {
        path: path.to_owned(),
        column: column.to_owned(),
        unit: stated.into(),
        target,
        example: spellings_of(Unit::of_column(target)).first().copied().unwrap_or_default(),
    })
}

/// Conversion of a column to the unit of `target`, based on [`unit_of`].
pub(super) fn conversion_of(
    path: &Path,
    column: &str,
    target: &'static str,
    default: &'static str,
) -> Result<(Affine, &'static str), RecordingError> {
    let unit = unit_of(path, column, target, default)?;
    Ok((parse_unit(unit).map_or(Affine::IDENTITY, |(_, conversion)| conversion), unit))
}

/// Rejects accelerometers whose median magnitude is gravity in another unit than the one in which they are read.
pub(super) fn refuse_other_gravity(
    path: &Path,
    table: &Table,
    entries: &[Entry],
    options: &LoadOptions,
) -> Result<(), RecordingError> {
    let find = |axis: &str| {
        let (target, column, how) = entries.iter().find(|(target, ..)| *target == axis)?;
        // the user states them
        let is_mapped = options.columns.column_of(target) != *target || options.columns.ignores(column);
        let values = table.columns.iter().find(|found| found.name == *column)?.values.as_slice();
        (!is_mapped).then_some((column.as_str(), how.as_str(), values))
    };
    let [Some(x), Some(y), Some(z)] = ACCELEROMETERS.map(find) else { return Ok(()) };
    let triad = [x.2, y.2, z.2];
    // arithmetic before the unit, a scale of counts, was computed from gravity itself
    let (sign, unit) = x.1.rsplit_once(':').unwrap_or(("", x.1));
    let (Some(magnitude), Some(fits)) = (gravity(triad), force_unit(triad)) else { return Ok(()) };
    if !matches!(sign, "" | "*-1") || fits == unit {
        return Ok(());
    }
    let stated = if split(x.0).1.is_some() { "their headers" } else { "their format" };
    let sign = if sign.is_empty() { String::new() } else { format!(":{sign}") };
    let entries = ACCELEROMETERS.iter().zip([x.0, y.0, z.0]);
    let map: Vec<String> =
        entries.map(|(target, column)| format!("'{target}={}{sign}:{fits}'", quoted(column))).collect();
    let (path, unit) = (path.to_owned(), unit.into());
    Err(RecordingError::GravityUnit { path, unit, stated, magnitude, fits, map: map.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_the_unit_from_the_name() {
        for (header, name, unit) in [
            ("w_RS_S_x [rad s^-1]", "w_RS_S_x", Some("rad s^-1")),
            ("Time since start in ms ", "Time since start", Some("ms")),
            ("gyroADC[0]", "gyroADC[0]", None),
            ("gyroADC[0] (deg/s)", "gyroADC[0]", Some("deg/s")),
            ("gyroRotationX(rad/s)", "gyroRotationX", Some("rad/s")),
            ("T [°C]", "T", Some("°C")),
            ("gFx", "gFx", None),
            ("x ()", "x ()", None),
        ] {
            assert_eq!(split(header), (name, unit), "{header}");
        }
    }

    #[test]
    fn rejects_units_of_another_quantity() {
        assert_eq!(spelling("rad s^-1", "gx_rads"), Some("rad/s"));
        assert_eq!(spelling("m s^-2", "ax_mps2"), Some("m/s2"));
        assert_eq!(spelling("m/sÂ²", "ax_mps2"), Some("m/s2"));
        assert_eq!([spelling("G", "ax_mps2"), spelling("G", "mag_x_ut")], [Some("g"), Some("gauss")]);
        for (stated, target) in
            [("m/s2", "gx_rads"), ("rad/s", "ax_mps2"), ("ms", "temp_c"), ("furlong", "ax_mps2"), ("", "t_s")]
        {
            assert_eq!(spelling(stated, target), None, "{stated}");
        }
        let refused = unit_of(Path::new("a.csv"), "A_X [furlong]", "ax_mps2", "g").unwrap_err().to_string();
        assert!(
            refused.contains("\"furlong\"") && refused.contains("as in 'ax_mps2=A_X [furlong]:m/s2'"),
            "{refused}"
        );
    }
}
