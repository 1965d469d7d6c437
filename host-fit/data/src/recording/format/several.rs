//! Folders and archives of one recording: one file for each sensor, or one log among other files.

use std::io::{BufRead, Read};
use std::path::Path;

use super::super::column_map::ColumnMap;
use super::super::column_words::is_decoy;
use super::super::csv_file;
use super::super::error::RecordingError;
use super::super::guess::force_unit;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, SensorProvenance, Values};
use super::super::stream::{Stream, stamps};
use super::super::table::Table;
use super::super::unusable::refuse_unusable;
use super::archive::{Archive, member_path};
use super::bytes::{BAG_IN_SQLITE, unpacked};
use super::dialect::{PHONE, PHONE_FACTORY, is_named};
use super::found::Found;
use super::known::may_be_log_within;
use super::opened::{Extent, Opened};
use super::{Format, ReadAs, choice, header};
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};

#[derive(Clone, Copy, PartialEq)]
enum Sensor {
    Accelerometer,
    Gyroscope,
    Magnetometer,
}

/// Names of files without spaces and dashes, the preferred one first.
const GYROSCOPES: &[&str] = &["gyroscopeuncalibrated", "gyroscope"];
const TOTAL_ACCELEROMETERS: &[&str] = &["accelerometeruncalibrated", "totalacceleration"];
const PLAIN_ACCELEROMETERS: &[&str] = &["accelerometer", "acceleration", "accelerationwithg"];
const MAGNETOMETER_FILES: &[&str] = &["magnetometeruncalibrated", "magnetometer"];

impl Sensor {
    /// Sensor by the name of a file.
    fn of_file(name: &str) -> Option<Self> {
        Self::of_stem(stem(name)?.as_str())
    }

    fn of_stem(stem: &str) -> Option<Self> {
        let is = |stems: &[&str]| stems.contains(&stem);
        if is(TOTAL_ACCELEROMETERS) || is(PLAIN_ACCELEROMETERS) {
            return Some(Self::Accelerometer);
        }
        if is(GYROSCOPES) {
            return Some(Self::Gyroscope);
        }
        is(MAGNETOMETER_FILES).then_some(Self::Magnetometer)
    }

    fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Accelerometer => ACCELEROMETERS,
            Self::Gyroscope => GYROS,
            Self::Magnetometer => MAGNETOMETERS,
        }
    }

    /// Unit used by a phone if the header states none, as in a column map.
    fn unit(self, triad: [&[f64]; 3]) -> &'static str {
        match self {
            // of an iPhone
            Self::Accelerometer if force_unit(triad) == Some("g") => "g",
            Self::Accelerometer => "m/s2",
            Self::Gyroscope => "rad/s",
            Self::Magnetometer => "uT",
        }
    }
}

/// Returns true if the accelerometers have the sign of Core Motion, in which gravity is negative. Sensor Logger uses g
/// only for unchanged values of an iPhone (its UNITS.md, CROSSPLATFORM.md), so that the unit is sufficient without
/// metadata; for values in m/s² the metadata decide.
fn has_sign_of_ios(unit: &str, platform: Platform) -> bool {
    unit == "g" || platform == Platform::Ios
}

/// Phone by the metadata of a recording of Sensor Logger.
#[derive(Clone, Copy, PartialEq)]
enum Platform {
    Unknown,
    /// An iPhone with the values of its system.
    Ios,
    /// Android, or an iPhone with standardised values.
    Android,
}

/// Corrections in the values of a phone, by the name of their sensor.
fn provenance_of(stem: &str) -> SensorProvenance {
    let by = if stem.contains("uncalibrated") { PHONE_FACTORY } else { PHONE };
    let values = Values::Corrected(by.into());
    SensorProvenance { values, frame: Frame::Phone, ..SensorProvenance::default() }
}

/// A recording in a folder or an archive.
struct Candidate<'a> {
    /// Name for the user's choice: its folder, or the name of its file.
    name: String,
    kind: Kind<'a>,
}

enum Kind<'a> {
    /// Files of one folder, one for each sensor.
    Sensors(Vec<&'a String>),
    /// A single log.
    Log(&'a String),
}

/// Reads one recording: the files of one folder, or one log. Several are refused unless one is chosen as the topic.
pub(super) fn read(
    path: &Path,
    archive: &mut Archive,
    options: &LoadOptions,
    extent: Extent,
) -> Result<Opened, RecordingError> {
    let names = archive.names().to_vec();
    let candidates = candidates(&names, archive)?;
    let asked = options.topic.as_ref();
    let chosen = candidates.iter().find(|candidate| Some(&candidate.name) == asked);
    let (candidate, options) = match (chosen, &candidates[..]) {
        (Some(chosen), _) => (chosen, LoadOptions { topic: None, ..options.clone() }),
        (None, [one]) => (one, options.clone()),
        (None, []) => return Err(nothing(path, &names)),
        (None, several) => {
            return Err(RecordingError::SeveralLogs {
                path: path.to_owned(),
                logs: several.iter().map(|candidate| candidate.name.clone()).collect(),
            });
        }
    };
    match &candidate.kind {
        Kind::Log(log) => archive.read(log, |member, input| unpacked(member, input, &options, extent, false)),
        Kind::Sensors(files) => {
            let chosen = Chosen::of(path, &names, files, archive)?;
            refuse_other_format(path, options.format, chosen.format)?;
            let offers = chosen.files.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>().join(", ");
            choice::refuse_topic(path, &options, &format!("one recording of {offers}"))?;
            chosen.read(path, archive, &options)
        }
    }
}

fn refuse_other_format(path: &Path, given: Option<Format>, found: Format) -> Result<(), RecordingError> {
    match given.filter(|given| *given != found) {
        None => Ok(()),
        Some(given) => Err(RecordingError::OtherFormat {
            path: path.to_owned(),
            is: format!("its files are those of {found}, but the stated format is {given}"),
            help: "leave the format out, so that it is found by the content",
        }),
    }
}

/// Recordings in an archive, by their names.
fn candidates<'a>(names: &'a [String], archive: &mut Archive) -> Result<Vec<Candidate<'a>>, RecordingError> {
    let mut candidates = Vec::new();
    // tables of EuRoC and Kalibr, one for each IMU
    let tables: Vec<&String> = names.iter().filter(|name| is_imu_table(name)).collect();
    for name in &tables {
        let short = name.strip_suffix("/data.csv").or(name.strip_suffix(".csv")).unwrap_or(name);
        candidates.push(Candidate { name: short.to_owned(), kind: Kind::Log(name) });
    }
    let mut folders: Vec<&str> = names.iter().map(|name| folder_of(name)).collect();
    folders.sort_unstable();
    folders.dedup();
    for folder in folders {
        let files: Vec<&String> = names.iter().filter(|name| folder_of(name) == folder).collect();
        let Some(any) =
            files.iter().find(|name| Sensor::of_file(name).is_some_and(|s| s != Sensor::Magnetometer))
        else {
            continue;
        };
        if !tables.contains(any) && format_of(archive, any)?.is_some() {
            let name = if folder.is_empty() { ".".to_owned() } else { folder.to_owned() };
            candidates.push(Candidate { name, kind: Kind::Sensors(files) });
        }
    }
    // the binary log in a .gt3x of ActiGraph is no table
    if names.iter().any(|name| name == "info.txt") && names.iter().any(|name| name == "log.bin") {
        return Ok(Vec::new());
    }
    // phyphox describes the phone in there
    let is_of_phone = |name: &str| name.starts_with("meta/") || name.contains("/meta/");
    let logs = names.iter().filter(|name| may_be_log_within(name) && !is_of_phone(name));
    // next to recordings of a known form only files that are logs by name alone: other tables hold other data
    let is_alone = candidates.is_empty();
    let logs = logs.filter(|name| is_alone || is_log_by_name(name));
    candidates.extend(logs.map(|name| Candidate { name: name.clone(), kind: Kind::Log(name) }));
    Ok(candidates)
}

fn nothing(path: &Path, names: &[String]) -> RecordingError {
    let is_sqlite = names.iter().any(|name| name.ends_with(".db3"));
    let is_workbook = names.iter().any(|name| name.starts_with("xl/"));
    let has = |name: &str| names.iter().any(|known| known == name);
    let (is, help) = if has("info.txt") && has("log.bin") {
        ("it is a log of an ActiGraph (.gt3x)", "export it as raw CSV by ActiLife or CentrePoint")
    } else if is_sqlite {
        BAG_IN_SQLITE
    } else if is_workbook {
        ("it is a workbook (xlsx)", "save the sheet as CSV")
    } else {
        ("there is no log in it that is known", "name the log itself")
    };
    RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help }
}

fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Returns true for `imu0.csv` or `imu0/data.csv` with any number.
fn is_imu_table(name: &str) -> bool {
    let table = name.strip_suffix("/data.csv").or(name.strip_suffix(".csv")).unwrap_or_default();
    let last = table.rsplit('/').next().unwrap_or_default();
    last.strip_prefix("imu").is_some_and(|number| number.parse::<u8>().is_ok())
}

/// Returns true for endings that only logs have.
fn is_log_by_name(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    [".ulg", ".mcap", ".bag"].iter().any(|ending| name.ends_with(ending))
}

/// Lower-case name of a table without folder, ending, spaces and dashes; `None` if it is no table. A prefix before the
/// name of a sensor, as in `run1_Gyroscope.csv`, is removed.
fn stem(name: &str) -> Option<String> {
    let file = name.rsplit_once('/').map_or(name, |(_, file)| file).to_ascii_lowercase();
    let file = file.strip_suffix(".csv")?;
    let is_part = |letter: char| [' ', '_', '-', '.'].contains(&letter);
    let ends = file.char_indices().filter(|(_, letter)| is_part(*letter)).map(|(at, _)| at + 1);
    let sensor = std::iter::once(0).chain(ends).find_map(|from| {
        let (before, stem) = (&file[..from], file[from..].replace(is_part, ""));
        let is_estimate = ESTIMATES.iter().any(|word| before.contains(word));
        (!is_estimate && Sensor::of_stem(&stem).is_some()).then_some(stem)
    });
    Some(sensor.unwrap_or_else(|| file.replace([' ', '_', '-'], "")))
}

/// Words before the name of a sensor that make it an estimate of the phone.
const ESTIMATES: [&str; 3] = ["linear", "user", "gravity"];

/// Program that writes such a file, by its header.
fn format_of(archive: &mut Archive, name: &str) -> Result<Option<Format>, RecordingError> {
    let header = archive.look_into(name, first_line)?.to_lowercase();
    Ok(if header.contains("seconds_elapsed") {
        Some(Format::SensorLogger)
    } else if header.contains("time (s)") {
        Some(Format::Phyphox)
    } else {
        None
    })
}

/// Files to read of a recording with one for each sensor.
struct Chosen {
    format: Format,
    files: Vec<(Sensor, String)>,
    platform: Platform,
    /// An accelerometer without gravity, which is not read.
    without_gravity: Option<String>,
}

impl Chosen {
    /// Files to read among those of one folder; `all` are the files of the archive. Two files of one sensor are refused,
    /// and acceleration without gravity alone.
    fn of(
        path: &Path,
        all: &[String],
        names: &[&String],
        archive: &mut Archive,
    ) -> Result<Self, RecordingError> {
        let find = |stems: &[&str]| -> Result<Option<&String>, RecordingError> {
            for wanted in stems {
                let found: Vec<&String> =
                    names.iter().copied().filter(|name| stem(name).as_deref() == Some(wanted)).collect();
                match found[..] {
                    [] => {}
                    [one] => return Ok(Some(one)),
                    _ => {
                        return Err(RecordingError::SeveralLogs {
                            path: path.to_owned(),
                            logs: found.into_iter().cloned().collect(),
                        });
                    }
                }
            }
            Ok(None)
        };
        let gyroscope = find(GYROSCOPES)?;
        let total = find(TOTAL_ACCELEROMETERS)?;
        let plain = find(PLAIN_ACCELEROMETERS)?;
        let any = gyroscope.or(total).or(plain).unwrap_or(names[0]);
        let format = format_of(archive, any)?.unwrap_or(Format::SensorLogger);
        let mut files = Vec::new();
        let accelerometer = if format == Format::SensorLogger { total } else { plain };
        files.extend(accelerometer.map(|name| (Sensor::Accelerometer, name.clone())));
        files.extend(gyroscope.map(|name| (Sensor::Gyroscope, name.clone())));
        let magnetometer = find(MAGNETOMETER_FILES)?;
        files.extend(magnetometer.map(|name| (Sensor::Magnetometer, name.clone())));
        if files.iter().all(|(sensor, _)| *sensor == Sensor::Magnetometer) {
            let (is, help) = WITHOUT_GRAVITY;
            let path = member_path(path, any);
            return Err(RecordingError::OtherFormat { path, is: is.to_owned(), help });
        }
        // that of the folder, or the only one there is
        let mut elsewhere = all.iter().filter(|name| stem(name).as_deref() == Some("metadata"));
        let only = elsewhere.next().filter(|_| elsewhere.next().is_none());
        let metadata = find(&["metadata"])?.or(only).filter(|_| format == Format::SensorLogger);
        let platform = match metadata {
            Some(name) => archive.look_into(name, |_, input| Ok(platform(input)))?,
            None => Platform::Unknown,
        };
        let is_read = files.iter().any(|(sensor, _)| *sensor == Sensor::Accelerometer);
        let without_gravity = plain.filter(|_| !is_read && format == Format::SensorLogger).cloned();
        Ok(Self { format, files, platform, without_gravity })
    }

    fn read(
        &self,
        path: &Path,
        archive: &mut Archive,
        options: &LoadOptions,
    ) -> Result<Opened, RecordingError> {
        let mut streams = Vec::new();
        let mut descriptions = Vec::new();
        let mut provenance = Provenance::default();
        for (sensor, name) in &self.files {
            let read = |member: &Path, input: &mut dyn BufRead| {
                csv_file::read(member, input, &ColumnMap::default(), false, false)
            };
            let table = archive.read(name, read)?;
            refuse_unusable(&member_path(path, name), &table, options.strict)?;
            let (unusable, rows) = (table.quality.rows_unusable, table.quality.rows_in_file);
            if table.n_rows() < 2 {
                descriptions.push(format!("{name} is empty"));
                continue;
            }
            let n_rows = table.n_rows();
            let (stream, unit) = self.stream(path, *sensor, name, table)?;
            let of_sensor = provenance_of(&name.to_lowercase());
            match sensor {
                Sensor::Accelerometer => provenance.accelerometers = of_sensor,
                Sensor::Gyroscope => provenance.gyros = of_sensor,
                Sensor::Magnetometer => {}
            }
            let lost = match unusable + (n_rows - stream.stamps_ns.len()) as u64 {
                0 => String::new(),
                n => format!(" ({n} of {rows} rows cannot be used)"),
            };
            descriptions.push(format!("{name} in {unit}{lost}"));
            streams.push(stream);
        }
        let gravity = match &self.without_gravity {
            Some(name) => format!(
                "{name} is without gravity and not read: record the total acceleration or the uncalibrated accelerometer"
            ),
            None => "with gravity".to_owned(),
        };
        let assumed = format!("{}; {gravity}; each sensor has its own timestamps", descriptions.join(", "));
        Ok(Opened::Streams(streams, ReadAs { format: self.format, assumed, provenance: Some(provenance) }))
    }

    fn stream(
        &self,
        path: &Path,
        sensor: Sensor,
        name: &str,
        mut table: Table,
    ) -> Result<(Stream, String), RecordingError> {
        let index = |is: &dyn Fn(&str) -> bool| table.columns.iter().position(|column| is(&column.name));
        // the time of Sensor Logger is the time of day, and states no unit
        let time = index(&|name| name == "seconds_elapsed" || is_named(name, "time ()"));
        let axis = |letter: &str| {
            index(&|name: &str| {
                name.split(|c: char| !c.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case(letter))
                    && !name.to_lowercase().contains("absolute")
                    && !is_decoy(name)
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
        let member = member_path(path, name);
        let default = sensor.unit([x, y, z].map(|column| table.columns[column].values.as_slice()));
        let (to_s, _) = header::conversion_of(&member, &table.columns[time].name, "t_s", "s")?;
        to_s.apply(&mut table.columns[time].values);
        let mut units = Vec::new();
        let mut is_turned = false;
        for (target, column) in sensor.channels().into_iter().zip([x, y, z]) {
            let column = &mut table.columns[column];
            let (conversion, unit) = header::conversion_of(&member, &column.name, target, default)?;
            conversion.apply(&mut column.values);
            is_turned = self.format == Format::SensorLogger
                && sensor == Sensor::Accelerometer
                && has_sign_of_ios(unit, self.platform);
            if is_turned {
                column.values.iter_mut().for_each(|value| *value = -*value);
            }
            if !units.contains(&unit) {
                units.push(unit);
            }
        }
        let sign = match (sensor, self.format, self.platform) {
            _ if is_turned => ", its sign turned so that gravity counts up",
            (Sensor::Accelerometer, Format::SensorLogger, Platform::Unknown) => {
                ", assumed Android (no Metadata.csv; an iPhone's has the other sign)"
            }
            _ => "",
        };
        let written = format!("{}{sign}", units.join(" and "));
        let stamps = stamps(&table.columns[time].values);
        let columns = sensor.channels().into_iter().zip([x, y, z]).map(|(name, column)| {
            let stamped =
                table.columns[column].values.iter().zip(&stamps).filter(|(_, stamp)| stamp.is_some());
            (name.to_owned(), stamped.map(|(value, _)| *value).collect())
        });
        let columns = columns.collect();
        Ok((
            Stream { name: name.to_owned(), stamps_ns: stamps.into_iter().flatten().collect(), columns },
            written,
        ))
    }
}

/// Problem and remedy if only the phone's estimate without gravity exists.
pub(super) const WITHOUT_GRAVITY: (&str, &str) = (
    "its accelerometer is without gravity, which is an estimate of the phone and no measurement",
    "record the total acceleration or the uncalibrated accelerometer (in phyphox: \"Acceleration with g\"), and the gyroscope",
);

/// Channels of a single file of Sensor Logger, recognised by its header; the sensor follows from its name, or for an
/// accelerometer from gravity. `None` if it is no such file.
pub(super) fn one_of(path: &Path, table: &Table) -> Option<Result<Found, RecordingError>> {
    let column = |name: &str| table.columns.iter().find(|column| column.name == name);
    let _ = (column("time")?, column("seconds_elapsed")?);
    let triad = [column("x")?, column("y")?, column("z")?];
    let name = path.file_name()?.to_string_lossy();
    let name = name.split_once('.').map_or(&*name, |(name, _)| name);
    let stem = stem(&format!("{name}.csv"))?;
    let values = triad.map(|column| column.values.as_slice());
    let (sensor, by) = match Sensor::of_stem(&stem) {
        Some(Sensor::Accelerometer) if PLAIN_ACCELEROMETERS.contains(&stem.as_str()) => {
            let (is, help) = WITHOUT_GRAVITY;
            return Some(Err(RecordingError::OtherFormat { path: path.to_owned(), is: is.to_owned(), help }));
        }
        Some(sensor) => (sensor, "name"),
        None if force_unit(values).is_some() => (Sensor::Accelerometer, "gravity"),
        None => {
            let map = |targets: [&str; 3], unit: &str| {
                let clock = std::iter::once("t_s=seconds_elapsed:s".to_owned());
                let axes = targets.iter().zip(["x", "y", "z"]);
                clock.chain(axes.map(|(target, axis)| format!("{target}={axis}:{unit}"))).collect()
            };
            return Some(Err(RecordingError::Undecided {
                path: path.to_owned(),
                problem: "a file of Sensor Logger whose name and values do not show its sensor: x, y and z may be a gyroscope or a magnetometer, or an accelerometer without gravity, which is of no use".to_owned(),
                maps: vec![map(GYROS, "rad/s"), map(MAGNETOMETERS, "uT")],
            }));
        }
    };
    let unit = sensor.unit(triad.map(|column| column.values.as_slice()));
    let is_force = sensor == Sensor::Accelerometer;
    let is_turned = is_force && has_sign_of_ios(unit, Platform::Unknown);
    let how = if is_turned { format!("*-1:{unit}") } else { unit.to_owned() };
    let mut entries = vec![("t_s", "seconds_elapsed".to_owned(), "s".to_owned())];
    for (target, column) in sensor.channels().into_iter().zip(triad) {
        entries.push((target, column.name.clone(), how.clone()));
    }
    let sensor_provenance = provenance_of(&stem);
    let sign = match (is_force, is_turned) {
        (true, true) => ", its sign turned so that gravity counts up",
        (true, false) => ", assumed Android (no Metadata.csv; an iPhone's has the other sign)",
        _ => "",
    };
    let assumed = format!("{stem} in {unit}, by its {by}{sign}; seconds_elapsed in s");
    let mut provenance = Provenance::default();
    match sensor {
        Sensor::Accelerometer => provenance.accelerometers = sensor_provenance,
        Sensor::Gyroscope => provenance.gyros = sensor_provenance,
        Sensor::Magnetometer => {}
    }
    Some(Ok(Found {
        format: Format::SensorLogger,
        entries,
        assumed,
        provenance,
        gyro_clock: None,
        counter: None,
    }))
}

/// Phone, by the table of one row in Metadata.csv.
fn platform(input: &mut dyn BufRead) -> Platform {
    let mut text = String::new();
    let read = input.take(1 << 16).read_to_string(&mut text);
    let mut rows = csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
    let names: Vec<String> =
        rows.headers().map(|names| names.iter().map(str::to_lowercase).collect()).unwrap_or_default();
    let row = rows.records().next().and_then(Result::ok).unwrap_or_default();
    let cell = |wanted: &str| names.iter().position(|name| name == wanted).and_then(|at| row.get(at));
    let is_apple = cell("platform").is_some_and(|platform| platform.eq_ignore_ascii_case("ios"));
    let is_standardised =
        cell("standardisation").is_some_and(|descriptions| descriptions.eq_ignore_ascii_case("true"));
    match (read.is_ok() && cell("platform").is_some(), is_apple && !is_standardised) {
        (false, _) => Platform::Unknown,
        (true, true) => Platform::Ios,
        (true, false) => Platform::Android,
    }
}

fn first_line(_: &Path, input: &mut dyn BufRead) -> Result<String, RecordingError> {
    let mut line = Vec::new();
    let read = input.take(1 << 16).read_until(b'\n', &mut line);
    Ok(read.map(|_| String::from_utf8_lossy(&line).into_owned()).unwrap_or_default())
}
