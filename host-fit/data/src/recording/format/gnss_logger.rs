//! Text of Google's GnssLogger: rows of many kinds, each beginning with its name; `#` before the fields of each kind.
//!
//! `UncalGyro,utcTimeMillis,elapsedRealtimeNanos,x,y,z,driftX,driftY,driftZ`; `Gyro,…` without the last three.

use std::io::{BufRead, Read};
use std::path::Path;

use super::super::error::RecordingError;
use super::super::provenance::{Frame, Provenance, SensorProvenance, Values};
use super::super::stream::Stream;
use super::dialect::{PHONE, PHONE_FACTORY};
use super::opened::Opened;
use super::{Format, ReadAs};
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};
use crate::file::FileError;
use crate::interrupt;

/// Kinds of rows: the raw one, which is preferred, and the corrected one as its substitute.
const SENSORS: [([&str; 2], [&str; 3]); 3] = [
    (["UncalAccel", "Accel"], ACCELEROMETERS),
    (["UncalGyro", "Gyro"], GYROS),
    (["UncalMag", "Mag"], MAGNETOMETERS),
];

/// Returns true if a text begins like such a log.
pub(super) fn is(begin: &[u8]) -> bool {
    let text = begin.strip_prefix(b"\xef\xbb\xbf").unwrap_or(begin);
    let says = |word: &[u8]| begin.windows(word.len()).any(|part| part == word);
    text.starts_with(b"#") && (says(b"elapsedRealtimeNanos") || says(b"# Raw,"))
}

/// Reads the rows of all sensors. With `strict`, an unusable row is an error.
pub(super) fn read(path: &Path, mut input: impl BufRead, strict: bool) -> Result<Opened, RecordingError> {
    // for every kind of row: timestamps and three values
    let mut rows: Vec<(Vec<i64>, [Vec<f64>; 3])> = vec![Default::default(); 2 * SENSORS.len()];
    let mut line = Vec::new();
    let mut unusable = 0_u64;
    loop {
        line.clear();
        let n =
            input.by_ref().take(1 << 20).read_until(b'\n', &mut line).map_err(FileError::reading(path))?;
        if n == 0 {
            break;
        }
        interrupt::check();
        let Ok(text) = std::str::from_utf8(&line) else { continue };
        let mut cells = text.trim_end().split(',');
        let kind = cells.next().unwrap_or_default();
        let kinds = SENSORS.iter().flat_map(|(kinds, _)| kinds);
        let Some(at) = kinds.into_iter().position(|known| *known == kind) else { continue };
        let stamp = cells.nth(1).and_then(|cell| cell.trim().parse::<i64>().ok());
        let mut value = || cells.next().and_then(|cell| cell.trim().parse::<f64>().ok());
        let (Some(stamp), Some(x), Some(y), Some(z)) = (stamp, value(), value(), value()) else {
            unusable += 1;
            continue;
        };
        let (stamps, values) = &mut rows[at];
        stamps.push(stamp);
        values.iter_mut().zip([x, y, z]).for_each(|(values, value)| values.push(value));
    }
    if strict && unusable > 0 {
        return Err(RecordingError::Damaged {
            path: path.to_owned(),
            format: Format::GnssLogger.knowledge().name,
            at: None,
            problem: format!("{unusable} rows cannot be read"),
        });
    }
    let mut streams = Vec::new();
    let mut provenance = Provenance::default();
    for (sensor, (kinds, names)) in SENSORS.iter().enumerate() {
        let taken = (0..2).find(|kind| rows[2 * sensor + kind].0.len() > 1);
        let Some(taken) = taken else { continue };
        let (stamps_ns, values) = std::mem::take(&mut rows[2 * sensor + taken]);
        let columns = names.iter().zip(values).map(|(name, values)| ((*name).to_owned(), values));
        let by = if taken == 0 { PHONE_FACTORY } else { PHONE };
        let values = Values::Corrected(by.into());
        let of_sensor = SensorProvenance { values, frame: Frame::Phone, ..SensorProvenance::default() };
        match *names {
            ACCELEROMETERS => provenance.accelerometers = of_sensor,
            GYROS => provenance.gyros = of_sensor,
            _ => {}
        }
        streams.push(Stream { name: kinds[taken].to_owned(), stamps_ns, columns: columns.collect() });
    }
    if !streams.iter().any(|stream| !stream.name.ends_with("Mag")) {
        return Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: "it has no accelerometer and gyro rows as GnssLogger writes them".to_owned(),
            help: "switch on \"Sensors\" in its settings, and record again",
        });
    }
    let names: Vec<&str> = streams.iter().map(|stream| stream.name.as_str()).collect();
    let lost = if unusable > 0 { format!("; {unusable} rows cannot be used") } else { String::new() };
    let assumed =
        format!("{}; m/s² with gravity, rad/s; each by elapsedRealtimeNanos{lost}", names.join(", "));
    Ok(Opened::Streams(streams, ReadAs { format: Format::GnssLogger, assumed, provenance: Some(provenance) }))
}
