//! Ambiguous logs: with several candidates the choice is reported, or the log rejected. Two devices are never mixed,
//! and no choice of the user is ignored.

use std::fs;

use fos_data::recording::{ColumnMap, Format, LoadOptions, Recording, RecordingError, load, write_columns};
use fos_testkit::foreign::{Chunks, Flight, Publisher, TEXTS, bag, bag_of, files, mcap_of, ulog_of, zip};
use tempfile::TempDir;

fn read(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Recording, RecordingError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path, options)
}

fn topic(name: &str) -> LoadOptions {
    LoadOptions { topic: Some(name.to_owned()), ..LoadOptions::default() }
}

fn map(specs: &[&str]) -> LoadOptions {
    LoadOptions { columns: ColumnMap::from_specs(specs).unwrap(), ..LoadOptions::default() }
}

/// Bias of the gyro of the second device, rad/s: far above the noise of both.
const BIAS: f32 = 0.5;

/// A log with samples of two devices, and the option that chooses each; `None` without a choice.
struct Mixed {
    name: &'static str,
    bytes: Vec<u8>,
    choices: Option<[&'static str; 2]>,
}

fn mixed() -> Vec<Mixed> {
    let one = Flight::new(1000, 5000, 1);
    let other = one.of_another(2100, BIAS);
    let on =
        |connection: u16, frame: &'static str, flight| Publisher { topic: "/imu", connection, frame, flight };
    let named = [on(0, "left", &one), on(1, "right", &other)];
    let in_one_channel = [on(0, "left", &one), on(0, "right", &other)];
    let alike = [on(0, "imu", &one), on(1, "imu", &other)];
    let nameless = [on(0, "imu", &one), on(0, "imu", &other)];
    let by_frame = Some(["/imu@left", "/imu@right"]);
    let by_number = Some(["/imu@1", "/imu@2"]);
    let accel = ("sensor_accel", 0, 0x1_0001, &one);
    let in_flight = one.of_another(5_000_000, BIAS);
    let phone = |flight: &Flight| {
        let row = |sample: usize| {
            let [x, y, z] = flight.rate[sample].map(f64::from);
            let us = flight.stamps_us[sample];
            format!("{},{},{z},{y},{x}\n", us * 1000, (us - flight.stamps_us[0]) as f64 / 1e6)
        };
        let rows: String = (0..flight.len()).map(row).collect();
        format!("time,seconds_elapsed,z,y,x\n{rows}")
    };
    let (first, second) = (phone(&one), phone(&other));
    let kalibr = |flight: &Flight| {
        let write = TEXTS.iter().find(|(id, ..)| *id == "kalibr").unwrap().2;
        write(flight)
    };
    vec![
        Mixed { name: "frames.bag", bytes: bag_of(&named), choices: by_frame },
        Mixed { name: "connections.bag", bytes: bag_of(&alike), choices: by_number },
        Mixed { name: "one_connection.bag", bytes: bag_of(&nameless), choices: None },
        Mixed { name: "frames.mcap", bytes: mcap_of(&in_one_channel), choices: by_frame },
        Mixed { name: "channels.mcap", bytes: mcap_of(&alike), choices: by_number },
        Mixed { name: "one_channel.mcap", bytes: mcap_of(&nameless), choices: None },
        Mixed {
            name: "interleaved.ulg",
            bytes: ulog_of(&[
                accel,
                ("sensor_gyro", 0, 0x1_0001, &one),
                ("sensor_gyro", 0, 0x2_0001, &other),
            ]),
            choices: Some(["0@65537", "0@131073"]),
        },
        Mixed {
            name: "replaced.ulg",
            bytes: ulog_of(&[("sensor_gyro", 0, 0x1_0001, &one), ("sensor_gyro", 0, 0x2_0001, &in_flight)]),
            choices: Some(["0@65537", "0@131073"]),
        },
        Mixed {
            name: "folders.zip",
            bytes: zip(&[
                ("rec1/TotalAcceleration.csv", first.as_bytes()),
                ("rec1/Gyroscope.csv", first.as_bytes()),
                ("rec2/TotalAcceleration.csv", first.as_bytes()),
                ("rec2/GyroscopeUncalibrated.csv", second.as_bytes()),
            ]),
            choices: Some(["rec1", "rec2"]),
        },
        Mixed {
            name: "kalibr.zip",
            bytes: zip(&[("imu0.csv", &kalibr(&one)), ("imu1.csv", &kalibr(&other))]),
            choices: Some(["imu0", "imu1"]),
        },
        Mixed {
            name: "columns.csv",
            bytes: {
                let pairs = one.rate.iter().zip(&other.rate).enumerate();
                let rows = pairs.map(|(n, (a, b))| format!("{},{},{}\n", n * 5, a[0], b[0]));
                format!("time_ms,imu0_gyro_x_rads,imu1_gyro_x_rads\n{}", rows.collect::<String>())
                    .into_bytes()
            },
            choices: None,
        },
        Mixed {
            name: "rows.csv",
            bytes: {
                let of = |flight: &Flight| -> Vec<(u64, f32)> {
                    flight.stamps_us.iter().copied().zip(flight.rate.iter().map(|rate| rate[0])).collect()
                };
                let mut rows = [of(&one), of(&other)].concat();
                rows.sort_by_key(|row| row.0);
                let rows = rows.iter().map(|(us, rate)| format!("{},{rate}\n", *us as f64 / 1e6));
                format!("t_s,gx_rads\n{}", rows.collect::<String>()).into_bytes()
            },
            choices: None,
        },
    ]
}

/// Device that all samples of the gyro belong to; `None` if they are a mix.
fn device_of(recording: &Recording) -> Option<usize> {
    let values = &recording.channel("gx_rads").unwrap().values;
    let is_second = |value: &f64| *value > f64::from(BIAS) / 2.0;
    let seconds = values.iter().filter(|value| is_second(value)).count();
    match seconds {
        0 => Some(0),
        all if all == values.len() => Some(1),
        _ => None,
    }
}

/// Description of a wrong treatment of a mixed log.
fn mixes(log: &Mixed, read: impl Fn(&LoadOptions) -> Result<Recording, RecordingError>) -> Option<String> {
    match read(&LoadOptions::default()) {
        Ok(recording) => return Some(format!("{}: read as device {:?}", log.name, device_of(&recording))),
        Err(error) if !error.to_string().contains("\nhelp: ") => {
            return Some(format!("{}: {error}", log.name));
        }
        Err(error) => {
            let message = error.to_string();
            if let Some(missing) = log.choices.into_iter().flatten().find(|choice| !message.contains(choice))
            {
                return Some(format!("{}: does not say {missing}: {message}", log.name));
            }
        }
    }
    for (device, choice) in log.choices.into_iter().flatten().enumerate() {
        match read(&topic(choice)) {
            Ok(recording) if device_of(&recording) == Some(device) => {}
            Ok(_) => return Some(format!("{}: {choice} is another device or a mix", log.name)),
            Err(error) => return Some(format!("{}: {choice}: {error}", log.name)),
        }
    }
    None
}

#[test]
fn reads_no_mix_of_two_devices() {
    let logs = mixed();
    let found: Vec<String> =
        logs.iter().filter_map(|log| mixes(log, |options| read(log.name, &log.bytes, options))).collect();
    assert_eq!(found, [""; 0]);
    println!(
        "attack: mixing devices | {} logs with samples of two devices (topics, frames, instances, chips, folders, alternating rows): each is refused with the list of choices; none is interleaved | negative control: a reader that interleaves is detected in {} logs",
        logs.len(),
        logs.iter().filter(|log| mixes(log, |_| interleaved()).is_some()).count(),
    );
}

/// Alternating samples of two devices as if from one, as they used to be read.
fn interleaved() -> Result<Recording, RecordingError> {
    let one = Flight::new(1000, 5000, 1);
    let both: Vec<f64> =
        one.rate.iter().flat_map(|rate| [f64::from(rate[0]), f64::from(rate[0] + BIAS)]).collect();
    let rows: String =
        both.iter().enumerate().map(|(n, rate)| format!("{},{rate}\n", n as f64 / 400.0)).collect();
    let table = format!("t_s,gx_rads\n{rows}");
    read("a.csv", table.as_bytes(), &LoadOptions::default())
}

#[test]
fn check_detects_a_mix() {
    assert_eq!(device_of(&interleaved().unwrap()), None);
    assert!(mixed().iter().all(|log| mixes(log, |_| interleaved()).is_some()));
}

#[test]
fn reads_unambiguous_single_devices() {
    let one = Flight::new(1000, 5000, 1);
    // a restarted publisher is one device
    let mut again = one.clone();
    again.stamps_us.iter_mut().for_each(|us| *us += 10_000_000);
    let on = |connection, flight| Publisher { topic: "/imu", connection, frame: "imu", flight };
    let restarted = read("a.bag", &bag_of(&[on(0, &one), on(1, &again)]), &LoadOptions::default()).unwrap();
    assert_eq!(restarted.n_rows(), 2000);
    // timestamps rounded to a millisecond alternate at 400 Hz, and are of one device
    let mut rounded = Flight::new(1000, 2500, 3);
    rounded.stamps_us.iter_mut().for_each(|us| *us = *us / 1000 * 1000);
    assert_eq!(read("a.mcap", &mcap_of(&[on(0, &rounded)]), &LoadOptions::default()).unwrap().n_rows(), 1000);
    // of two topics with about as many messages, the raw one, in any order
    let other = one.of_another(100, BIAS);
    let at = |topic: &'static str, connection, flight| Publisher { topic, connection, frame: "imu", flight };
    for publishers in [
        [at("/imu/data", 0, &other), at("/imu/data_raw", 1, &one)],
        [at("/imu/data_raw", 0, &one), at("/imu/data", 1, &other)],
    ] {
        let taken = read("a.bag", &bag_of(&publishers), &LoadOptions::default()).unwrap();
        assert_eq!(device_of(&taken), Some(0));
        let message = taken.sources[0].read_as.as_ref().unwrap().assumed.clone();
        assert!(message.starts_with("/imu/data_raw (there are /imu/data too)"), "{message}");
    }
}

#[test]
fn reports_accelerometer_and_gyro_of_different_chips() {
    let one = Flight::new(1000, 5000, 1);
    let other = one.of_another(0, BIAS);
    let [acc, gyr, twin] = [0x1_0001_u32, 0x2_0009, 0x1_0001];
    let log = ulog_of(&[
        ("sensor_accel", 0, acc, &one),
        ("sensor_gyro", 0, gyr, &other),
        ("sensor_gyro", 1, twin, &one),
    ]);
    let message = read("a.ulg", &log, &LoadOptions::default()).unwrap_err().to_string();
    assert!(
        message.contains("sensor_gyro 1 is device 65537") && message.contains("0@65537,131081"),
        "{message}"
    );
    let both = read("a.ulg", &log, &topic("0@65537,131081")).unwrap();
    assert_eq!(device_of(&both), Some(1));
    // if there is no other, the difference is reported
    let only = ulog_of(&[("sensor_accel", 0, acc, &one), ("sensor_gyro", 0, gyr, &other)]);
    let only = read("a.ulg", &only, &LoadOptions::default()).unwrap();
    assert!(only.sources[0].read_as.as_ref().unwrap().assumed.contains("different chips"));
}

#[test]
fn ambiguous_table_offers_working_maps() {
    let axes = |of: &str, unit: &str| format!("{of}_x_{unit},{of}_y_{unit},{of}_z_{unit}");
    let header =
        format!("time_ms,{},{},{}", axes("imu0_gyro", "dps"), axes("imu1_gyro", "dps"), axes("acc", "g"));
    let rows: String = (0..50).map(|n| format!("{},{n},1,2,7{n},5,4,0.0{n},0,1\n", n * 5)).collect();
    let text = format!("{header}\n{rows}");
    let error = read("a.csv", text.as_bytes(), &LoadOptions::default()).unwrap_err();
    let RecordingError::Undecided { maps, .. } = &error else { panic!("{error}") };
    assert_eq!(maps.len(), 2);
    for (specs, first_rads) in maps.iter().zip([0.0_f64, 70.0]) {
        let options =
            LoadOptions { columns: ColumnMap::from_specs(specs).unwrap(), ..LoadOptions::default() };
        let recording = read("a.csv", text.as_bytes(), &options).unwrap();
        assert_eq!(recording.axes().unwrap().len(), 6, "{specs:?}");
        assert!((recording.channel("gx_rads").unwrap().values[0] - first_rads.to_radians()).abs() < 1e-9);
    }
    assert!(error.to_string().contains(&maps[0].join(" ")), "{error}");
}

/// Files of every format, with one recording each.
fn every_format() -> Vec<(String, Vec<u8>)> {
    let flight = Flight::new(500, 5000, 1);
    let mut logs: Vec<(String, Vec<u8>)> =
        files().map(|(_, name, write)| ((*name).to_owned(), write(&flight))).collect();
    let phone = "time,seconds_elapsed,z,y,x\n1,0.0,9.8,0.1,0.2\n2,0.01,9.8,0.1,0.2\n3,0.02,9.8,0.1,0.2\n";
    let folder = TempDir::new().unwrap();
    let parquet = folder.path().join("a.parquet");
    let columns = [("t_s", flight.time_s()), ("gx_rads", vec![0.1; flight.len()])];
    let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (*name, &values[..])).collect();
    write_columns(&parquet, &columns).unwrap();
    logs.extend([
        ("log.parquet".to_owned(), fs::read(&parquet).unwrap()),
        ("named.csv".to_owned(), b"time_ms,gyro_x_dps\n0,1\n5,2\n10,1\n15,3\n".to_vec()),
        ("a.zip".to_owned(), zip(&[("log.csv", flight.csv().as_bytes())])),
        (
            "phone.zip".to_owned(),
            zip(&[("Gyroscope.csv", phone.as_bytes()), ("TotalAcceleration.csv", phone.as_bytes())]),
        ),
        ("Gyroscope.csv".to_owned(), phone.as_bytes().to_vec()),
    ]);
    logs
}

/// Options that cannot have an effect on a file of one recording.
fn without_effect(found: Option<Format>) -> Vec<LoadOptions> {
    let formats = fos_data::recording::KNOWN_FORMATS.iter().map(|known| known.format);
    let others =
        formats.filter(|format| Some(*format) != found && (found.is_some() || *format != Format::Log));
    let mut options: Vec<LoadOptions> =
        others.map(|format| LoadOptions { format: Some(format), ..LoadOptions::default() }).collect();
    options.extend([
        topic("nonsense"),
        map(&["gx_rads=not_there:dps"]),
        map(&["extra=not_there"]),
        map(&["!not_there"]),
    ]);
    options
}

/// Options that a reader accepts and ignores.
fn ignored_options(read: impl Fn(&LoadOptions) -> Result<Recording, RecordingError>) -> Vec<LoadOptions> {
    let recording = read(&LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let found = recording.sources[0].read_as.as_ref().map(|read_as| read_as.format);
    // a table may be readable in another way as well, which then is the requested one
    let is_ignored = |options: &LoadOptions| {
        read(options).is_ok_and(|again| {
            let read_as = again.sources[0].read_as.as_ref().map(|read_as| read_as.format);
            options.format.is_none() || read_as != options.format
        })
    };
    without_effect(found).into_iter().filter(is_ignored).collect()
}

#[test]
fn refuses_options_that_have_no_effect() {
    for (name, bytes) in every_format() {
        let passed = ignored_options(|options| read(&name, &bytes, options));
        assert_eq!(passed, [], "{name}");
    }
    // negative control: a reader that ignores all options
    let flight = Flight::new(500, 5000, 1);
    let deaf = |_: &LoadOptions| read("a.csv", flight.csv().as_bytes(), &LoadOptions::default());
    let passed = ignored_options(deaf).len();
    assert!(passed > 10);
    println!(
        "attack: options without effect | {} files, covering every format: a topic, format, column map or strictness option that would change nothing is refused | negative control: a reader that ignores its options is detected for {passed} options",
        every_format().len(),
    );
}

#[test]
fn topic_option_on_a_table_lists_its_columns() {
    let flight = Flight::new(100, 5000, 1);
    let message = read("a.csv", flight.csv().as_bytes(), &topic("nonsense")).unwrap_err().to_string();
    assert!(
        message.contains("topic \"nonsense\" has no effect") && message.contains("t_s, ax_mps2"),
        "{message}"
    );
}

#[test]
fn strict_refuses_a_damaged_log_of_any_format() {
    let flight = Flight::new(500, 5000, 1);
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let logs = ["flight.ulg", "flight.bin", "flight.mcap", "flight.bag"];
    let mut logs: Vec<_> = files().filter(|(_, name, _)| logs.contains(name)).copied().collect();
    logs.push(("bag", "plain.bag", |flight| bag(flight, Chunks::None)));
    for (_, name, write) in logs {
        let bytes = write(&flight);
        assert!(read(name, &bytes, &strict).is_ok(), "{name}");
        let cut = &bytes[..bytes.len() * 3 / 4 - 5];
        assert!(read(name, cut, &LoadOptions::default()).is_ok(), "{name}");
        assert!(read(name, cut, &strict).is_err(), "{name}");
    }
}

#[test]
fn excludes_an_axis_without_a_number() {
    let rows: String = (0..50).map(|n| format!("{},0.{n},,0.1{n}\n", f64::from(n) * 0.005)).collect();
    let text = format!("t_s,gx_rads,gy_rads,gz_rads\n{rows}");
    let recording = read("a.csv", text.as_bytes(), &LoadOptions::default()).unwrap();
    assert_eq!(recording.axes().unwrap(), ["gx_rads", "gz_rads"]);
    assert!(recording.quality.to_string().contains("gy_rads: every cell is empty"), "{}", recording.quality);
    for name in ["gy", "gy_rads"] {
        let message = recording.axis(name).unwrap_err().to_string();
        assert!(message.contains("gy_rads: every cell of its 50 rows is empty"), "{message}");
    }
    // if named by the user, it remains an error, and so does a log without any
    assert!(read("a.csv", text.as_bytes(), &map(&["gy_rads=gy_rads"])).is_err());
    let none = "t_s,gx_rads\n0,\n0.01,\n0.02,\n0.03,\n";
    let none = read("a.csv", none.as_bytes(), &LoadOptions::default()).unwrap();
    assert!(matches!(none.axes(), Err(RecordingError::NoValues { .. })));
    // an axis whose reference is empty is not treated as a static one
    let reference = "t_s,gx_rads,gy_rads,ref_gx_rads\n0,1,1,\n0.01,2,1,\n0.02,1,2,\n0.03,1,1,\n";
    let reference = read("a.csv", reference.as_bytes(), &LoadOptions::default()).unwrap();
    assert_eq!(reference.axes().unwrap(), ["gy_rads"]);
}
