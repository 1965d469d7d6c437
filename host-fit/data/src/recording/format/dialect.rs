//! Tables with the column names of a known program: channel and unit of each column.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, Values};
use super::super::table::Table;
use super::found::Entry;
use super::{Format, header};
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};
use crate::unit::Unit;

/// Column names of a known program, without the unit, which a header may state in any spelling. A name that ends in `()`
/// matches only with a unit. Matching is case-insensitive.
pub(super) struct Dialect {
    pub(super) format: Format,
    /// Columns that must all exist, of any of these sets.
    marks: &'static [&'static [&'static str]],
    /// Channels, their columns, and the part after the column in an entry of a column map: arithmetic, and the unit if
    /// the header states none.
    columns: &'static [(&'static [&'static str], &'static [&'static str], &'static str)],
    /// Column of separate timestamps of the gyros.
    pub(super) gyro_clock: Option<&'static str>,
    /// Assumptions other than the units.
    assumed: &'static str,
    /// Corrections in the values; empty if they are raw, `None` if the program does not state any.
    corrected_by: Option<&'static str>,
    frame: Frame,
    /// Reason for rejecting it, and data to record instead.
    pub(super) refused: Option<(&'static str, &'static str)>,
}

/// Defaults of a dialect.
const PLAIN: Dialect = Dialect {
    format: Format::Log,
    marks: &[],
    columns: &[],
    gyro_clock: None,
    assumed: "",
    corrected_by: None,
    frame: Frame::Unstated,
    refused: None,
};

/// Phones subtract their bias estimate from the output of TYPE_ACCELEROMETER and TYPE_GYROSCOPE (Android), and from the
/// data that Core Motion fuses (iOS).
pub(super) const PHONE: &str = "the phone (factory calibration and its own bias estimate)";

/// Android's uncalibrated sensors are after factory calibration and temperature compensation (docs/phone.md).
pub(super) const PHONE_FACTORY: &str = "the phone's factory calibration";

const DIALECTS: &[Dialect] = &[
    Dialect {
        format: Format::Euroc,
        marks: &[&["timestamp", "w_RS_S_x", "a_RS_S_x"]],
        columns: &[
            (&["t_s"], &["timestamp"], "ns"),
            (&GYROS, &["w_RS_S_x", "w_RS_S_y", "w_RS_S_z"], "rad/s"),
            (&ACCELEROMETERS, &["a_RS_S_x", "a_RS_S_y", "a_RS_S_z"], "m/s2"),
        ],
        assumed: "with gravity",
        corrected_by: Some(""),
        frame: Frame::Sensor,
        ..PLAIN
    },
    Dialect {
        format: Format::Kalibr,
        marks: &[&["timestamp", "omega_x", "alpha_x"]],
        columns: &[
            (&["t_s"], &["timestamp"], "ns"),
            (&GYROS, &["omega_x", "omega_y", "omega_z"], "rad/s"),
            (&ACCELEROMETERS, &["alpha_x", "alpha_y", "alpha_z"], "m/s2"),
        ],
        assumed: "alpha is specific force, with gravity",
        ..PLAIN
    },
    Dialect {
        format: Format::SensorLog,
        marks: &[&["accelerometerTimestamp_sinceReboot", "accelerometerAccelerationX"]],
        columns: &[
            (&["t_s"], &["accelerometerTimestamp_sinceReboot"], "s"),
            (
                &ACCELEROMETERS,
                &["accelerometerAccelerationX", "accelerometerAccelerationY", "accelerometerAccelerationZ"],
                "*-1:g",
            ),
            (&GYROS, &["gyroRotationX", "gyroRotationY", "gyroRotationZ"], "rad/s"),
        ],
        gyro_clock: Some("gyroTimestamp_sinceReboot"),
        assumed: "the accelerometers' sign turned so that gravity counts up; each sensor has its own timestamps since reboot",
        corrected_by: Some(""),
        frame: Frame::Phone,
        ..PLAIN
    },
    Dialect {
        format: Format::SensorLog,
        marks: &[&["motionUserAccelerationX"]],
        refused: Some((
            "it holds the fused motion… columns of SensorLog alone, which are without bias and gravity",
            "switch on \"Accelerometer\" and \"Gyroscope\" in its settings, and record again",
        )),
        ..PLAIN
    },
    Dialect {
        format: Format::StTools,
        marks: &[&["timestamp ()", "A_X ()"]],
        columns: &[
            (&["t_s"], &["timestamp ()"], ""),
            (&ACCELEROMETERS, &["A_X ()", "A_Y ()", "A_Z ()"], ""),
            (&GYROS, &["G_X ()", "G_Y ()", "G_Z ()"], ""),
            (&MAGNETOMETERS, &["M_X ()", "M_Y ()", "M_Z ()"], ""),
            (&["temp_c"], &["T ()"], ""),
        ],
        assumed: "with gravity",
        corrected_by: Some(""),
        frame: Frame::Sensor,
        ..PLAIN
    },
    Dialect {
        format: Format::PhysicsToolbox,
        marks: &[&["time", "gFx", "gFy", "gFz"]],
        columns: &[
            (&["t_s"], &["time"], "s"),
            (&ACCELEROMETERS, &["gFx", "gFy", "gFz"], "g"),
            (&GYROS, &["wx", "wy", "wz"], "rad/s"),
        ],
        assumed: "gFx … with gravity; ax, ay, az are without gravity and left alone",
        corrected_by: Some(PHONE),
        frame: Frame::Phone,
        ..PLAIN
    },
    Dialect {
        format: Format::AndroSensor,
        marks: &[&["ACCELEROMETER X ()", "Time since start"]],
        columns: &[
            (&["t_s"], &["Time since start"], "ms"),
            (&ACCELEROMETERS, &["ACCELEROMETER X ()", "ACCELEROMETER Y ()", "ACCELEROMETER Z ()"], "m/s2"),
            (&GYROS, &["GYROSCOPE X ()", "GYROSCOPE Y ()", "GYROSCOPE Z ()"], "rad/s"),
            (&MAGNETOMETERS, &["MAGNETIC FIELD X ()", "MAGNETIC FIELD Y ()", "MAGNETIC FIELD Z ()"], "uT"),
        ],
        assumed: "with gravity; rows are written at a rate of their own; GRAVITY and LINEAR ACCELERATION are estimates and left alone",
        corrected_by: Some(PHONE),
        frame: Frame::Phone,
        ..PLAIN
    },
    Dialect {
        format: Format::Phyphox,
        marks: &[&["Time ()", "Acceleration x ()"], &["Time ()", "Gyroscope x ()"]],
        columns: &[
            (&["t_s"], &["Time ()"], "s"),
            (&ACCELEROMETERS, &["Acceleration x ()", "Acceleration y ()", "Acceleration z ()"], "m/s2"),
            (&GYROS, &["Gyroscope x ()", "Gyroscope y ()", "Gyroscope z ()"], "rad/s"),
        ],
        assumed: "with gravity",
        corrected_by: Some(PHONE),
        frame: Frame::Phone,
        ..PLAIN
    },
    Dialect {
        format: Format::SensorLogger,
        marks: &[&["version", "device name", "platform", "sensors"]],
        refused: Some((
            "it is Metadata.csv of Sensor Logger, which describes a recording and holds no samples",
            "name the folder that it lies in, or the file of a sensor, as Gyroscope.csv",
        )),
        ..PLAIN
    },
    Dialect {
        format: Format::Phyphox,
        marks: &[&["Time ()", "Linear Acceleration x ()"]],
        refused: Some((
            "it holds acceleration without g of phyphox alone, which is an estimate of the phone",
            "record \"Acceleration with g\" and \"Gyroscope\" instead",
        )),
        ..PLAIN
    },
];

/// Returns true if a column matches a pattern.
pub(super) fn is_named(column: &str, pattern: &str) -> bool {
    let (name, unit) = header::split(column);
    match pattern.strip_suffix(" ()") {
        Some(with_unit) => unit.is_some() && name.eq_ignore_ascii_case(with_unit),
        // the unit of some names is a part of them: `time in ms` is no `time`
        None => name.eq_ignore_ascii_case(pattern),
    }
}

impl Dialect {
    /// Dialect of a table, or the one of `format`, if the table matches it.
    pub(super) fn of(table: &Table, format: Option<Format>) -> Option<&'static Self> {
        let text = &table.quality.text_columns;
        let has = |pattern: &&str| {
            table.columns.iter().map(|column| &column.name).chain(text).any(|name| is_named(name, pattern))
        };
        DIALECTS
            .iter()
            .filter(|dialect| format.is_none_or(|format| dialect.format == format))
            .find(|dialect| dialect.marks.iter().any(|marks| marks.iter().all(has)))
    }

    /// Channel, column, and the part after it, of every column.
    fn columns(&self) -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
        self.columns.iter().flat_map(|&(targets, columns, how)| {
            targets.iter().zip(columns).map(move |(target, column)| (*target, *column, how))
        })
    }

    /// Channel, column, arithmetic and unit of the columns of a table. A unit stated in the header takes precedence; an
    /// unreadable one is refused unless the user maps or ignores the column.
    pub(super) fn entries(
        &self,
        path: &Path,
        table: &Table,
        options: &LoadOptions,
    ) -> Result<Vec<Entry>, RecordingError> {
        let mut entries = Vec::new();
        for (target, pattern, how) in self.columns() {
            let Some(column) = table.columns.iter().find(|column| is_named(&column.name, pattern)) else {
                continue;
            };
            if options.columns.column_of(target) != target || options.columns.ignores(&column.name) {
                continue;
            }
            let (arithmetic, default) = match how.rsplit_once(':') {
                Some((arithmetic, unit)) => (Some(arithmetic), unit),
                None => (None, how),
            };
            let unit = header::unit_of(path, &column.name, target, default)?;
            let how = arithmetic.map_or_else(|| unit.to_owned(), |chain| format!("{chain}:{unit}"));
            entries.push((target, column.name.clone(), how));
        }
        Ok(entries)
    }

    /// Assumptions, with the units in which the columns are read.
    pub(super) fn assumed(&self, entries: &[Entry]) -> String {
        let mut units: Vec<(&str, Vec<&str>)> = Vec::new();
        for (target, _, how) in entries {
            let name = match Unit::of_column(target) {
                Unit::Second => "time",
                Unit::MetrePerSecondSquared => "accelerometers",
                Unit::RadianPerSecond => "gyros",
                Unit::Microtesla => "magnetometers",
                _ => "temperature",
            };
            let unit = how.rsplit_once(':').map_or(how.as_str(), |(_, unit)| unit);
            match units.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) if known.contains(&unit) => {}
                Some((_, known)) => known.push(unit),
                None => units.push((name, vec![unit])),
            }
        }
        let units: Vec<String> =
            units.into_iter().map(|(name, units)| format!("{name} in {}", units.join(" and "))).collect();
        format!("{}; {}", units.join(", "), self.assumed)
    }

    /// Column of the timestamps, if the dialect defines one.
    pub(super) fn clock(&self) -> Option<&'static str> {
        self.columns().find(|(target, ..)| *target == "t_s").map(|(_, pattern, _)| pattern)
    }

    /// Corrections and frame of the values.
    pub(super) fn provenance(&self) -> Provenance {
        let values = match self.corrected_by {
            None => Values::Unstated,
            Some("") => Values::Raw,
            Some(by) => Values::Corrected(by.into()),
        };
        Provenance::of_both(values, self.frame)
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::super::{Recording, load};
    use super::*;

    /// Spellings in headers, and SI per unit; by the definitions of the units, independent of the table under test.
    fn spellings(unit: Unit) -> &'static [(&'static str, f64)] {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        match unit {
            Unit::Second => &[
                ("s", 1.0),
                ("ms", 1e-3),
                ("us", 1e-6),
                ("µs", 1e-6),
                ("\u{3bc}s", 1e-6),
                ("ns", 1e-9),
                ("seconds", 1.0),
            ],
            Unit::MetrePerSecondSquared => &[
                ("m/s^2", 1.0),
                ("m/s²", 1.0),
                ("m s^-2", 1.0),
                ("m/sÂ²", 1.0),
                ("g", 9.80665),
                ("G", 9.80665),
                ("mg", 9.80665e-3),
            ],
            Unit::RadianPerSecond => &[
                ("rad/s", 1.0),
                ("rad s^-1", 1.0),
                ("deg/s", DEGREE),
                ("deg s^-1", DEGREE),
                ("°/s", DEGREE),
                ("dps", DEGREE),
                ("mdps", DEGREE * 1e-3),
            ],
            Unit::Microtesla => &[("µT", 1.0), ("uT", 1.0), ("mgauss", 0.1), ("gauss", 100.0), ("mT", 1e3)],
            _ => &[("°C", 1.0), ("degC", 1.0)],
        }
    }

    /// True value of a channel in a row, in SI units.
    fn truth(target: &str, row: usize) -> f64 {
        let n = row as f64;
        let wave = (0.7 * n + target.len() as f64).sin();
        match target {
            "t_s" => 10.0 + 0.005 * n,
            "az_mps2" => 9.7 + 0.01 * wave,
            "temp_c" => 25.0 + 0.01 * n,
            _ if target.starts_with("mag") => 30.0 + wave,
            _ => 0.2 + 0.01 * wave,
        }
    }

    /// A file of a dialect in which columns of `kind` state `spelling` and hold the truth in `per_unit`; the others are
    /// as the program writes them.
    fn file(dialect: &Dialect, kind: Unit, spelling: &str, per_unit: f64, brackets: [char; 2]) -> String {
        const ROWS: usize = 200;
        let clock = dialect.gyro_clock.map(|clock| ("t_s", clock, "s"));
        let columns: Vec<_> = dialect.columns().chain(clock).collect();
        let mut scales = Vec::new();
        let mut headers = Vec::new();
        for (target, pattern, how) in &columns {
            let unit = Unit::of_column(target);
            let (arithmetic, default) = how.rsplit_once(':').unwrap_or(("", how));
            let name = pattern.trim_end_matches(" ()");
            let (stated, scale) = if unit == kind {
                (Some(spelling), per_unit)
            } else {
                let scale = crate::unit::parse_unit(default).map_or(1.0, |(_, to_si)| to_si.scale);
                // those that state their unit in every file
                let is_stated = name != *pattern;
                (is_stated.then(|| spellings(unit)[0].0), if is_stated { 1.0 } else { scale })
            };
            scales.push(if arithmetic == "*-1" { -scale } else { scale });
            headers.push(match stated {
                Some(stated) => format!("{name} {}{stated}{}", brackets[0], brackets[1]),
                None => name.to_owned(),
            });
        }
        let mut text = headers.join(",");
        for row in 0..ROWS {
            let cells = columns.iter().zip(&scales);
            let cells: Vec<String> =
                cells.map(|((target, ..), scale)| format!("{:?}", truth(target, row) / scale)).collect();
            write!(text, "\n{}", cells.join(",")).unwrap();
        }
        text
    }

    /// First channel of a dialect with wrong values.
    fn first_wrong(dialect: &Dialect, recording: &Recording) -> Option<&'static str> {
        let is_right = |target: &str| {
            let values: &[f64] = match target {
                "t_s" => &recording.time_s,
                _ => &recording.channel(target).ok()?.values,
            };
            let same = |(row, value): (usize, &f64)| (value / truth(target, row) - 1.0).abs() < 1e-9;
            Some(values.iter().enumerate().all(same))
        };
        dialect.columns().map(|(target, ..)| target).find(|target| is_right(target) != Some(true))
    }

    fn read(folder: &Path, text: &str) -> Result<Recording, String> {
        let path = folder.join("log.csv");
        std::fs::write(&path, text).unwrap();
        load(&path, &LoadOptions::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn reads_the_unit_that_a_header_states_in_every_dialect() {
        let folder = tempfile::tempdir().unwrap();
        let (mut stated, mut refused) = (0, 0);
        for dialect in DIALECTS.iter().filter(|dialect| dialect.refused.is_none()) {
            let mut kinds: Vec<Unit> = Vec::new();
            for (target, ..) in dialect.columns() {
                let kind = Unit::of_column(target);
                if !kinds.contains(&kind) {
                    kinds.push(kind);
                }
            }
            for kind in kinds {
                for (spelling, per_unit) in spellings(kind) {
                    for brackets in [['[', ']'], ['(', ')']] {
                        let text = file(dialect, kind, spelling, *per_unit, brackets);
                        let what = format!("{:?} in {spelling} {brackets:?}", dialect.format);
                        let recording =
                            read(folder.path(), &text).unwrap_or_else(|error| panic!("{what}: {error}"));
                        let read_as = recording.sources[0].read_as.as_ref().unwrap();
                        assert_eq!(read_as.format, dialect.format, "{what}");
                        assert_eq!(first_wrong(dialect, &recording), None, "{what}");
                        let mut targets = dialect.columns().map(|(target, ..)| target);
                        let target = targets.find(|target| Unit::of_column(target) == kind);
                        let unit = header::spelling(spelling, target.unwrap()).unwrap();
                        let unit_text = format!(" in {unit}");
                        assert!(read_as.assumed.contains(&unit_text), "{what}: {}", read_as.assumed);
                        stated += 1;
                    }
                }
                // an unreadable unit is rejected, not taken for another
                let text = file(dialect, kind, "furlong", 1.0, ['[', ']']);
                let error = read(folder.path(), &text).expect_err("a refusal");
                assert!(error.contains("\"furlong\"") && error.contains("column map, as in '"), "{error}");
                refused += 1;
            }
        }
        println!(
            "attack: units in headers | {stated} headers, covering the table of every known program with each unit: values are converted from the unit in the header, and the unit is reported | negative control: {refused} headers with an unknown unit are refused"
        );
    }

    #[test]
    fn detects_values_that_contradict_the_stated_unit() {
        let folder = tempfile::tempdir().unwrap();
        let euroc = DIALECTS.iter().find(|dialect| dialect.format == Format::Euroc).unwrap();
        // the previous rule: the header states µs, the values are ns
        let old = file(euroc, Unit::Second, "us", 1e-9, ['[', ']']);
        match read(folder.path(), &old) {
            Ok(recording) => assert_eq!(first_wrong(euroc, &recording), Some("t_s")),
            Err(error) => assert!(error.contains("another unit") || error.contains("unit"), "{error}"),
        }
        // gravity contradicts a wrong unit: in g, and stated as m/s²
        let error =
            read(folder.path(), &file(euroc, Unit::MetrePerSecondSquared, "m s^-2", 9.80665, ['[', ']']));
        let error = error.expect_err("a contradiction");
        assert!(
            error.contains("in m/s2 by their headers")
                && error.contains("map them: 'ax_mps2=a_RS_S_x [m s^-2]:g'"),
            "{error}"
        );
        // the suggested entry of a column map reads it
        let options = LoadOptions {
            columns: super::super::super::ColumnMap::from_specs(
                error.split('\'').filter(|part| part.starts_with('a') && part.contains("_mps2=")),
            )
            .unwrap(),
            ..LoadOptions::default()
        };
        let recording = load(folder.path().join("log.csv"), &options).unwrap();
        assert_eq!(first_wrong(euroc, &recording), None);
    }
}
