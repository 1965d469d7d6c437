//! Every reader states the sensor, the corrections and the axes of its values: for every format and device instance this
//! reaches the recording, and survives a study file.

use std::fs;

use fos_data::column::Triad;
use fos_data::recording::{
    ColumnMap, Format, Frame, KNOWN_FORMATS, LoadOptions, Recording, SensorProvenance, Source, Values, load,
};
use fos_testkit::foreign::{
    Axivity, Chunks, Flight, Rate, TEXTS, axivity, bag, dataflash, geneactiv, mcap, ulog, zip,
};
use tempfile::TempDir;

/// A file with the provenance of its values: accelerometers, then gyros.
struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    topic: Option<&'static str>,
    format: Format,
    expected: [SensorProvenance; 2],
}

fn sensor(values: Values, frame: Frame) -> SensorProvenance {
    SensorProvenance { values, frame, ..SensorProvenance::default() }
}

fn corrected(by: &'static str) -> Values {
    Values::Corrected(by.into())
}

/// Expected provenance of a text format, by the documents of the programs that write it.
fn of_text(name: &str) -> [SensorProvenance; 2] {
    let phone =
        || sensor(corrected("the phone (factory calibration and its own bias estimate)"), Frame::Phone);
    let factory = || sensor(corrected("the phone's factory calibration"), Frame::Phone);
    match name {
        "data.csv" | "st.tsv" => [sensor(Values::Raw, Frame::Sensor), sensor(Values::Raw, Frame::Sensor)],
        // AccelerometerUncalibrated, and Gyroscope
        "android.zip" | "ios.zip" => [factory(), phone()],
        "gnss_log.txt" => [factory(), factory()],
        "phyphox.csv" | "phyphox.zip" | "physics.csv" | "androsensor.csv" => [phone(), phone()],
        "sensorlog.csv" => [sensor(Values::Raw, Frame::Phone), sensor(Values::Raw, Frame::Phone)],
        "blackbox.csv" => {
            let by = "Betaflight (gyro zero and accelerometer trim subtracted, turned to the vehicle)";
            [sensor(corrected(by), Frame::Vehicle), sensor(corrected(by), Frame::Vehicle)]
        }
        "dot.csv" => {
            let by = "the factory calibration of the sensor";
            [sensor(corrected(by), Frame::Sensor), sensor(corrected(by), Frame::Sensor)]
        }
        // they state none
        "named.csv" | "imu0.csv" => [SensorProvenance::default(), SensorProvenance::default()],
        other => panic!("{other}: no provenance is expected of it here"),
    }
}

fn cases(flight: &Flight) -> Vec<Case> {
    let unstated = || [SensorProvenance::default(), SensorProvenance::default()];
    let of_px4 = |instance: u8| SensorProvenance {
        instance: Some(instance),
        device_id: Some(2_818_058 + u32::from(instance)),
        values: Values::Raw,
        frame: Frame::Board,
    };
    let by_px4 = || sensor(corrected("PX4 (calibration and temperature table)"), Frame::Vehicle);
    let case = |name, bytes, topic, format, expected| Case { name, bytes, topic, format, expected };
    let full = || ulog(flight, Rate::Full);
    let mut all = vec![
        case("log.csv", flight.csv().into_bytes(), None, Format::Log, unstated()),
        case("full.ulg", full(), None, Format::Ulog, [of_px4(0), of_px4(0)]),
        // the second gyro has no accelerometer
        case("full.ulg", full(), Some("1"), Format::Ulog, [SensorProvenance::default(), of_px4(1)]),
        case("combined.ulg", ulog(flight, Rate::Decimated), None, Format::Ulog, [by_px4(), by_px4()]),
        case("fifo.ulg", ulog(flight, Rate::Fifo), None, Format::Ulog, [of_px4(0), of_px4(0)]),
        case("turned.ulg", ulog(flight, Rate::FifoOfTurned), None, Format::Ulog, [of_px4(0), of_px4(0)]),
        case("ros2.mcap", mcap(flight), None, Format::Mcap, unstated()),
        case("ros1.bag", bag(flight, Chunks::Some), None, Format::Bag, unstated()),
    ];
    // the provenance of a log of ArduPilot depends on the parameters in it
    let mounted =
        [("AHRS_ORIENTATION", 4.0), ("INS_ACC_ID", 77.0), ("INS_ACC2_ID", 88.0), ("INS_GYR_ID", 99.0)];
    let custom = [("AHRS_ORIENTATION", 101.0), ("INS_ACCOFFS_X", 0.5)];
    let of_ardupilot = |instance, device_id, values, frame| SensorProvenance {
        instance: Some(instance),
        device_id,
        values,
        frame,
    };
    for raw in [false, true] {
        all.push(case(
            "mounted.bin",
            dataflash(flight, &mounted, raw),
            None,
            Format::Dataflash,
            [
                of_ardupilot(0, Some(77), Values::Raw, Frame::Board),
                of_ardupilot(0, Some(99), Values::Raw, Frame::Board),
            ],
        ));
        all.push(case(
            "custom.bin",
            dataflash(flight, &custom, raw),
            None,
            Format::Dataflash,
            [
                of_ardupilot(0, None, corrected("ArduPilot: offsets"), Frame::Vehicle),
                of_ardupilot(0, None, Values::Raw, Frame::Vehicle),
            ],
        ));
    }
    all.push(case(
        "second.bin",
        dataflash(flight, &mounted, false),
        Some("1"),
        Format::Dataflash,
        [
            of_ardupilot(1, Some(88), Values::Raw, Frame::Board),
            of_ardupilot(1, None, Values::Raw, Frame::Board),
        ],
    ));
    let unknown = || of_ardupilot(0, None, Values::Unstated, Frame::Unstated);
    let without = dataflash(flight, &[], false);
    all.push(case("without.bin", without, None, Format::Dataflash, [unknown(), unknown()]));
    let raw = || sensor(Values::Raw, Frame::Sensor);
    let ax6 = axivity(flight, Axivity::WithGyro);
    all.push(case("ax6.cwa", ax6, None, Format::Axivity, [raw(), raw()]));
    let by_header = sensor(corrected("the factory gain and offset in the header"), Frame::Sensor);
    // no gyro, hence no provenance of it
    let accelerometers = [by_header, SensorProvenance::default()];
    all.push(case("left.bin", geneactiv(flight), None, Format::GeneActiv, accelerometers));
    for (id, name, write) in TEXTS {
        all.push(case(name, write(flight), None, id.parse().unwrap(), of_text(name)));
    }
    all
}

fn read(folder: &TempDir, case: &Case, columns: ColumnMap) -> Recording {
    let path = folder.path().join(case.name);
    fs::write(&path, &case.bytes).unwrap();
    let options = LoadOptions { topic: case.topic.map(str::to_owned), columns, ..LoadOptions::default() };
    load(&path, &options).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

/// First triad whose provenance differs from the expected one.
fn first_wrong(recording: &Recording, expected: &[SensorProvenance; 2]) -> Option<Triad> {
    let triads = [Triad::Accelerometers, Triad::Gyros].into_iter().zip(expected);
    triads
        .into_iter()
        .find(|(triad, expected)| recording.provenance(*triad) != **expected)
        .map(|(triad, _)| triad)
}

#[test]
fn every_format_states_sensor_corrections_and_axes() {
    let flight = Flight::new(400, 5000, 1);
    let folder = TempDir::new().unwrap();
    let cases = cases(&flight);
    for case in &cases {
        let recording = read(&folder, case, ColumnMap::default());
        let name = case.name;
        for (triad, expected) in [Triad::Accelerometers, Triad::Gyros].into_iter().zip(&case.expected) {
            assert_eq!(recording.provenance(triad), *expected, "{name}");
        }
        // as a study stores it
        let mut stored = recording.clone();
        for source in &mut stored.sources {
            let text = serde_json::to_string(source).unwrap();
            *source = serde_json::from_str::<Source>(&text).unwrap();
        }
        assert_eq!(first_wrong(&stored, &case.expected), None, "{name}");
        // and in words
        if let Some(read_as) = &recording.sources[0].read_as {
            let description = read_as.to_string();
            assert!(
                case.expected.iter().all(|sensor| description.contains(&sensor.to_string())),
                "{name}: {description}"
            );
        }
    }
    let stated = cases.iter().filter(|case| case.expected != [const { SENSOR }; 2]).count();
    let with_cut = |case: &&Case| {
        first_wrong(&without_provenance(&read(&folder, case, ColumnMap::default())), &case.expected).is_some()
    };
    println!(
        "attack: provenance | {} logs of {} formats and their instances: sensor, corrections and axes in the reader's result and in the stored study match the documentation of the programs | negative control: with the provenance removed from the study, {} of the {stated} that have one are detected",
        cases.len(),
        KNOWN_FORMATS.len(),
        cases.iter().filter(with_cut).count(),
    );
    for known in KNOWN_FORMATS {
        assert!(cases.iter().any(|case| case.format == known.format), "{}: no file of it here", known.id);
    }
}

/// The recording as stored in a study of an earlier version.
fn without_provenance(recording: &Recording) -> Recording {
    let mut recording = recording.clone();
    for source in &mut recording.sources {
        let mut json = serde_json::to_value(&*source).unwrap();
        if let Some(read_as) = json["read_as"].as_object_mut() {
            read_as.remove("provenance");
        }
        *source = serde_json::from_value(json).unwrap();
    }
    recording
}

#[test]
fn detects_missing_provenance() {
    let flight = Flight::new(400, 5000, 1);
    let folder = TempDir::new().unwrap();
    for case in cases(&flight).iter().filter(|case| case.expected != [const { SENSOR }; 2]) {
        let recording = without_provenance(&read(&folder, case, ColumnMap::default()));
        assert!(first_wrong(&recording, &case.expected).is_some(), "{}", case.name);
    }
}

const SENSOR: SensorProvenance =
    SensorProvenance { instance: None, device_id: None, values: Values::Unstated, frame: Frame::Unstated };

#[test]
fn mapped_columns_have_no_provenance() {
    let flight = Flight::new(400, 5000, 1);
    let folder = TempDir::new().unwrap();
    let cases = cases(&flight);
    let case = cases.iter().find(|case| case.name == "blackbox.csv").unwrap();
    let map = ColumnMap::from_specs(["gx_rads=gyroADC[0]:dps"]).unwrap();
    let recording = read(&folder, case, map);
    assert_eq!(recording.provenance(Triad::Gyros), SENSOR);
    assert_eq!(recording.provenance(Triad::Accelerometers), case.expected[0]);
}

#[test]
fn turns_batches_in_the_axes_of_the_sensor_to_those_of_the_board() {
    let flight = Flight::new(2000, 5000, 1);
    let folder = TempDir::new().unwrap();
    let read = |rate| {
        let (format, topic) = (Format::Ulog, None);
        let expected = [SENSOR, SENSOR];
        let case = Case { name: "a.ulg", bytes: ulog(&flight, rate), topic, format, expected };
        read(&folder, &case, ColumnMap::default())
    };
    let (board, turned) = (read(Rate::Fifo), read(Rate::FifoOfTurned));
    let description = &turned.sources[0].read_as.as_ref().unwrap().assumed;
    assert!(description.contains("turned into the board's axes by its rotation 2"), "{description}");
    for axis in ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"] {
        let (found, expected) = (turned.channel(axis).unwrap(), board.channel(axis).unwrap());
        assert_eq!(found.values, expected.values, "{axis}");
    }
}

#[test]
fn reads_the_sign_of_a_phone_alike_with_and_without_metadata() {
    let flight = Flight::new(400, 5000, 1);
    let folder = TempDir::new().unwrap();
    let member = |scale: f64| {
        let rows = flight.acceleration.iter().zip(flight.time_s()).map(|([x, y, z], t)| {
            let [x, y, z] = [x, y, z].map(|value| f64::from(*value) * scale);
            format!("{},{t},{z},{y},{x}\n", t * 1e9)
        });
        format!("time,seconds_elapsed,z,y,x\n{}", rows.collect::<String>())
    };
    let metadata = |platform: &str, standardised: bool| {
        format!("version,device name,platform,standardisation\n3,phone,{platform},{standardised}\n")
    };
    let mean_z = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let recording = load(&path, &LoadOptions::default()).unwrap();
        let z = &recording.channel("az_mps2").unwrap().values;
        z.iter().sum::<f64>() / z.len() as f64
    };
    const G: f64 = 9.80665;
    // an iPhone's own values are in g and have the other sign; for m/s² the metadata decide
    let (own, standard, unlike) = (member(-1.0 / G), member(1.0), member(-1.0));
    let name = "AccelerometerUncalibrated.csv";
    for (content, metadata) in [
        (&own, Some(metadata("ios", false))),
        (&own, None),
        (&standard, Some(metadata("ios", true))),
        (&standard, Some(metadata("android", false))),
        (&standard, None),
        (&unlike, Some(metadata("ios", false))),
    ] {
        let mut members = vec![(name, content.as_bytes())];
        members.extend(metadata.iter().map(|metadata| ("Metadata.csv", metadata.as_bytes())));
        let z = mean_z("a.zip", &zip(&members));
        assert!((z - 9.81).abs() < 0.01, "{metadata:?}: {z}");
    }
    // the file alone, without an archive
    assert!((mean_z(name, own.as_bytes()) - 9.81).abs() < 0.01);
    assert!((mean_z(name, standard.as_bytes()) - 9.81).abs() < 0.01);
}
