//! Tables whose columns have names that a known program gives them: what each column is, and in what unit.

use super::super::guess::unit_in;
use super::super::table::Table;
use super::Format;
use super::found::Entry;

/// How a known program names its columns. A name that ends in `*` stands for all that begin so; capitals do not count.
pub(super) struct Dialect {
    pub(super) format: Format,
    /// Columns that are all there.
    marks: &'static [&'static str],
    /// Channel, column, and what stands behind the column in an entry of a column map: arithmetic and unit. `[]`: the
    /// unit is the one in the column's name.
    columns: &'static [(&'static str, &'static str, &'static str)],
    /// The stamps of the gyros, where they have their own.
    pub(super) gyro_clock: Option<&'static str>,
    /// What is assumed.
    pub(super) assumed: &'static str,
    /// Why it cannot be used, and what to record instead.
    pub(super) refused: Option<(&'static str, &'static str)>,
}

/// Nothing of a dialect that need not be said.
const PLAIN: Dialect =
    Dialect { format: Format::Log, marks: &[], columns: &[], gyro_clock: None, assumed: "", refused: None };

const DIALECTS: &[Dialect] = &[
    Dialect {
        format: Format::Euroc,
        marks: &["timestamp*", "w_RS_S_x*", "a_RS_S_x*"],
        columns: &[
            ("t_s", "timestamp*", "ns"),
            ("gx_rads", "w_RS_S_x*", "rad/s"),
            ("gy_rads", "w_RS_S_y*", "rad/s"),
            ("gz_rads", "w_RS_S_z*", "rad/s"),
            ("ax_mps2", "a_RS_S_x*", "m/s2"),
            ("ay_mps2", "a_RS_S_y*", "m/s2"),
            ("az_mps2", "a_RS_S_z*", "m/s2"),
        ],
        assumed: "stamps in ns; rad/s and m/s² with gravity in the sensor's frame; not corrected",
        ..PLAIN
    },
    Dialect {
        format: Format::Kalibr,
        marks: &["timestamp", "omega_x", "alpha_x"],
        columns: &[
            ("t_s", "timestamp", "ns"),
            ("gx_rads", "omega_x", "rad/s"),
            ("gy_rads", "omega_y", "rad/s"),
            ("gz_rads", "omega_z", "rad/s"),
            ("ax_mps2", "alpha_x", "m/s2"),
            ("ay_mps2", "alpha_y", "m/s2"),
            ("az_mps2", "alpha_z", "m/s2"),
        ],
        assumed: "stamps in ns; omega in rad/s, alpha is specific force in m/s² with gravity; not corrected",
        ..PLAIN
    },
    Dialect {
        format: Format::SensorLog,
        marks: &["accelerometerTimestamp_sinceReboot(s)", "accelerometerAccelerationX(G)"],
        columns: &[
            ("t_s", "accelerometerTimestamp_sinceReboot(s)", "s"),
            ("ax_mps2", "accelerometerAccelerationX(G)", "*-1:g"),
            ("ay_mps2", "accelerometerAccelerationY(G)", "*-1:g"),
            ("az_mps2", "accelerometerAccelerationZ(G)", "*-1:g"),
            ("gx_rads", "gyroRotationX(rad/s)", "rad/s"),
            ("gy_rads", "gyroRotationY(rad/s)", "rad/s"),
            ("gz_rads", "gyroRotationZ(rad/s)", "rad/s"),
        ],
        gyro_clock: Some("gyroTimestamp_sinceReboot(s)"),
        assumed: "each sensor by its own stamps since reboot; g with the sign turned, so that gravity counts up; rad/s; not corrected",
        ..PLAIN
    },
    Dialect {
        format: Format::SensorLog,
        marks: &["motionUserAccelerationX(G)"],
        refused: Some((
            "it holds the fused motion… columns of SensorLog alone, which are without bias and gravity",
            "switch on \"Accelerometer\" and \"Gyroscope\" in its settings, and record again",
        )),
        ..PLAIN
    },
    Dialect {
        format: Format::StTools,
        marks: &["timestamp [*", "A_X [*"],
        columns: &[
            ("t_s", "timestamp [*", "[]"),
            ("ax_mps2", "A_X [*", "[]"),
            ("ay_mps2", "A_Y [*", "[]"),
            ("az_mps2", "A_Z [*", "[]"),
            ("gx_rads", "G_X [*", "[]"),
            ("gy_rads", "G_Y [*", "[]"),
            ("gz_rads", "G_Z [*", "[]"),
            ("mag_x_ut", "M_X [*", "[]"),
            ("mag_y_ut", "M_Y [*", "[]"),
            ("mag_z_ut", "M_Z [*", "[]"),
            ("temp_c", "T [*", "[]"),
        ],
        assumed: "units as in the header; the sensor's frame, with gravity; not corrected",
        ..PLAIN
    },
    Dialect {
        format: Format::PhysicsToolbox,
        marks: &["time", "gFx", "gFy", "gFz"],
        columns: &[
            ("t_s", "time", "s"),
            ("ax_mps2", "gFx", "g"),
            ("ay_mps2", "gFy", "g"),
            ("az_mps2", "gFz", "g"),
            ("gx_rads", "wx", "rad/s"),
            ("gy_rads", "wy", "rad/s"),
            ("gz_rads", "wz", "rad/s"),
        ],
        assumed: "time in s; gFx … in g with gravity, wx … in rad/s; ax, ay, az are without gravity and left alone; not corrected beyond what the phone does itself",
        ..PLAIN
    },
    Dialect {
        format: Format::AndroSensor,
        marks: &["ACCELEROMETER X (*", "Time since start in ms*"],
        columns: &[
            ("t_s", "Time since start in ms*", "ms"),
            ("ax_mps2", "ACCELEROMETER X (*", "m/s2"),
            ("ay_mps2", "ACCELEROMETER Y (*", "m/s2"),
            ("az_mps2", "ACCELEROMETER Z (*", "m/s2"),
            ("gx_rads", "GYROSCOPE X (*", "rad/s"),
            ("gy_rads", "GYROSCOPE Y (*", "rad/s"),
            ("gz_rads", "GYROSCOPE Z (*", "rad/s"),
            ("mag_x_ut", "MAGNETIC FIELD X (*", "uT"),
            ("mag_y_ut", "MAGNETIC FIELD Y (*", "uT"),
            ("mag_z_ut", "MAGNETIC FIELD Z (*", "uT"),
        ],
        assumed: "time in ms; m/s² with gravity, rad/s; rows are written at a rate of their own; GRAVITY and LINEAR ACCELERATION are estimates and left alone; not corrected beyond what the phone does itself",
        ..PLAIN
    },
    Dialect {
        format: Format::Phyphox,
        marks: &["Time (s)", "Acceleration x (m/s^2)"],
        columns: PHYPHOX,
        assumed: PHYPHOX_ASSUMED,
        ..PLAIN
    },
    Dialect {
        format: Format::Phyphox,
        marks: &["Time (s)", "Gyroscope x (rad/s)"],
        columns: PHYPHOX,
        assumed: PHYPHOX_ASSUMED,
        ..PLAIN
    },
    Dialect {
        format: Format::Phyphox,
        marks: &["Time (s)", "Linear Acceleration x (m/s^2)"],
        refused: Some((
            "it holds acceleration without g of phyphox alone, which is an estimate of the phone",
            "record \"Acceleration with g\" and \"Gyroscope\" instead",
        )),
        ..PLAIN
    },
];

const PHYPHOX: &[(&str, &str, &str)] = &[
    ("t_s", "Time (s)", "s"),
    ("ax_mps2", "Acceleration x (m/s^2)", "m/s2"),
    ("ay_mps2", "Acceleration y (m/s^2)", "m/s2"),
    ("az_mps2", "Acceleration z (m/s^2)", "m/s2"),
    ("gx_rads", "Gyroscope x (rad/s)", "rad/s"),
    ("gy_rads", "Gyroscope y (rad/s)", "rad/s"),
    ("gz_rads", "Gyroscope z (rad/s)", "rad/s"),
];

const PHYPHOX_ASSUMED: &str = "time in s since the start; m/s² with gravity, rad/s, in the phone's frame; not corrected beyond what the phone does itself";

/// Whether a column is the one of a pattern.
pub(super) fn is_named(column: &str, pattern: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(begin) => column.get(..begin.len()).is_some_and(|column| column.eq_ignore_ascii_case(begin)),
        None => column.eq_ignore_ascii_case(pattern),
    }
}

impl Dialect {
    /// The dialect that a table is in, or the one of `format`, if it is in that.
    pub(super) fn of(table: &Table, format: Option<Format>) -> Option<&'static Self> {
        let text = &table.quality.text_columns;
        let has = |pattern: &&str| {
            table.columns.iter().map(|column| &column.name).chain(text).any(|name| is_named(name, pattern))
        };
        DIALECTS
            .iter()
            .filter(|dialect| format.is_none_or(|format| dialect.format == format))
            .find(|dialect| dialect.marks.iter().all(has))
    }

    /// Channel, column, arithmetic and unit of what a table has.
    pub(super) fn entries(&self, table: &Table) -> Vec<Entry> {
        let find = |pattern: &str| table.columns.iter().find(|column| is_named(&column.name, pattern));
        let entry = |(target, pattern, how): &(&'static str, &str, &str)| {
            let column = find(pattern)?.name.clone();
            let how = match *how {
                "[]" => unit_in(&column, target)?,
                how => how,
            };
            Some((*target, column, how.to_owned()))
        };
        self.columns.iter().filter_map(entry).collect()
    }

    /// The column of the stamps, if the dialect says which one it is.
    pub(super) fn clock(&self) -> Option<&'static str> {
        self.columns.iter().find(|(target, ..)| *target == "t_s").map(|(_, pattern, _)| *pattern)
    }
}
