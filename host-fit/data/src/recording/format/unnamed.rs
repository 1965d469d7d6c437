//! Tables without a header: recognises the columns by their values.
//!
//! Gravity is reliable: three adjacent columns whose norm is 1 g or 9.8 m/s² most of the time are the accelerometers,
//! and the only other three next to them, with the noise of a gyro, are the gyro. A column of rising numbers with even
//! steps is the time. Everything else is rejected, with column maps to choose from.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::guess::{force_unit, gravity, rate_unit, time_unit};
use super::super::load_options::LoadOptions;
use super::super::provenance::Provenance;
use super::super::table::Table;
use super::meaning::{Meaning, filled};
use super::{Format, ReadAs};
use crate::column::{ACCELEROMETERS, AXES, GYROS};
use crate::statistics::median_of;

/// Largest relative error of gravity by scale error and bias of a MEMS sensor.
const GRAVITY_WITHIN: f64 = 0.1;

/// Relative deviation of the norm from gravity in more than half of the rows: a log that is mostly at rest.
const AT_REST_WITHIN: f64 = 0.3;

/// Relative scatter below which a norm is synthetic: that of a unit vector or a quaternion.
const MIN_SCATTER: f64 = 1e-5;

/// Maximum number of sensors of a kind offered in an error.
const MAX_CHOICES: usize = 3;

/// Channel, column and unit.
type Entry = (&'static str, String, String);

pub(super) fn meaning(path: &Path, table: &Table, options: &LoadOptions) -> Result<Meaning, RecordingError> {
    let map = &options.columns;
    let is_given = |target: &str| map.column_of(target) != target;
    let is_free = |column: &usize| {
        let name = &table.columns[*column].name;
        !map.ignores(name) && !map.uses(name)
    };
    let mut rest: Vec<usize> = (0..table.columns.len()).filter(is_free).collect();
    let mut entries: Vec<Entry> = Vec::new();
    let entry = |target: &'static str, column: usize, unit: &str| {
        (target, table.columns[column].name.clone(), unit.to_owned())
    };
    rest.retain(|column| !is_row_number(&table.columns[*column].values));
    if !is_given("t_s") {
        let time =
            rest.iter().copied().find_map(|column| Some((column, clock(&table.columns[column].values)?)));
        if let Some((column, unit)) = time {
            rest.retain(|other| *other != column);
            entries.push(entry("t_s", column, unit));
        }
    }
    let has_time = is_given("t_s") || !entries.is_empty();
    let needs_rate = !has_time && options.rate_hz.is_none();
    let triads = triads(table, &rest);
    let named = |targets: [&'static str; 3], triad: [usize; 3], unit: &str| -> Vec<Entry> {
        targets.into_iter().zip(triad).map(|(target, column)| entry(target, column, unit)).collect()
    };
    let clock = entries.clone();
    let refused = |choices: Vec<Vec<Entry>>, may_be: &str| {
        let specs = |choice: Vec<Entry>| {
            clock
                .iter()
                .cloned()
                .chain(choice)
                .map(|(target, column, unit)| format!("{target}={column}:{unit}"))
                .collect()
        };
        let maps = choices.into_iter().map(specs).collect();
        Err(RecordingError::NoHeader {
            path: path.to_owned(),
            shows: format!("{}{may_be}", shows(table)),
            maps,
            needs_rate,
        })
    };
    if !AXES.iter().any(|axis| is_given(axis)) {
        let force: Vec<([usize; 3], &str)> =
            triads.iter().filter_map(|triad| Some((*triad, at_rest(values(table, *triad))?))).collect();
        let others: Vec<[usize; 3]> =
            triads.iter().copied().filter(|triad| force.iter().all(|(force, _)| force != triad)).collect();
        let rates: Vec<([usize; 3], &str)> =
            others.iter().filter_map(|triad| Some((*triad, rate_unit(&values(table, *triad))?))).collect();
        match (&force[..], &others[..], &rates[..]) {
            ([(triad, unit)], [], _) => entries.extend(named(ACCELEROMETERS, *triad, unit)),
            ([(triad, unit)], [_], [(rate, rate_unit)]) => {
                entries.extend(named(ACCELEROMETERS, *triad, unit));
                entries.extend(named(GYROS, *rate, rate_unit));
            }
            _ => {
                let mut choices: Vec<Vec<Entry>> = Vec::new();
                let rates = &rates[..rates.len().min(MAX_CHOICES)];
                for (triad, unit) in force.iter().take(MAX_CHOICES) {
                    let forces = named(ACCELEROMETERS, *triad, unit);
                    choices.extend(
                        rates.iter().map(|(rate, unit)| [&forces[..], &named(GYROS, *rate, unit)].concat()),
                    );
                    choices.push(forces);
                }
                if force.is_empty() {
                    choices.extend(rates.iter().map(|(rate, unit)| named(GYROS, *rate, unit)));
                    let other_unit = |unit: &str| if unit == "rad/s" { "dps" } else { "rad/s" };
                    choices.extend(rates.iter().map(|(rate, unit)| named(GYROS, *rate, other_unit(unit))));
                    let field = others.iter().filter(|triad| rates.iter().all(|(rate, _)| rate != *triad));
                    for triad in field.take(MAX_CHOICES) {
                        choices.push(named(GYROS, *triad, "dps"));
                    }
                }
                let may_be = match force.is_empty() && !others.is_empty() {
                    true => {
                        "; none show gravity: they may be a gyro's, or a magnetometer's, which alone is of no use"
                    }
                    false => "",
                };
                return refused(choices, may_be);
            }
        }
    }
    if needs_rate {
        return refused(vec![entries[clock.len()..].to_vec()], "");
    }
    let specs: Vec<String> =
        entries.iter().map(|(target, column, unit)| format!("{target}={column}:{unit}")).collect();
    let taken = |name: &String| entries.iter().any(|(_, column, _)| column == name) || map.uses(name);
    let unread: Vec<String> = table.names().into_iter().filter(|name| !taken(name)).collect();
    let unread = if unread.is_empty() { String::new() } else { format!("; not read: {}", unread.join(", ")) };
    let assumed = format!("no header, columns by their values: {}{unread}", specs.join(" "));
    let read_as = ReadAs { format: Format::Named, assumed, provenance: Some(Provenance::default()) };
    Ok(Meaning {
        map: filled(map, table, entries),
        read_as: Some(read_as),
        assumed_map: specs,
        ..Meaning::default()
    })
}

fn values(table: &Table, triad: [usize; 3]) -> [&[f64]; 3] {
    triad.map(|column| table.columns[column].values.as_slice())
}

/// Groups of three adjacent columns, each column in at most one of them.
fn triads(table: &Table, columns: &[usize]) -> Vec<[usize; 3]> {
    let mut triads = Vec::new();
    let mut at = 0;
    while at + 2 < columns.len() {
        let triad = [columns[at], columns[at + 1], columns[at + 2]];
        let is_joined = triad[2] == triad[0] + 2;
        // a single column before the triad, such as a temperature, shifts it by one
        let next = (at + 3 < columns.len()).then(|| [columns[at + 1], columns[at + 2], columns[at + 3]]);
        let is_next = next.is_some_and(|next| at_rest(values(table, next)).is_some());
        if is_joined && !(is_next && at_rest(values(table, triad)).is_none()) {
            triads.push(triad);
            at += 3;
        } else {
            at += 1;
        }
    }
    triads
}

/// Unit of three columns whose norm is gravity most of the time.
fn at_rest(triad: [&[f64]; 3]) -> Option<&'static str> {
    let unit = force_unit(triad)?;
    let median = gravity(triad)?;
    let one = match unit {
        "m/s2" => crate::unit::STANDARD_GRAVITY_MPS2,
        "g" => 1.0,
        _ => 1000.0,
    };
    let rows = triad.iter().map(|values| values.len()).min()?;
    let far = |row: usize| {
        (triad.iter().map(|values| values[row] * values[row]).sum::<f64>().sqrt() / median - 1.0).abs()
    };
    let far: Vec<f64> = (0..rows).map(far).filter(|far| far.is_finite()).collect();
    let near = far.iter().filter(|far| **far < AT_REST_WITHIN).count();
    let scatter = median_of(far.iter().copied())?;
    ((median / one - 1.0).abs() <= GRAVITY_WITHIN && 2 * near > far.len() && scatter > MIN_SCATTER)
        .then_some(unit)
}

/// Returns true for a column that counts the rows.
fn is_row_number(values: &[f64]) -> bool {
    values.len() > 2 && values.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
}

/// Unit of a column of rising timestamps with even steps.
fn clock(values: &[f64]) -> Option<&'static str> {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median_of(steps.iter().copied()).filter(|usual| *usual > 0.0)?;
    let rising = steps.iter().filter(|step| **step >= 0.0).count();
    let even = steps.iter().filter(|step| (**step - usual).abs() <= 0.5 * usual).count();
    (steps.len() > 1 && 20 * rising >= 19 * steps.len() && 2 * even > steps.len())
        .then(|| time_unit(values))?
}

/// Medians of the columns, as far as they fit a message.
fn shows(table: &Table) -> String {
    let median = |column: &super::super::table::Column| {
        let median = median_of(column.values.iter().copied().filter(|value| value.is_finite()));
        median.map_or_else(
            || format!("{} (no numbers)", column.name),
            |median| format!("{} ({})", column.name, crate::text::number(median)),
        )
    };
    let shown: Vec<String> = table.columns.iter().take(12).map(median).collect();
    shown.join(", ")
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::super::{ColumnMap, LoadOptions, LogWarning, Recording, load};
    use crate::recording::RecordingError;

    fn read(text: &str, options: &LoadOptions) -> Result<Recording, RecordingError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.txt");
        std::fs::write(&path, text).unwrap();
        load(&path, options)
    }

    fn noise(row: usize, size: f64) -> f64 {
        size * ((row * 7919 % 101) as f64 - 50.0) / 50.0
    }

    /// Rows of cells with a separator.
    fn text(separator: &str, row: impl Fn(usize) -> Vec<f64>) -> String {
        let mut text = String::new();
        for n in 0..600 {
            let cells: Vec<String> = row(n).iter().map(ToString::to_string).collect();
            writeln!(text, "{}", cells.join(separator)).unwrap();
        }
        text
    }

    fn six(row: usize) -> Vec<f64> {
        let small = |at: usize| noise(row + 17 * at, 0.003);
        vec![
            5.0 * row as f64,
            0.1 + small(0),
            small(1),
            1.0 + small(2),
            noise(row, 0.2),
            noise(row + 5, 0.2),
            3.0 + noise(row + 9, 0.2),
        ]
    }

    #[test]
    fn guesses_a_table_by_gravity_and_warns_with_the_map() {
        for separator in [",", ";", "\t", " ", "   ", " \t "] {
            let log = read(&text(separator, six), &LoadOptions::default())
                .unwrap_or_else(|error| panic!("{separator:?}: {error}"));
            assert_eq!((log.n_rows(), log.rate.true_hz.round()), (600, 200.0), "{separator:?}");
            let odd = log.warnings(&[true; 600]);
            let Some(LogWarning::AssumedMap(map)) =
                odd.iter().find(|odd| matches!(odd, LogWarning::AssumedMap(_)))
            else {
                panic!("{odd:?}")
            };
            assert_eq!(map[0], "t_s=column_1:ms");
            assert!(
                map.contains(&"ax_mps2=column_2:g".to_owned())
                    && map.contains(&"gz_rads=column_7:dps".to_owned()),
                "{map:?}"
            );
            // the suggested map reads the same, without the warning
            let options =
                LoadOptions { columns: ColumnMap::from_specs(map).unwrap(), ..LoadOptions::default() };
            let again = read(&text(separator, six), &options).unwrap();
            assert_eq!(again.channel("gz_rads").unwrap().values, log.channel("gz_rads").unwrap().values);
            assert!(!again.warnings(&[true; 600]).iter().any(|odd| matches!(odd, LogWarning::AssumedMap(_))));
        }
    }

    #[test]
    fn asks_for_the_rate_of_accelerometers_without_time() {
        let rows = text(" ", |row| vec![noise(row, 0.1), noise(row + 3, 0.1), 9.8 + noise(row + 7, 0.1)]);
        let error = read(&rows, &LoadOptions::default()).unwrap_err();
        let RecordingError::NoHeader { maps, needs_rate: true, .. } = &error else { panic!("{error}") };
        assert_eq!(maps[0], ["ax_mps2=column_1:m/s2", "ay_mps2=column_2:m/s2", "az_mps2=column_3:m/s2"]);
        assert!(error.to_string().contains("`rate_hz`"), "{error}");
        let log = read(&rows, &LoadOptions { rate_hz: Some(50.0), ..LoadOptions::default() }).unwrap();
        assert_eq!((log.n_rows(), log.rate.true_hz), (600, 50.0));
    }

    #[test]
    fn rejects_ambiguous_tables_with_maps_to_choose_from() {
        let options = LoadOptions { rate_hz: Some(50.0), ..LoadOptions::default() };
        let gyro = text(" ", |row| vec![noise(row, 0.002), 1.0 + noise(row, 0.002), noise(row, 0.002) - 3.4]);
        let two =
            text(",", |row| [six(row), vec![noise(row, 0.1), noise(row, 0.1), noise(row, 0.1)]].concat());
        let quaternion = text(",", |row| {
            let angle = 0.001 * row as f64;
            vec![0.005 * row as f64, angle.cos(), angle.sin(), 0.0]
        });
        for (text, first) in
            [(gyro, "gx_rads=column_1:rad/s"), (two, "t_s=column_1:ms"), (quaternion, "t_s=column_1:s")]
        {
            let error = read(&text, &options).unwrap_err();
            let RecordingError::NoHeader { maps, .. } = &error else { panic!("{error}") };
            assert!(maps.len() > 1 && maps[0][0] == first, "{maps:?}");
            // each of them can be pasted
            for map in maps {
                ColumnMap::from_specs(map).unwrap();
            }
        }
    }

    #[test]
    fn joins_a_row_of_names_and_one_of_units() {
        for (names, units) in
            [("time,ax,ay,az", "s,m/s^2,m/s^2,m/s^2"), ("time,ax,ay,az", "[ms],[g],[g],[g]")]
        {
            let mut rows = format!("{names}\n{units}\n");
            for row in 0..300 {
                let (step, one) = if units.starts_with('s') { (0.01, 9.8) } else { (10.0, 1.0) };
                writeln!(rows, "{},{},0,{one}", step * f64::from(row), noise(row as usize, 0.01)).unwrap();
            }
            let log = read(&rows, &LoadOptions::default()).unwrap();
            assert_eq!((log.n_rows(), log.quality.rows_unusable, log.rate.true_hz.round()), (300, 0, 100.0));
            assert!((log.channel("az_mps2").unwrap().values[5] - 9.8).abs() < 0.01);
        }
    }

    #[test]
    fn reads_names_between_spaces() {
        let mut rows = "  t_s   gx_rads gy_rads\n".to_owned();
        for row in 0..300 {
            writeln!(rows, " {}   {}  0.5", 0.01 * f64::from(row), noise(row as usize, 0.01)).unwrap();
        }
        let log = read(&rows, &LoadOptions::default()).unwrap();
        assert_eq!((log.n_rows(), log.channels().len()), (300, 2));
    }
}
