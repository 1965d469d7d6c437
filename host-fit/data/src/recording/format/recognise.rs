//! Recognises the columns of a table: by the user's map, by the program that wrote them, or by names that state a unit.

use std::path::Path;

use super::super::column_map::{ColumnMap, quoted};
use super::super::error::RecordingError;
use super::super::guess::{Guess, Undecided, guesses};
use super::super::load_options::LoadOptions;
use super::super::provenance::Provenance;
use super::super::table::Table;
use super::dialect::{Dialect, is_named};
use super::found::Found;
use super::meaning::{Meaning, filled};
use super::{Format, ReadAs, betaflight, header, several, unnamed, xsens};
use crate::column::{AXES, Triad};

pub(in super::super) fn meaning(
    path: &Path,
    table: &Table,
    options: &LoadOptions,
) -> Result<Meaning, RecordingError> {
    let map = &options.columns;
    let has = |target: &str| table.index_of(map.column_of(target)).is_some();
    let has_axes = AXES.iter().any(|axis| has(axis));
    let has_time = has("t_s") || options.rate_hz.is_some();
    match options.format {
        Some(Format::Log) => return Ok(Meaning::of_user(options)),
        None if has_axes && has_time => return Ok(Meaning::of_user(options)),
        _ => {}
    }
    if table.is_unnamed {
        return match options.format {
            None | Some(Format::Named) => unnamed::meaning(path, table, options),
            Some(format) => {
                Err(RecordingError::NotOfFormat { path: path.to_owned(), format, available: table.names() })
            }
        };
    }
    if let Some(found) = of_program(path, table, options)? {
        let Found { format, entries, assumed, mut provenance, gyro_clock, counter } = found;
        header::refuse_other_gravity(path, table, &entries, options)?;
        // columns mapped by the user have no known provenance
        for triad in [Triad::Accelerometers, Triad::Gyros] {
            if triad.columns().iter().any(|axis| map.column_of(axis) != *axis) {
                provenance.forget(triad);
            }
        }
        let read_as = Some(ReadAs { format, assumed, provenance: Some(provenance) });
        return Ok(Meaning {
            map: filled(map, table, entries),
            read_as,
            gyro_clock,
            counter,
            ..Meaning::default()
        });
    }
    if let Some(format) = options.format.filter(|format| *format != Format::Named) {
        return Err(RecordingError::NotOfFormat { path: path.to_owned(), format, available: table.names() });
    }
    let meaning = by_names(path, table, map, has_axes, has_time);
    if options.format == Some(Format::Named) && has_axes && meaning.read_as.is_none() {
        let format = Format::Named;
        return Err(RecordingError::NotOfFormat { path: path.to_owned(), format, available: table.names() });
    }
    Ok(meaning)
}

/// Channels of the columns of a known program.
fn of_program(path: &Path, table: &Table, options: &LoadOptions) -> Result<Option<Found>, RecordingError> {
    let may_be = |format: Format| options.format.is_none_or(|given| given == format);
    if let Some(found) = several::one_of(path, table).filter(|_| may_be(Format::SensorLogger)) {
        return found.map(Some);
    }
    if let Some(dialect) = Dialect::of(table, options.format) {
        return of_dialect(path, table, options, dialect).map(Some);
    }
    if may_be(Format::Xsens)
        && let Some(found) = xsens::exported(path, table)?
    {
        return Ok(Some(found));
    }
    if !may_be(Format::Betaflight) {
        return Ok(None);
    }
    betaflight::decoded(path, table)
}

fn of_dialect(
    path: &Path,
    table: &Table,
    options: &LoadOptions,
    dialect: &Dialect,
) -> Result<Found, RecordingError> {
    if let Some((is, help)) = dialect.refused {
        return Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help });
    }
    let is_text = |pattern: &str| table.quality.text_columns.iter().find(|name| is_named(name, pattern));
    if let Some(column) = dialect.clock().and_then(is_text)
        && options.rate_hz.is_none()
        && options.columns.column_of("t_s") == "t_s"
    {
        return Err(RecordingError::TextColumn {
            path: path.to_owned(),
            column: column.clone(),
            first: table.quality.first_text.clone().map(Box::new),
        });
    }
    let gyro_clock = dialect.gyro_clock.and_then(|pattern| {
        table.columns.iter().map(|column| &column.name).find(|name| is_named(name, pattern)).cloned()
    });
    let gyro_clock = match gyro_clock {
        Some(column) => {
            let unit = header::unit_of(path, &column, "t_s", "s")?;
            Some((column, unit))
        }
        None => None,
    };
    let entries = dialect.entries(path, table, options)?;
    let (format, assumed, provenance) = (dialect.format, dialect.assumed(&entries), dialect.provenance());
    Ok(Found { format, entries, assumed, provenance, gyro_clock, counter: None })
}

/// Channels by names that state them; ambiguous columns are left to the user.
fn by_names(path: &Path, table: &Table, map: &ColumnMap, has_axes: bool, has_time: bool) -> Meaning {
    let columns: Vec<(&str, &[f64])> =
        table.columns.iter().map(|column| (column.name.as_str(), column.values.as_slice())).collect();
    let is_wanted = |target: &str| if target == "t_s" { !has_time } else { !has_axes };
    let found = guesses(&columns);
    let mut sure = Vec::new();
    let mut perhaps = Vec::new();
    for ((column, _), guess) in columns.iter().zip(found.columns) {
        let Some(Guess { target, unit: Some(unit), sure: is_sure, others, .. }) = guess else { continue };
        match (is_wanted(&target), is_sure) {
            (false, _) => {}
            (true, true) => sure.push((target, (*column).to_owned(), unit.to_owned(), others)),
            (true, false) => perhaps.push(format!("{target}={}:{unit}", quoted(column))),
        }
    }
    // in the order of the channels, independent of that of the columns
    sure.sort();
    perhaps.sort();
    let entry = |(target, column, unit, _): &(String, String, String, Vec<String>)| {
        format!("{target}={}:{unit}", quoted(column))
    };
    let undecided: Vec<Undecided> =
        found.undecided.into_iter().filter(|group| group.targets.iter().any(|t| is_wanted(t))).collect();
    if !undecided.is_empty() {
        // complete, since only mapped columns are used once there is a map
        let decided: Vec<String> = sure.iter().map(entry).chain(perhaps.iter().cloned()).collect();
        let undecided = undecided_error(path, &undecided, &decided);
        return Meaning { map: map.clone(), perhaps, undecided: Some(undecided), ..Meaning::default() };
    }
    // a partial set of axes would be used without notice, so all are suggested instead
    let is_axis = |target: &str| AXES.contains(&target);
    let all_stated = !perhaps.iter().any(|spec| AXES.iter().any(|axis| spec.starts_with(axis)));
    if sure.is_empty() || !all_stated {
        perhaps.extend(sure.iter().map(entry));
        return Meaning { map: map.clone(), perhaps, ..Meaning::default() };
    }
    let descriptions = sure.iter().map(|(target, column, unit, others)| {
        let others = match others.is_empty() {
            true => String::new(),
            false => format!(" (also possible, if the column map has it: {})", others.join(", ")),
        };
        format!("{column} is {target} in {unit}{others}")
    });
    let descriptions: Vec<String> = descriptions.collect();
    let frame = if sure.iter().any(|(target, ..)| is_axis(target)) {
        "; with gravity, if nothing else is known"
    } else {
        ""
    };
    let assumed = format!("{}{frame}", descriptions.join(", "));
    let read_as = ReadAs { format: Format::Named, assumed, provenance: Some(Provenance::default()) };
    let entries = sure.into_iter().map(|(target, column, unit, _)| (target, column, unit)).collect();
    Meaning { map: filled(map, table, entries), read_as: Some(read_as), perhaps, ..Meaning::default() }
}

/// Error for equally good candidates, with complete column maps to choose from.
fn undecided_error(path: &Path, undecided: &[Undecided], decided: &[String]) -> RecordingError {
    let column =
        |entry: &String| entry.split_once('=').map_or(entry.clone(), |(_, column)| column.to_owned());
    let problem = undecided.iter().map(|Undecided { targets, choices }| {
        let choices = choices.iter().map(|entries| entries.iter().map(column).collect::<Vec<_>>().join(", "));
        format!("{} may be {}", targets.join(", "), choices.collect::<Vec<_>>().join("; or "))
    });
    // each choice for the first channel, with the first choice for the others
    let of_others = undecided.iter().skip(1).filter_map(|group| group.choices.first()).flatten();
    let rest: Vec<String> = of_others.chain(decided).cloned().collect();
    let first = undecided.first().map_or(&[][..], |group| &group.choices);
    let maps = first.iter().map(|entries| entries.iter().chain(&rest).cloned().collect()).collect();
    let problem = problem.collect::<Vec<_>>().join("; ");
    let problem = format!("{problem}: equally good by their names, and they differ");
    RecordingError::Undecided { path: path.to_owned(), problem, maps }
}
