//! Betaflight's blackbox, decoded to CSV: its columns, and the scale of its accelerometer.

use super::super::guess::gravity;
use super::super::table::{Column, Table};
use super::Format;
use super::found::Found;
use crate::column::{ACCELEROMETERS, GYROS};

/// Counts to 1 g of the accelerometers that flight controllers have: a power of two.
const COUNTS_PER_G: [f64; 7] = [256.0, 512.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0];

/// Gravity differs from a power of two of counts by at most this factor, by scale, bias and flight.
const WITHIN: f64 = 1.25;

/// The columns of a blackbox, if it is one.
pub(super) fn decoded(table: &Table) -> Option<Found> {
    let of = |name: &str| {
        // as `gyroADC[0]` or `gyroADC[0] (deg/s)`
        let is = |column: &&Column| column.name.split(" (").next().is_some_and(|first| first == name);
        table.columns.iter().find(is)
    };
    let triad = |name: &str| -> Option<[&Column; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| of(&format!("{name}[{axis}]")));
        Some([x?, y?, z?])
    };
    let time = of("time")?;
    let gyro_name = ["gyroUnfilt", "gyroADC"].into_iter().find(|name| triad(name).is_some())?;
    let stamps =
        ["s", "ms"].into_iter().find(|unit| time.name.ends_with(&format!("({unit})"))).unwrap_or("us");
    let mut entries = vec![("t_s", time.name.clone(), stamps.to_owned())];
    for (target, column) in GYROS.into_iter().zip(triad(gyro_name)?) {
        let unit = if column.name.ends_with("(rad/s)") { "rad/s" } else { "dps" };
        entries.push((target, column.name.clone(), unit.to_owned()));
    }
    let filtered = if gyro_name == "gyroADC" { ", filtered by the flight controller" } else { "" };
    let mut assumed = format!("time in {stamps}; {gyro_name} in °/s, rounded{filtered}");
    if let Some(columns) = triad("accSmooth") {
        let how = match columns[0].name.rsplit_once('(').map(|(_, unit)| unit) {
            Some("g)") => Some(("g".to_owned(), "in g".to_owned())),
            Some("m/s/s)" | "m/s2)" | "m/s^2)") => Some(("m/s2".to_owned(), "in m/s²".to_owned())),
            _ => counts_per_g(columns)
                .map(|counts| (format!("/{counts}:g"), format!("in counts, {counts} to 1 g by gravity"))),
        };
        match how {
            Some((how, said)) => {
                for (target, column) in ACCELEROMETERS.into_iter().zip(columns) {
                    entries.push((target, column.name.clone(), how.clone()));
                }
                assumed.push_str(&format!("; accSmooth {said}, filtered by the flight controller"));
            }
            None => assumed.push_str("; accSmooth left out: gravity does not tell how many counts are 1 g"),
        }
    }
    Some(Found { format: Format::Betaflight, entries, assumed, gyro_clock: None })
}

/// Counts to 1 g.
fn counts_per_g(triad: [&Column; 3]) -> Option<f64> {
    let gravity = gravity(triad.map(|column| column.values.as_slice()))?;
    let is_near = |counts: &&f64| (1.0 / WITHIN..WITHIN).contains(&(gravity / **counts));
    COUNTS_PER_G.iter().find(is_near).copied()
}
