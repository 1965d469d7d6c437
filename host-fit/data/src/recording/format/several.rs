//! Folders and archives of one recording: one file for each sensor, or one log among other files.

use std::io::{BufRead, Read};
use std::path::Path;

use super::super::column_map::ColumnMap;
use super::super::csv_file;
use super::super::error::RecordingError;
use super::super::guess::force_unit;
use super::super::load_options::LoadOptions;
use super::super::stream::{Stream, stamps};
use super::super::table::Table;
use super::super::unusable::refuse_unusable;
use super::archive::{Archive, member_path};
use super::bytes::{BAG_IN_SQLITE, unpacked};
use super::found::Found;
use super::known::may_be_log_within;
use super::opened::{Extent, Opened};
use super::{Format, ReadAs};
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};
use crate::unit::STANDARD_GRAVITY;

/// A sensor that a file is of.
#[derive(Clone, Copy, PartialEq)]
enum Sensor {
    Accelerometer,
    Gyroscope,
    Magnetometer,
}

impl Sensor {
    fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Accelerometer => ACCELEROMETERS,
            Self::Gyroscope => GYROS,
            Self::Magnetometer => MAGNETOMETERS,
        }
    }

    /// The unit that a phone gives it in.
    fn unit(self, triad: [&[f64]; 3]) -> PhoneUnit {
        let [written, unit] = match self {
            // an iPhone's own
            Self::Accelerometer if force_unit(triad) == Some("g") => {
                return PhoneUnit { written: "g", unit: "g", factor: STANDARD_GRAVITY };
            }
            Self::Accelerometer => ["m/s²", "m/s2"],
            Self::Gyroscope => ["rad/s", "rad/s"],
            Self::Magnetometer => ["µT", "uT"],
        };
        PhoneUnit { written, unit, factor: 1.0 }
    }
}

/// The unit that a phone gives a sensor in.
struct PhoneUnit {
    /// As people write it.
    written: &'static str,
    /// As a column map has it.
    unit: &'static str,
    /// To the unit of the channel.
    factor: f64,
}

/// Reads what belongs together.
///
/// # Errors
///
/// There is nothing in it that is known, or it cannot be read.
pub(super) fn read(
    path: &Path,
    archive: &mut Archive,
    options: &LoadOptions,
    extent: Extent,
) -> Result<Opened, RecordingError> {
    let names = archive.names().to_vec();
    let named = |wanted: &str| {
        names.iter().find(|name| name.as_str() == wanted || name.ends_with(&format!("/{wanted}")))
    };
    if let Some(name) = named("imu0/data.csv").or_else(|| named("imu0.csv")) {
        return archive.read(name, |member, input| unpacked(member, input, options, extent, false));
    }
    if let Some(chosen) = Chosen::of(path, &names, archive)? {
        return chosen.read(path, archive, options);
    }
    // phyphox tells of the phone in there
    let is_of_phone = |name: &str| name.starts_with("meta/") || name.contains("/meta/");
    let logs: Vec<&String> =
        names.iter().filter(|name| may_be_log_within(name) && !is_of_phone(name)).collect();
    match logs[..] {
        [log] => archive.read(log, |member, input| unpacked(member, input, options, extent, false)),
        [] => {
            let is_sqlite = names.iter().any(|name| name.ends_with(".db3"));
            let is_workbook = names.iter().any(|name| name.starts_with("xl/"));
            let (is, help) = if is_sqlite {
                BAG_IN_SQLITE
            } else if is_workbook {
                ("it is a workbook (xlsx)", "save the sheet as CSV")
            } else {
                ("there is no log in it that is known", "name the log itself")
            };
            Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help })
        }
        _ => Err(RecordingError::SeveralLogs {
            path: path.to_owned(),
            logs: logs.into_iter().cloned().collect(),
        }),
    }
}

/// The files that are read of a recording with one for each sensor.
struct Chosen {
    format: Format,
    files: Vec<(Sensor, String)>,
    /// What the phone's system calls up is down here: its accelerometers are turned.
    is_turned: bool,
}

impl Chosen {
    /// # Errors
    ///
    /// There is an accelerometer, but only one that is without gravity.
    fn of(path: &Path, names: &[String], archive: &mut Archive) -> Result<Option<Self>, RecordingError> {
        let stem = |name: &String| {
            let file = name.rsplit_once('/').map_or(name.as_str(), |(_, file)| file);
            let is_csv = file.to_ascii_lowercase().ends_with(".csv");
            is_csv.then(|| file[..file.len() - 4].to_ascii_lowercase().replace([' ', '_', '-'], ""))
        };
        let find = |stems: &[&str]| {
            stems.iter().find_map(|wanted| names.iter().find(|name| stem(name).as_deref() == Some(wanted)))
        };
        let gyroscope = find(&["gyroscopeuncalibrated", "gyroscope"]);
        let total = find(&["accelerometeruncalibrated", "totalacceleration"]);
        let plain = find(&["accelerometer", "acceleration", "accelerationwithg"]);
        let Some(any) = gyroscope.or(total).or(plain) else { return Ok(None) };
        let header = archive.look_into(any, first_line)?.to_lowercase();
        let format = if header.contains("seconds_elapsed") {
            Format::SensorLogger
        } else if header.contains("time (s)") {
            Format::Phyphox
        } else {
            return Ok(None);
        };
        let mut files = Vec::new();
        let accelerometer = if format == Format::SensorLogger { total } else { plain };
        files.extend(accelerometer.map(|name| (Sensor::Accelerometer, name.clone())));
        files.extend(gyroscope.map(|name| (Sensor::Gyroscope, name.clone())));
        let magnetometer = find(&["magnetometeruncalibrated", "magnetometer"]);
        files.extend(magnetometer.map(|name| (Sensor::Magnetometer, name.clone())));
        if files.iter().all(|(sensor, _)| *sensor == Sensor::Magnetometer) {
            let (is, help) = WITHOUT_GRAVITY;
            let path = member_path(path, any);
            return Err(RecordingError::OtherFormat { path, is: is.to_owned(), help });
        }
        let is_turned = match find(&["metadata"]).filter(|_| format == Format::SensorLogger) {
            Some(name) => archive.look_into(name, |_, input| Ok(is_turned(input)))?,
            None => false,
        };
        Ok(Some(Self { format, files, is_turned }))
    }

    fn read(
        &self,
        path: &Path,
        archive: &mut Archive,
        options: &LoadOptions,
    ) -> Result<Opened, RecordingError> {
        let mut streams = Vec::new();
        let mut said = Vec::new();
        for (sensor, name) in &self.files {
            let read = |member: &Path, input: &mut dyn BufRead| {
                csv_file::read(member, input, &ColumnMap::default(), false, false)
            };
            let table = archive.read(name, read)?;
            refuse_unusable(&member_path(path, name), &table, options.strict)?;
            let (unusable, rows) = (table.quality.rows_unusable, table.quality.rows_in_file);
            if table.n_rows() < 2 {
                said.push(format!("{name} is empty"));
                continue;
            }
            let n_rows = table.n_rows();
            let (stream, unit) = self.stream(path, *sensor, name, table)?;
            let lost = match unusable + (n_rows - stream.stamps_ns.len()) as u64 {
                0 => String::new(),
                n => format!(" ({n} of {rows} rows cannot be used)"),
            };
            said.push(format!("{name} in {unit}{lost}"));
            streams.push(stream);
        }
        let turned =
            if self.is_turned { ", the accelerometer's sign turned so that gravity counts up" } else { "" };
        let assumed = format!(
            "{}; with gravity{turned}; each sensor by its own stamps; in the phone's frame; not corrected beyond what the phone does itself",
            said.join(", ")
        );
        Ok(Opened::Streams(streams, ReadAs { format: self.format, assumed }))
    }

    fn stream(
        &self,
        path: &Path,
        sensor: Sensor,
        name: &str,
        mut table: Table,
    ) -> Result<(Stream, &'static str), RecordingError> {
        let index = |is: &dyn Fn(&str) -> bool| table.columns.iter().position(|column| is(&column.name));
        let time = index(&|name| name == "seconds_elapsed" || name.eq_ignore_ascii_case("time (s)"));
        let axis = |letter: &str| {
            index(&|name: &str| {
                name.split(|c: char| !c.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case(letter))
                    && !name.to_lowercase().contains("absolute")
            })
        };
        let (Some(time), Some(x), Some(y), Some(z)) = (time, axis("x"), axis("y"), axis("z")) else {
            return Err(RecordingError::NotOfFormat {
                path: member_path(path, name),
                format: self.format,
                available: table.names(),
            });
        };
        table.drop_rows_without_time(time);
        let [x, y, z] = [x, y, z].map(|column| table.columns[column].values.as_slice());
        let PhoneUnit { written, factor, .. } = sensor.unit([x, y, z]);
        let scale = if sensor == Sensor::Accelerometer && self.is_turned { -factor } else { factor };
        let stamps = stamps(&table.columns[time].values);
        let columns = sensor.channels().into_iter().zip([x, y, z]).map(|(name, values)| {
            let stamped = values.iter().zip(&stamps).filter(|(_, stamp)| stamp.is_some());
            (name.to_owned(), stamped.map(|(value, _)| value * scale).collect())
        });
        let columns = columns.collect();
        Ok((
            Stream { name: name.to_owned(), stamps_ns: stamps.into_iter().flatten().collect(), columns },
            written,
        ))
    }
}

/// What is said where only the phone's estimate without gravity is there.
pub(super) const WITHOUT_GRAVITY: (&str, &str) = (
    "its accelerometer is without gravity, which is an estimate of the phone and no measurement",
    "record the total acceleration or the uncalibrated accelerometer (in phyphox: \"Acceleration with g\"), and the gyroscope",
);

/// What a file of Sensor Logger holds that stands alone: its name says which sensor it is of; none if it is no such file.
///
/// # Errors
///
/// It is of an accelerometer without gravity.
pub(super) fn one_of(path: &Path, table: &Table) -> Option<Result<Found, RecordingError>> {
    let column = |name: &str| table.columns.iter().find(|column| column.name == name);
    let _ = (column("time")?, column("seconds_elapsed")?);
    let triad = [column("x")?, column("y")?, column("z")?];
    let stem = path.file_name()?.to_string_lossy().split('.').next()?.to_ascii_lowercase();
    let sensor = match stem.trim_end_matches("uncalibrated") {
        "gyroscope" => Sensor::Gyroscope,
        "magnetometer" => Sensor::Magnetometer,
        "totalacceleration" => Sensor::Accelerometer,
        "accelerometer" if stem.ends_with("uncalibrated") => Sensor::Accelerometer,
        "accelerometer" => {
            let (is, help) = WITHOUT_GRAVITY;
            return Some(Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help }));
        }
        _ => return None,
    };
    let PhoneUnit { unit, .. } = sensor.unit(triad.map(|column| column.values.as_slice()));
    let mut entries = vec![("t_s", "seconds_elapsed".to_owned(), "s".to_owned())];
    for (target, column) in sensor.channels().into_iter().zip(triad) {
        entries.push((target, column.name.clone(), unit.to_owned()));
    }
    let assumed = format!(
        "{stem} in {unit}, by its name; seconds_elapsed in s; in the phone's frame; not corrected beyond what the phone does itself"
    );
    Some(Ok(Found { format: Format::SensorLogger, entries, assumed, gyro_clock: None }))
}

/// Whether the accelerometers of an iPhone are as its system has them: gravity counts down.
fn is_turned(input: &mut dyn BufRead) -> bool {
    let mut text = String::new();
    // a table of one row
    let read = input.take(1 << 16).read_to_string(&mut text);
    let mut rows = csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
    let names: Vec<String> =
        rows.headers().map(|names| names.iter().map(str::to_lowercase).collect()).unwrap_or_default();
    let row = rows.records().next().and_then(Result::ok).unwrap_or_default();
    let cell = |wanted: &str| names.iter().position(|name| name == wanted).and_then(|at| row.get(at));
    let is_apple = cell("platform").is_some_and(|platform| platform.eq_ignore_ascii_case("ios"));
    let is_standardised = cell("standardisation").is_some_and(|said| said.eq_ignore_ascii_case("true"));
    read.is_ok() && is_apple && !is_standardised
}

fn first_line(_: &Path, input: &mut dyn BufRead) -> Result<String, RecordingError> {
    let mut line = Vec::new();
    let read = input.take(1 << 16).read_until(b'\n', &mut line);
    Ok(read.map(|_| String::from_utf8_lossy(&line).into_owned()).unwrap_or_default())
}
