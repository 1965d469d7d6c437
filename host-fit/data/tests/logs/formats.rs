//! Logs in foreign formats, written by code independent of the readers, read back as the original measurements.

use std::fs;
use std::path::Path;

use fos_data::recording::{Format, LoadOptions, Recording, load};
use fos_testkit::foreign::{
    Axivity, Chunks, Flight, Rate, TEXTS, axivity, bag, dataflash, dataflash_of_2014, geneactiv, mcap, ulog,
    ulog_of, zip,
};
use tempfile::TempDir;

const SAMPLES: usize = 2000;

fn flight() -> Flight {
    Flight::new(SAMPLES, 5000, 1)
}

fn read_as(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Recording, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path, options).map_err(|error| error.to_string())
}

fn read(name: &str, bytes: &[u8]) -> Recording {
    read_as(name, bytes, &LoadOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn format_of(recording: &Recording) -> (&'static str, String) {
    let read_as = recording.sources[0].read_as.as_ref().expect("another format");
    (read_as.format.id(), read_as.assumed.clone())
}

/// Checks every sample of the available axes to within `tolerance` of its size and `step` of its unit.
fn is_the_flight(recording: &Recording, flight: &Flight, tolerance: f64, step: f64) {
    for (name, expected) in flight.columns() {
        let Ok(channel) = recording.channel(name) else {
            assert_eq!(name, "temp_c", "missing");
            continue;
        };
        if name == "temp_c" && step > 0.0 {
            // of another topic, once a second
            continue;
        }
        assert_eq!(channel.values.len(), expected.len(), "{name}");
        for (row, (found, expected)) in channel.values.iter().zip(&expected).enumerate() {
            let allowed = tolerance * expected.abs() + step;
            assert!((found - expected).abs() <= allowed, "{name} in row {row}: {found} for {expected}");
        }
    }
    let period_s = 1.0 / recording.rate.true_hz;
    assert!((period_s - 0.005).abs() < 1e-6, "{period_s}");
}

/// A file of three columns in the order of Sensor Logger.
fn sensor_logger(z: f64) -> String {
    let rows: String = (0..50)
        .map(|row| format!("{row},{},{},0.1,0.2\n", 0.01 * f64::from(row), z + 1e-3 * f64::from(row % 3)))
        .collect();
    format!("time,seconds_elapsed,z,y,x\n{rows}")
}

#[test]
fn recognises_renamed_files_of_sensor_logger() {
    for name in ["root_Gyroscope.csv", "run-2 GyroscopeUncalibrated.csv"] {
        let turn = read(name, sensor_logger(1.5).as_bytes());
        assert_eq!(turn.channel("gz_rads").unwrap().values[0], 1.5, "{name}");
    }
    // by gravity if the name gives no hint, as on an iPhone
    let force = read("a.csv", sensor_logger(-1.0).as_bytes());
    assert!((force.channel("az_mps2").unwrap().values[0] - 9.80665).abs() < 1e-9);
    let error = read_as("a.csv", sensor_logger(0.3).as_bytes(), &LoadOptions::default()).unwrap_err();
    assert!(error.contains("Sensor Logger") && error.contains("gz_rads=z:rad/s"), "{error}");
    for name in ["root_Accelerometer.csv", "x_Accelerometer.csv"] {
        let error = read_as(name, sensor_logger(0.3).as_bytes(), &LoadOptions::default()).unwrap_err();
        assert!(error.contains("without gravity") && error.contains("uncalibrated accelerometer"), "{error}");
    }
    // a folder joins them
    let folder = TempDir::new().unwrap();
    for (name, z) in
        [("root_Accelerometer.csv", 0.3), ("root_Gyroscope.csv", 1.5), ("root_TotalAcceleration.csv", 9.8)]
    {
        fs::write(folder.path().join(name), sensor_logger(z)).unwrap();
    }
    let log = load(folder.path(), &LoadOptions::default()).unwrap();
    assert_eq!(log.axes().unwrap().len(), 6);
    fs::remove_file(folder.path().join("root_TotalAcceleration.csv")).unwrap();
    let log = load(folder.path(), &LoadOptions::default()).unwrap();
    assert_eq!(log.axes().unwrap().len(), 3);
    let (_, assumed) = format_of(&log);
    assert!(assumed.contains("root_Accelerometer.csv is without gravity and not read"), "{assumed}");
}

#[test]
fn reads_dataflash_of_2014_and_its_second_imu() {
    let flight = Flight::new(SAMPLES, 20_000, 1);
    let log = dataflash_of_2014(&flight);
    let of_topic = |topic: Option<&str>| {
        let options = LoadOptions { topic: topic.map(str::to_owned), ..LoadOptions::default() };
        read_as("a.BIN", &log, &options).unwrap()
    };
    let first = of_topic(None);
    assert!((first.rate.true_hz - 50.0).abs() < 0.01);
    assert_eq!(first.channel("gx_rads").unwrap().values[7], f64::from(flight.rate[7][0]));
    assert!(format_of(&first).1.contains("there are 1 too"), "{}", format_of(&first).1);
    // placeholder values of an absent thermometer
    assert!(first.channel("temp_c").is_err());
    assert!(first.warnings(&[true; SAMPLES]).iter().any(|odd| odd.to_string().contains("not a temperature")));
    for topic in ["1", "IMU 1", "IMU2"] {
        let second = of_topic(Some(topic));
        assert_eq!(
            second.channel("gx_rads").unwrap().values[7],
            f64::from(flight.rate[7][0] + 0.5),
            "{topic}"
        );
    }
}

#[test]
fn skips_damaged_blocks_of_wearables_with_a_warning() {
    let flight = flight();
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let mut gene = String::from_utf8(geneactiv(&flight)).unwrap();
    // a page with an invalid digit, one cut short, one with an impossible time
    let samples: Vec<(usize, usize)> =
        gene.match_indices("200.0\r\n").map(|(at, text)| (at, at + text.len())).collect();
    gene.replace_range(samples[1].1..samples[1].1 + 1, "G");
    gene.replace_range(samples[3].1..samples[3].1 + 5, "");
    let time = gene.match_indices("Page Time:").nth(5).unwrap().0;
    gene.replace_range(time + 15..time + 17, "13");
    let mut ax6 = axivity(&flight, Axivity::WithGyro);
    ax6[1024 + 512 + 40] ^= 1;
    // blank at the end, as the device leaves it, and cut short within a block
    ax6.extend([0xff; 512 + 100]);
    for (name, bytes, damaged, rows) in
        [("a.bin", gene.into_bytes(), 3, 1100), ("a.cwa", ax6, 2, SAMPLES - 40)]
    {
        let log = read(name, &bytes);
        assert_eq!(log.n_rows(), rows, "{name}");
        let (_, assumed) = format_of(&log);
        assert!(assumed.contains(&format!("{damaged} blocks cannot be read")), "{assumed}");
        let error = read_as(name, &bytes, &strict).unwrap_err();
        assert!(error.contains("damaged"), "{error}");
    }
    let without = String::from_utf8(geneactiv(&flight)).unwrap().replace("y gain:25870", "y gain:NaN");
    let error = read_as("a.bin", without.as_bytes(), &LoadOptions::default()).unwrap_err();
    assert!(error.contains("gain and offset"), "{error}");
    let error = read_as("a.cwa", &axivity(&flight, Axivity::Packed)[..1024 + 300], &LoadOptions::default())
        .unwrap_err();
    assert!(error.contains("0 samples") && error.contains("\nhelp: "), "{error}");
}

#[test]
fn names_the_export_for_known_unreadable_files() {
    let matrix = [&[0; 512][..], b"MDTC\x01\0MDTCPACK"].concat();
    let gt3x = zip(&[("info.txt", b"Serial Number: X"), ("log.bin", &[0x1e; 400])]);
    for (name, bytes, product) in [("a.BIN", matrix, "Parmay"), ("a.gt3x", gt3x, "ActiGraph")] {
        let error = read_as(name, &bytes, &LoadOptions::default()).unwrap_err();
        assert!(error.contains(product) && error.contains("help: export it"), "{error}");
    }
}

#[test]
fn reads_px4_topics_at_full_rate_and_reports_decimation() {
    let flight = flight();
    let combined = read("a.ulg", &ulog(&flight, Rate::Decimated));
    let (_, assumed) = format_of(&combined);
    assert!(assumed.contains("sensor_combined") && assumed.contains("already corrected by PX4"), "{assumed}");
    // the gyro leads; the accelerometer's timestamps are half a millisecond earlier, so that it is interpolated
    assert_eq!(combined.time_s, flight.time_s());
    let turn = combined.channel("gx_rads").unwrap();
    assert!(turn.values.iter().zip(&flight.rate).all(|(found, rate)| *found == f64::from(rate[0])));
    let alignment = combined.alignment.as_ref().expect("two clocks").to_string();
    assert!(alignment.contains("interpolated"), "{alignment}");

    let batches = read("b.ulg", &ulog(&flight, Rate::Fifo));
    assert!(format_of(&batches).1.contains("sensor_accel_fifo"));
    // counts of 16 bits
    is_the_flight(&batches, &flight, 0.0, 0.5 * 16.0 * 9.80665 / 32768.0 + 1e-6);

    // the profile for thermal calibration
    let slow = Flight::new(200, 100_000, 1);
    let [accel, gyro] = ["sensor_accel", "sensor_gyro"].map(|topic| (topic, 0, 2_818_058, &slow));
    let calibration = read("c.ulg", &ulog_of(&[accel, gyro]));
    assert!(format_of(&calibration).1.contains("sensor_gyro 0, device_id 2818058, at 10.0 Hz"));
    assert_eq!(calibration.n_rows(), 200);
}

#[test]
fn undoes_what_ardupilot_did_to_a_sample() {
    let flight = flight();
    let parameters = [
        ("AHRS_ORIENTATION", 4.0),
        ("INS_ACCOFFS_X", 0.25),
        ("INS_ACCOFFS_Y", -0.125),
        ("INS_ACCSCAL_X", 1.0),
        ("INS_GYROFFS_Z", 0.03125),
    ];
    for raw in [false, true] {
        let recording = read("a.bin", &dataflash(&flight, &parameters, raw));
        let (_, assumed) = format_of(&recording);
        assert!(assumed.contains("undone: offsets, AHRS_ORIENTATION 4"), "{assumed}");
        // rotated by half a turn about z
        let x = recording.channel("ax_mps2").unwrap();
        let expected = flight.acceleration.iter().map(|value| -f64::from(value[0]) + 0.25);
        assert!(x.values.iter().zip(expected).all(|(found, expected)| *found == expected));
        let z = recording.channel("gz_rads").unwrap();
        assert!(
            z.values.iter().zip(&flight.rate).all(|(found, rate)| *found == f64::from(rate[2]) + 0.03125)
        );
        assert_eq!(recording.time_s, flight.time_s(), "{raw}");
        assert!(assumed.contains(if raw { "every sample" } else { "(there are 1 too)" }), "{assumed}");
    }
}

#[test]
fn reads_the_requested_sensor() {
    let flight = flight();
    let topic = |name: &str| LoadOptions { topic: Some(name.to_owned()), ..LoadOptions::default() };
    let slow = read_as("a.mcap", &mcap(&flight), &topic("/imu/slow")).unwrap();
    assert_eq!(slow.n_rows(), SAMPLES / 10);
    let all = read("a.mcap", &mcap(&flight));
    assert!(
        format_of(&all).1.starts_with("/imu/data_raw (there are /imu/slow too)"),
        "{}",
        format_of(&all).1
    );
    // the second gyro has no accelerometer
    let second = read_as("a.ulg", &ulog(&flight, Rate::Full), &topic("1")).unwrap();
    assert_eq!(second.axes().unwrap().len(), 3);
    for (name, bytes, wanted) in [
        ("a.mcap", mcap(&flight), "/imu"),
        ("a.ulg", ulog(&flight, Rate::Full), "7"),
        ("a.bin", dataflash(&flight, &[], false), "9"),
        ("a.ulg", ulog(&flight, Rate::Full), "first"),
    ] {
        let error = read_as(name, &bytes, &topic(wanted)).unwrap_err();
        assert!(error.contains(wanted) && error.contains("\nhelp: "), "{error}");
    }
}

#[test]
fn unusable_logs_name_the_data_to_record() {
    let flight = flight();
    let linear = "time,seconds_elapsed,z,y,x\n1,0.0,0.1,0.1,0.1\n2,0.01,0.1,0.1,0.1\n";
    let mut missing = flight.clone();
    missing.stamps_us.truncate(1);
    let combined = "\"Time (s)\",\"Linear Acceleration x (m/s^2)\"\n0,1\n1,2\n";
    for (name, bytes, says) in [
        ("a.zip", zip(&[("Accelerometer.csv", linear.as_bytes())]), "record the total acceleration"),
        ("a.csv", combined.as_bytes().to_vec(), "Acceleration with g"),
        ("a.ulg", ulog(&missing, Rate::Full), "SDLOG_PROFILE"),
        ("a.bin", dataflash(&missing, &[], false), "LOG_BITMASK"),
        ("a.zip", zip(&[("notes.md", b"nothing")]), "no log in it"),
        ("a.zip", zip(&[("a.ulg", b""), ("b.csv", b"")]), "one by one"),
        ("a.zip", zip(&[("rosbag2_0.db3", b"SQLite format 3")]), "ros2 bag convert"),
        ("a_0.db3", b"SQLite format 3\0".to_vec(), "ros2 bag convert"),
        ("a.csv", b"time,ax,ay,az\n0,0,0,9.81\n5,0,0,9.81\n10,0,0,9.81\n".to_vec(), "t_s=time:ms"),
    ] {
        let error = read_as(name, &bytes, &LoadOptions::default()).map(|_| ()).unwrap_err();
        assert!(error.contains(says) && error.contains("\nhelp: "), "{name}: {error}");
    }
    let options = LoadOptions { format: Some(Format::Kalibr), ..LoadOptions::default() };
    let error = read_as("a.csv", flight.csv().as_bytes(), &options).unwrap_err();
    assert!(error.contains("not of the format Kalibr CSV"), "{error}");
}

#[test]
fn truncated_log_is_read_with_a_warning() {
    let flight = flight();
    for (name, bytes) in [
        ("a.ulg", ulog(&flight, Rate::Full)),
        ("a.mcap", mcap(&flight)),
        ("a.bag", bag(&flight, Chunks::None)),
        ("a.bin", dataflash(&flight, &[], false)),
    ] {
        let recording = read(name, &bytes[..bytes.len() / 2]);
        assert!((SAMPLES / 3..SAMPLES).contains(&recording.n_rows()), "{name}: {}", recording.n_rows());
        let assumed = format_of(&recording).1;
        assert!(assumed.contains("cut short"), "{name}: {assumed}");
        // and noise in the middle
        let mut noisy = bytes.clone();
        let middle = noisy.len() / 2;
        noisy[middle..middle + 400].fill(0x5a);
        let recording = read(name, &noisy);
        assert!(recording.n_rows() > SAMPLES / 3, "{name}");
        assert!(
            format_of(&recording).1.contains("bytes") || format_of(&recording).1.contains("damaged"),
            "{name}"
        );
    }
}

#[test]
fn folders_are_opened_as_archives_are() {
    let flight = flight();
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("mav0/imu0");
    fs::create_dir_all(&data).unwrap();
    let text = |id: &str| TEXTS.iter().find(|(known, ..)| *known == id).unwrap().2(&flight);
    fs::write(data.join("data.csv"), text("euroc")).unwrap();
    fs::write(data.join("sensor.yaml"), "rate_hz: 200\n").unwrap();
    let recording = load(folder.path(), &LoadOptions::default()).unwrap();
    is_the_flight(&recording, &flight, 1e-12, 0.0);
    let phone =
        zip(&[("Raw Data.csv", &text("phyphox")), ("meta/device.csv", b"property,value\nversion,1\n")]);
    assert_eq!(format_of(&read("a.zip", &phone)).0, "phyphox");
    let source = &recording.sources[0];
    assert_eq!((source.path.as_str(), source.sha256.len()), (folder.path().to_str().unwrap(), 64));
    assert!(source.bytes > 0);
    // the digest covers the files read
    fs::write(data.join("sensor.yaml"), "rate_hz: 100\n").unwrap();
    assert_eq!(load(folder.path(), &LoadOptions::default()).unwrap().sources, recording.sources);
    fs::write(data.join("data.csv"), text("kalibr")).unwrap();
    assert_ne!(load(folder.path(), &LoadOptions::default()).unwrap().sources, recording.sources);

    let bag = TempDir::new().unwrap();
    fs::write(bag.path().join("metadata.yaml"), "rosbag2_bagfile_information:\n").unwrap();
    fs::write(bag.path().join("bag_0.mcap"), mcap(&flight)).unwrap();
    assert_eq!(format_of(&load(bag.path(), &LoadOptions::default()).unwrap()).0, "mcap");
}

#[test]
fn reads_compressed_files() {
    use std::io::Write as _;
    let flight = flight();
    let log = ulog(&flight, Rate::Full);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&log).unwrap();
    is_the_flight(&read("a.ulg.gz", &packed.finish().unwrap()), &flight, 0.0, 0.0);
    is_the_flight(&read("a.zip", &zip(&[("a.ulg", &log)])), &flight, 0.0, 0.0);
    is_the_flight(
        &read(Path::new("b.zip").to_str().unwrap(), &zip(&[("log.csv", flight.csv().as_bytes())])),
        &flight,
        0.0,
        0.0,
    );
}

#[test]
fn reads_tables_altered_by_spreadsheets() {
    let flight = Flight::new(500, 5000, 2);
    let csv = flight.csv();
    let comma = csv.replace(',', ";").replace('.', ",");
    for (what, text) in [
        ("a byte-order mark", format!("\u{feff}{csv}")),
        ("semicolons and decimal commas", comma.clone()),
        ("tabs and decimal commas", comma.replace(';', "\t")),
        ("CRLF", csv.replace('\n', "\r\n")),
        ("CR", csv.replace('\n', "\r")),
        ("the separator in the first line", format!("sep=;\r\n{}", comma.replace('\n', "\r\n"))),
        ("a title", format!("a measurement of today\n{csv}")),
        ("quoted names", csv.replacen("t_s,ax_mps2", "\"t_s\",\"ax_mps2\"", 1)),
    ] {
        let recording = read("a.csv", text.as_bytes());
        assert_eq!(recording.time_s, flight.time_s(), "{what}");
        is_the_flight(&recording, &flight, 0.0, 0.0);
    }
    let wide: Vec<u8> = [0xfeff].into_iter().chain(csv.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let error = read_as("a.csv", &wide, &LoadOptions::default()).unwrap_err();
    assert!(error.contains("UTF-16") && error.contains("iconv"), "{error}");
}
