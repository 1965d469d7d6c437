//! docs/formats.md documents every format as the readers implement it: the description, the result for a flight, and the
//! messages for hostile files.

use std::fmt::Write as _;
use std::fs;

use fos_data::column::AXES;
use fos_data::recording::{Format, KNOWN_FORMATS, LoadOptions, ReadAs, Recording, load};
use fos_testkit::foreign::{Axivity, Chunks, Flight, Text, axivity, bag, files};
use fos_testkit::page;
use tempfile::TempDir;

const SAMPLES: usize = 2000;

/// Files that hold what the log format holds, to the last bit.
const LOSSLESS: [&str; 5] = ["flight.ulg", "flight.bin", "flight.mcap", "flight.bag", "plain.bag"];

/// A variant of a format: file name, description, and writer.
struct Variant {
    format: Format,
    name: &'static str,
    what: &'static str,
    write: fn(&Flight) -> Vec<u8>,
}

fn variants() -> Vec<Variant> {
    const MORE: [Text; 2] = [
        ("bag", "plain.bag", |flight| bag(flight, Chunks::None)),
        ("axivity", "unpacked.cwa", |flight| axivity(flight, Axivity::Unpacked)),
    ];
    let variant = |(id, name, write): &Text| Variant {
        format: id.parse().unwrap(),
        name,
        what: match *name {
            "flight.csv" => "every digit",
            "flight.ulg" => "`sensor_accel`, `sensor_gyro`",
            "decimated.ulg" => "`sensor_combined`",
            "batches.ulg" => "FIFO batches of 10",
            "flight.bin" => "`IMU`",
            "every_sample.bin" => "`ACC`, `GYR`",
            "flight.mcap" => "`/imu/data_raw`, `/imu/temperature`",
            "flight.bag" => "`/imu`, `/temperature`, in chunks",
            "plain.bag" => "the same without chunks",
            "flight_geneactiv.bin" => "pages of 300 samples",
            "ax6.cwa" => "AX6",
            "packed.cwa" => "AX3, packed",
            "unpacked.cwa" => "AX3, unpacked",
            "android.zip" => "a file a sensor, m/s²",
            "ios.zip" => "a file a sensor, g, sign turned",
            "phyphox.zip" => "a file a sensor",
            "physics.csv" => "decimal commas",
            "blackbox.csv" => "counts, °/s",
            _ => "one table",
        },
        write: *write,
    };
    let mut all: Vec<Variant> = files().chain(&MORE).map(variant).collect();
    // in the order in which the formats are listed
    let place = |variant: &Variant| KNOWN_FORMATS.iter().position(|known| known.format == variant.format);
    all.sort_by_key(place);
    all
}

fn read_in(folder: &TempDir, name: &str, bytes: &[u8], format: Option<Format>) -> Result<Recording, String> {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path, &LoadOptions { format, ..LoadOptions::default() }).map_err(|error| error.to_string())
}

/// Removes 50 samples in the middle; a whole number of batches.
fn with_a_gap(flight: &Flight) -> Flight {
    let gone = SAMPLES / 2 - 20..SAMPLES / 2 + 30;
    let mut flight = flight.clone();
    flight.stamps_us.drain(gone.clone());
    flight.acceleration.drain(gone.clone());
    flight.rate.drain(gone.clone());
    flight.temperature.drain(gone);
    flight
}

/// Largest difference of these columns from those of the flight; `None` if one is absent.
fn furthest(recording: &Recording, flight: &Flight, names: &[&str]) -> Option<f64> {
    let columns = flight.columns();
    let mut furthest = 0.0_f64;
    for (name, expected) in columns.iter().filter(|(name, _)| names.contains(name)) {
        let found = &recording.channel(name).ok()?.values;
        let far = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        furthest = far.filter(|far| far.is_finite()).fold(furthest, f64::max);
    }
    Some(furthest)
}

fn size(value: Option<f64>) -> String {
    match value {
        None => "none".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => format!("{value:.0e}"),
    }
}

#[test]
fn page_documents_every_format() {
    let mut text = String::from("\n");
    for known in KNOWN_FORMATS {
        let _ = write!(
            text,
            "**{}** (`--format {}`; {})\n\n- read: {}\n- units: {}; clock: {}; temperature: {}\n- values: {}\n- pitfalls: {}\n- refused: {}\n\n",
            known.name,
            known.id,
            known.files,
            known.read,
            known.units,
            known.clock,
            known.temperature,
            known.values,
            known.traps,
            known.refused
        );
    }
    page::holds("formats.md", "<!-- knowledge -->", "<!-- end of knowledge -->", &text);
}

#[test]
fn page_documents_the_result_for_a_flight() {
    let flight = Flight::new(SAMPLES, 5000, 1);
    let folder = TempDir::new().unwrap();
    let mut text = String::from(
        "\n| format | file | holds | axes | rows | rate, Hz | largest error: m/s² | rad/s | °C | gaps found | samples missing |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let log = read_in(&folder, "flight.csv", flight.csv().as_bytes(), None).unwrap();
    let mut covered = Vec::new();
    for Variant { format, name, what, write } in variants() {
        let recording = read_in(&folder, name, &write(&flight), None).unwrap();
        let read_as = recording.sources[0].read_as.as_ref().map_or(Format::Log, |read_as| read_as.format);
        assert_eq!(read_as, format, "{name}");
        assert_eq!((recording.n_rows(), recording.quality.gaps), (SAMPLES, 0), "{name}");
        if name == "flight.csv" {
            assert_eq!(recording.time_s, flight.time_s());
        }
        if LOSSLESS.contains(&name) {
            assert_eq!(
                (&recording.time_s, recording.rate.true_hz),
                (&log.time_s, log.rate.true_hz),
                "{name}"
            );
            for channel in log.channels() {
                let found = recording.channel(&channel.name).unwrap();
                assert_eq!((found.unit, &found.values), (channel.unit, &channel.values), "{name}");
            }
        }
        // the accelerometer of this one is interpolated
        if name != "decimated.ulg" {
            let is_known = |axis: &String| recording.channel(axis).unwrap().n_missing() == 0;
            assert!(recording.axes().unwrap().iter().all(is_known), "{name}");
        }
        if let Some(read_as) = &recording.sources[0].read_as {
            assert!(!read_as.assumed.is_empty(), "{name}");
            let stated = read_in(&folder, name, &write(&flight), Some(format)).unwrap();
            assert_eq!(stated.time_s, recording.time_s, "{name}");
        }
        let broken = read_in(&folder, name, &write(&with_a_gap(&flight)), None).unwrap();
        let quality = &broken.quality;
        assert_eq!((quality.gaps, quality.samples_missing, broken.n_rows()), (1, 50, SAMPLES - 50), "{name}");
        let _ = writeln!(
            text,
            "| {} | {name} | {what} | {} | {} | {:.3} | {} | {} | {} | {} | {} |",
            format.id(),
            recording.axes().unwrap().len(),
            recording.n_rows(),
            recording.rate.true_hz,
            size(furthest(&recording, &flight, &AXES[..3])),
            size(furthest(&recording, &flight, &AXES[3..])),
            size(furthest(&recording, &flight, &["temp_c"])),
            quality.gaps,
            quality.samples_missing
        );
        covered.push(format);
    }
    for known in KNOWN_FORMATS {
        assert!(covered.contains(&known.format), "{}: no file of it is written here", known.id);
    }
    page::holds("formats.md", "<!-- measured -->", "<!-- end of measured -->", &text);
}

#[test]
fn page_documents_messages_for_hostile_files() {
    let flight = Flight::new(SAMPLES, 5000, 1);
    let folder = TempDir::new().unwrap();
    let all = variants();
    let mut text =
        String::from("\n| format | file | rows | of them wrong | message |\n|---|---|---|---|---|\n");
    let mut last = None;
    for Variant { format, name, write, .. } in &all {
        // one file of each format
        if last.replace(*format) == Some(*format) {
            continue;
        }
        let whole = write(&flight);
        let clean = read_in(&folder, name, &whole, None).unwrap();
        let mut noisy = whole.clone();
        noisy[whole.len() / 4..][..400].fill(0x5a);
        let other = if *format == Format::Ulog { Format::Dataflash } else { Format::Ulog };
        let of_another = |other: Format| all.iter().find(|variant| variant.format == other).unwrap();
        // a table of another program
        let table = if *format == Format::Euroc { Format::Kalibr } else { Format::Euroc };
        let cases = [
            ("cut in half", whole[..whole.len() / 2].to_vec(), None),
            ("400 bytes overwritten after a quarter", noisy, None),
            ("empty", Vec::new(), None),
            ("its first 100 bytes", whole[..100].to_vec(), None),
            (
                if other == Format::Ulog {
                    "a ULog, stated as this format"
                } else {
                    "a DataFlash log, stated as this format"
                },
                (of_another(other).write)(&flight),
                Some(*format),
            ),
            (
                if table == Format::Euroc {
                    "EuRoC's table, stated as this format"
                } else {
                    "Kalibr's table, stated as this format"
                },
                (of_another(table).write)(&flight),
                Some(*format),
            ),
        ];
        for (what, bytes, said_to_be) in cases {
            // a log without axes is rejected when it is used
            let read = read_in(&folder, name, &bytes, said_to_be).and_then(|recording| {
                recording.axes().map(|_| recording.clone()).map_err(|error| error.to_string())
            });
            let message = match &read {
                Ok(recording) => cautions(recording, &clean),
                Err(error) => {
                    let (first, help) = error.split_once('\n').unwrap_or((error, ""));
                    assert!(help.starts_with("help: "), "{name}, {what}: {error}");
                    let path = folder.path().join(name).display().to_string();
                    let first = first.replace(&format!("{path}: "), "").replace(&path, name);
                    first.replace(&format!("{name}, byte"), "byte")
                }
            };
            // text has no line count, so a cut between lines goes unnoticed
            let is_text = !matches!(format, Format::Ulog | Format::Dataflash | Format::Mcap | Format::Bag);
            let is_silent = message == "nothing";
            assert!(!is_silent || is_text && what == "cut in half", "{name}, {what}: {message}");
            // a file of another format is never accepted as this one
            let is_taken = said_to_be.is_some() && read.is_ok();
            assert!(!is_taken, "{name}, {what}: {message}");
            let message = shortened(&message).replace('|', "\\|");
            let (rows, wrong) = match &read {
                Ok(recording) => (recording.n_rows().to_string(), wrong(recording, &clean).to_string()),
                Err(_) => ("–".to_owned(), "–".to_owned()),
            };
            let _ = writeln!(text, "| {} | {what} | {rows} | {wrong} | {message} |", format.id());
        }
    }
    page::holds("formats.md", "<!-- hostile -->", "<!-- end of hostile -->", &text);
}

/// Warnings and assumptions of a log that the complete log lacks.
fn cautions(recording: &Recording, whole: &Recording) -> String {
    let parts = |recording: &Recording| -> Vec<String> {
        let assumed = recording.sources[0].read_as.as_ref().map(|ReadAs { assumed, .. }| assumed.clone());
        let assumed = assumed.unwrap_or_default();
        let quality = recording.quality.to_string();
        assumed.split("; ").chain(quality.lines()).map(|part| part.trim().to_owned()).collect()
    };
    let usual = parts(whole);
    let new: Vec<String> = parts(recording).into_iter().filter(|part| !usual.contains(part)).collect();
    if new.is_empty() { "nothing".to_owned() } else { new.join("; ") }
}

/// Number of rows that the complete log lacks: another timestamp, or other values.
fn wrong(recording: &Recording, whole: &Recording) -> usize {
    let differs = |row: usize| {
        let found = whole.time_s.iter().position(|stamp| *stamp == recording.time_s[row]);
        let Some(of_whole) = found else { return true };
        let value =
            |of: &Recording, axis: &str, row: usize| of.channel(axis).ok().map(|found| found.values[row]);
        AXES.iter().any(|axis| value(recording, axis, row) != value(whole, axis, of_whole))
    };
    (0..recording.n_rows()).filter(|row| differs(*row)).count()
}

/// Text shortened for a table.
fn shortened(text: &str) -> String {
    const MOST: usize = 150;
    let plain: String =
        text.chars().map(|c| if c.is_control() || c == '\u{fffd}' { '?' } else { c }).collect();
    if plain.chars().count() <= MOST { plain } else { plain.chars().take(MOST).chain(['…']).collect() }
}
