//! Betaflight's blackbox, decoded to CSV: its columns, and the scale of its accelerometer.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::guess::gravity;
use super::super::provenance::{Frame, Provenance, Values};
use super::super::table::{Column, Table};
use super::found::Found;
use super::{Format, header};
use crate::column::{ACCELEROMETERS, GYROS};

/// Counts per g of the accelerometers on flight controllers: a power of two.
const COUNTS_PER_G: [f64; 7] = [256.0, 512.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0];

/// Largest ratio of measured gravity to a power of two of counts, due to scale error, bias and flight.
const WITHIN: f64 = 1.25;

/// Columns of a blackbox, if the table is one.
pub(super) fn decoded(path: &Path, table: &Table) -> Result<Option<Found>, RecordingError> {
    let of = |name: &str| {
        // such as `gyroADC[0]` or `gyroADC[0] (deg/s)`
        let is = |column: &&Column| header::split(&column.name).0 == name;
        table.columns.iter().find(is)
    };
    let triad = |name: &str| -> Option<[&Column; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| of(&format!("{name}[{axis}]")));
        Some([x?, y?, z?])
    };
    let gyro = ["gyroUnfilt", "gyroADC"].into_iter().find_map(|name| Some((name, triad(name)?)));
    let (Some(time), Some((gyro_name, gyro))) = (of("time"), gyro) else { return Ok(None) };
    let stamps = header::unit_of(path, &time.name, "t_s", "us")?;
    let mut entries = vec![("t_s", time.name.clone(), stamps.to_owned())];
    for (target, column) in GYROS.into_iter().zip(gyro) {
        let unit = header::unit_of(path, &column.name, target, "dps")?;
        entries.push((target, column.name.clone(), unit.to_owned()));
    }
    let filtered = if gyro_name == "gyroADC" { ", filtered by the flight controller" } else { "" };
    let gyro_unit = entries.last().map_or("dps", |(_, _, unit)| unit);
    let mut assumed =
        format!("time in {stamps}; {gyro_name} in {gyro_unit}, rounded, less its mean at start-up{filtered}");
    if let Some(columns) = triad("accSmooth") {
        let how = match header::unit_of(path, &columns[0].name, ACCELEROMETERS[0], "")? {
            "" => counts_per_g(columns)
                .map(|counts| (format!("/{counts}:g"), format!("in counts, {counts} to 1 g by gravity"))),
            unit => Some((unit.to_owned(), format!("in {unit}"))),
        };
        match how {
            Some((how, state)) => {
                for (target, column) in ACCELEROMETERS.into_iter().zip(columns) {
                    entries.push((target, column.name.clone(), how.clone()));
                }
                assumed.push_str(&format!("; accSmooth {state}, filtered by the flight controller"));
            }
            None => assumed.push_str("; accSmooth excluded: gravity does not show how many counts are 1 g"),
        }
    }
    let by = "Betaflight (gyro zero and accelerometer trim subtracted, turned to the vehicle)";
    let provenance = Provenance::of_both(Values::Corrected(by.into()), Frame::Vehicle);
    Ok(Some(Found {
        format: Format::Betaflight,
        entries,
        assumed,
        provenance,
        gyro_clock: None,
        counter: None,
    }))
}

fn counts_per_g(triad: [&Column; 3]) -> Option<f64> {
    let gravity = gravity(triad.map(|column| column.values.as_slice()))?;
    let is_near = |counts: &&f64| (1.0 / WITHIN..WITHIN).contains(&(gravity / **counts));
    COUNTS_PER_G.iter().find(is_near).copied()
}
