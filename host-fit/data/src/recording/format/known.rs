//! Documentation of each format.

use serde::Serialize;

use super::names::Format;

/// Description of a format, in words.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FormatKnowledge {
    pub format: Format,
    /// Short name for options.
    pub id: &'static str,
    pub name: &'static str,
    /// Endings or names of its files.
    pub files: &'static str,
    pub read: &'static str,
    /// Units of its values.
    pub units: &'static str,
    /// Raw or corrected, and by what; axes.
    pub values: &'static str,
    pub clock: &'static str,
    /// Source of a temperature.
    pub temperature: &'static str,
    pub traps: &'static str,
    /// Rejected variants, and data to record instead.
    pub refused: &'static str,
}

/// Endings of files that may be logs; `.gz` follows another one. The content decides.
pub const LOG_ENDINGS: &[&str] =
    &[".csv", ".tsv", ".txt", ".gz", ".parquet", ".ulg", ".bin", ".cwa", ".mcap", ".bag", ".zip"];

/// Returns true if a file may be a log, by the ending of its name; case-insensitive.
pub fn may_be_log(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let bare = name.strip_suffix(".gz").unwrap_or(&name);
    LOG_ENDINGS.iter().any(|ending| bare.ends_with(ending))
}

/// Endings that are not searched in a folder or an archive: these files are read out of order.
const NOT_WITHIN: &[&str] = &[".parquet", ".zip"];

/// Returns true if a file of a folder or an archive may be the log in it; any `.gz` may.
pub(super) fn may_be_log_within(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let mut within = LOG_ENDINGS.iter().filter(|ending| !NOT_WITHIN.contains(ending));
    within.any(|ending| name.ends_with(ending))
}

/// Every format, the native one first.
pub const KNOWN_FORMATS: &[FormatKnowledge] = &[
    FormatKnowledge {
        format: Format::Log,
        id: "log",
        name: "the log format",
        files: ".csv, .csv.gz, .parquet",
        read: "every column, by its name: t_s, ax_mps2 … gz_rads, temp_c, supply_v, still, segment",
        units: "SI",
        values: "not stated: taken as raw unless the fit states otherwise",
        clock: "t_s, s; or a stated rate",
        temperature: "temp_c",
        traps: "none known",
        refused: "a table without t_s and without a stated rate",
    },
    FormatKnowledge {
        format: Format::Named,
        id: "named",
        name: "a table that names its units",
        files: ".csv, .csv.gz, .parquet",
        read: "columns whose names state quantity, axis and unit, as gyro_x [mdps] or Acceleration z (m/s^2)",
        units: "those in the names",
        values: "not stated, as in the log format",
        clock: "the column of time, in the unit in its name",
        temperature: "a column of temperature with its unit",
        traps: "a unit that no name states is not guessed: the error lists what to state; of several columns for a channel the one with the shortest name is read, and the others are printed",
        refused: "inertial columns without a unit in their names; two columns that are equally good and differ, a triad from two sensors: the error gives the column maps to choose from",
    },
    FormatKnowledge {
        format: Format::Ulog,
        id: "ulog",
        name: "PX4 ULog",
        files: ".ulg",
        read: "sensor_accel and sensor_gyro, or their FIFO topics; sensor_combined where those are decimated; sensor_mag, system_power, cpuload",
        units: "m/s², rad/s, °C, gauss, V",
        values: "raw, in the axes of the board; those of sensor_combined are corrected by PX4, in the axes of the vehicle",
        clock: "timestamp_sample, µs since boot; one for each sensor",
        temperature: "in sensor_accel, else in sensor_gyro",
        traps: "by default sensor_accel and sensor_gyro are logged once a second, and sensor_combined is integrated and corrected by PX4's own calibration; an instance with several device_ids is refused until one is chosen, as 0@2818058",
        refused: "logs in which no inertial topic reaches 8 Hz: set SDLOG_PROFILE to 769 (default set, FIFO of gyro and accelerometer), or list sensor_accel and sensor_gyro in etc/logging/logger_topics.txt on the SD card",
    },
    FormatKnowledge {
        format: Format::Dataflash,
        id: "dataflash",
        name: "ArduPilot DataFlash",
        files: ".bin, .BIN",
        read: "ACC and GYR, else IMU (of logs up to 2020 also IMU2 and IMU3)",
        units: "m/s², rad/s, °C",
        values: "raw, in the axes of the board, as far as the parameters in the log undo ArduPilot's corrections; the reader lists the corrections that it undid and those that remain",
        clock: "SampleUS, else TimeUS, µs since boot; TimeMS, ms, of logs up to 2014",
        temperature: "T of IMU, Temp of logs up to 2016",
        traps: "values are offset, scaled, temperature-corrected and turned by AHRS_ORIENTATION before they are logged; the parameters in the log say how, and it is undone; batches (ISBH, ISBD) hold one sensor at a time and are not read",
        refused: "logs without any of these: set INS_RAW_LOG_OPT, or the IMU_RAW bit of LOG_BITMASK",
    },
    FormatKnowledge {
        format: Format::Mcap,
        id: "mcap",
        name: "MCAP with ROS 2 messages",
        files: ".mcap, or the folder of a ROS 2 bag",
        read: "the topic of sensor_msgs/msg/Imu with most messages; sensor_msgs/msg/Temperature, sensor_msgs/msg/MagneticField",
        units: "m/s², rad/s, °C, T",
        values: "not stated: a driver may have corrected or filtered",
        clock: "the timestamp in the header, s and ns",
        temperature: "a separate topic",
        traps: "a driver may already have corrected or filtered; a timestamp may be the time of arrival; two devices on one topic are refused until one is chosen, as /imu@frame",
        refused: "messages in another encoding than CDR and that of ROS 1; a bag in SQLite (.db3): convert it by `ros2 bag convert`",
    },
    FormatKnowledge {
        format: Format::Bag,
        id: "bag",
        name: "ROS 1 bag",
        files: ".bag",
        read: "the topic of sensor_msgs/Imu with most messages; sensor_msgs/Temperature, sensor_msgs/MagneticField",
        units: "m/s², rad/s, °C, T",
        values: "not stated: a driver may have corrected or filtered",
        clock: "the timestamp in the header, s and ns",
        temperature: "a separate topic",
        traps: "a driver may already have corrected or filtered; a timestamp may be the time of arrival; two devices on one topic are refused until one is chosen, as /imu@frame",
        refused: "bags of another version than 2.0: convert by `rosbag migrate`",
    },
    FormatKnowledge {
        format: Format::Euroc,
        id: "euroc",
        name: "EuRoC",
        files: "data.csv, or the folder mav0",
        read: "all six axes",
        units: "those in the header, else rad/s, m/s²",
        values: "raw, in the axes of the sensor",
        clock: "in the unit of the header, else ns",
        temperature: "none",
        traps: "the header begins with #, as a comment",
        refused: "nothing that has the columns",
    },
    FormatKnowledge {
        format: Format::Kalibr,
        id: "kalibr",
        name: "Kalibr CSV",
        files: "imu0.csv, or the folder with it",
        read: "omega_x … alpha_z",
        units: "rad/s, m/s²",
        values: "not stated",
        clock: "timestamp, ns",
        temperature: "none",
        traps: "alpha is specific force, not angular acceleration",
        refused: "nothing that has the columns",
    },
    FormatKnowledge {
        format: Format::SensorLogger,
        id: "sensor-logger",
        name: "Sensor Logger",
        files: ".zip or folder, one CSV for each sensor",
        read: "AccelerometerUncalibrated, else TotalAcceleration; GyroscopeUncalibrated, else Gyroscope; the magnetometer",
        units: "m/s², rad/s, µT; g on iOS",
        values: "corrected by the phone; of uncalibrated sensors by its factory calibration alone",
        clock: "time, ns since 1970; one for each sensor",
        temperature: "none",
        traps: "columns stand in the order z, y, x; Accelerometer.csv is without gravity; on iOS the sign of the accelerometer is turned unless it was standardised, which shows in the unit g or in Metadata.csv",
        refused: "Accelerometer.csv alone: record the total acceleration or the uncalibrated accelerometer",
    },
    FormatKnowledge {
        format: Format::Phyphox,
        id: "phyphox",
        name: "phyphox",
        files: ".zip, folder or .csv",
        read: "Acceleration and Gyroscope, one file for each sensor",
        units: "m/s², rad/s, µT",
        values: "corrected by the phone",
        clock: "Time (s) since the start; one for each sensor",
        temperature: "none",
        traps: "the experiment without g subtracts the phone's own estimate of gravity",
        refused: "Linear Acceleration alone: record \"Acceleration with g\"",
    },
    FormatKnowledge {
        format: Format::SensorLog,
        id: "sensorlog",
        name: "SensorLog",
        files: ".csv",
        read: "accelerometerAcceleration and gyroRotation",
        units: "g with the sign turned, rad/s",
        values: "raw, in the axes of the phone",
        clock: "since reboot, s; one for each sensor",
        temperature: "none",
        traps: "rows are written at their own rate and repeat samples; motion… columns are fused and without bias",
        refused: "logs with the motion… columns alone: switch on the accelerometer and the gyroscope",
    },
    FormatKnowledge {
        format: Format::GnssLogger,
        id: "gnsslogger",
        name: "GnssLogger",
        files: ".txt",
        read: "rows UncalAccel, UncalGyro, UncalMag, else Accel, Gyro, Mag",
        units: "m/s², rad/s, µT",
        values: "corrected by the phone; of Uncal rows by its factory calibration alone",
        clock: "elapsedRealtimeNanos; one for each sensor",
        temperature: "none",
        traps: "the columns of the phone's own bias in UncalGyro and UncalAccel are not subtracted",
        refused: "logs without sensors: switch them on in its settings",
    },
    FormatKnowledge {
        format: Format::StTools,
        id: "st",
        name: "ST Unicleo and MEMS Studio",
        files: ".csv, .tsv, .txt",
        read: "A_X … G_Z; T, M_X … M_Z",
        units: "mg, dps, mgauss, °C",
        values: "raw, in the axes of the sensor",
        clock: "Timestamp [us] or Timestamp [ms]",
        temperature: "a column T",
        traps: "a title line stands before the header",
        refused: "nothing that has the columns",
    },
    FormatKnowledge {
        format: Format::PhysicsToolbox,
        id: "physics-toolbox",
        name: "Physics Toolbox",
        files: ".csv",
        read: "gFx … gFz, wx … wz",
        units: "g, rad/s",
        values: "corrected by the phone",
        clock: "time, s since the start",
        temperature: "none",
        traps: "ax, ay, az are linear acceleration, without gravity; the time may be that of day, as text, and is then no clock",
        refused: "logs with ax, ay, az alone: record the g-force meter",
    },
    FormatKnowledge {
        format: Format::AndroSensor,
        id: "androsensor",
        name: "AndroSensor",
        files: ".csv",
        read: "ACCELEROMETER X … GYROSCOPE Z, MAGNETIC FIELD",
        units: "m/s², rad/s, µT",
        values: "corrected by the phone",
        clock: "Time since start in ms",
        temperature: "the ambient one, where the phone has it",
        traps: "rows are written at their own rate; LINEAR ACCELERATION and GRAVITY are estimates",
        refused: "nothing that has the columns",
    },
    FormatKnowledge {
        format: Format::Betaflight,
        id: "betaflight",
        name: "Betaflight blackbox as CSV",
        files: ".csv",
        read: "gyroUnfilt, else gyroADC; accSmooth",
        units: "°/s, g or counts",
        values: "corrected by Betaflight (gyro zero, accelerometer trim), in the axes of the vehicle",
        clock: "time, µs since boot",
        temperature: "none",
        traps: "gyroADC is filtered and both are rounded to 1 °/s; the accelerometer is in counts (scale from gravity)",
        refused: "the binary log: decode it by blackbox_decode",
    },
    FormatKnowledge {
        format: Format::Xsens,
        id: "xsens",
        name: "Xsens and Movella DOT",
        files: ".csv, .txt",
        read: "Acc_X … Gyr_Z of an export, or f_x … w_z of a table of DOT logs; Temperature",
        units: "m/s², °/s; rad/s of MT Manager",
        values: "corrected by the sensor's factory calibration, in the axes of the sensor",
        clock: "SampleTimeFine, which wraps: µs of a DOT, 100 µs of an MTi; or Time, s",
        temperature: "a column Temperature, which a DOT does not export",
        traps: "the magnetic field is in no unit and left alone; FreeAcc is without gravity and left alone",
        refused: "orientations alone: record the payload \"Rate quantities\"; dq and dv alone likewise",
    },
    FormatKnowledge {
        format: Format::GeneActiv,
        id: "geneactiv",
        name: "GENEActiv",
        files: ".bin",
        read: "the three accelerometers of each page",
        units: "counts, converted to m/s² by the gain and offset in the header; °C",
        values: "corrected by the factory gain and offset in the header, in the axes of the sensor",
        clock: "Page Time, local time; samples are spread evenly to the next page",
        temperature: "one for each page of 300 samples, held until the next",
        traps: "there is no gyro; light and button are not read",
        refused: "a header without gain and offset: extract the file again",
    },
    FormatKnowledge {
        format: Format::Axivity,
        id: "axivity",
        name: "Axivity AX3 and AX6",
        files: ".cwa",
        read: "the three accelerometers of each block, and the gyro of an AX6",
        units: "counts, converted to m/s² and rad/s by the scales in each block; °C",
        values: "raw, in the axes of the sensor",
        clock: "the time of each block, local time; samples are spread evenly to the next block",
        temperature: "one for each block of 40 to 120 samples, held until the next",
        traps: "the thermometer is on the board and resolves 0.3 K; light and battery are not read",
        refused: "a log without samples",
    },
];
