//! Every format that is stored or sent: its present version, and the results of a file of it.

use std::fmt::Write;
use std::fs;
use std::io::BufReader;
use std::path::Path;

use fos_core::Image;
use fos_data::case::{self, CaseMeta};
use fos_device_io::record::record;
use fos_diagnose::study::{self, Study};
use fos_embedded::hub::{Hub, HubError};
use fos_embedded::telemetry;
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord};
use fos_fit::evaluate::ModelErrors;

use super::digest::Digest;
use super::flash::{Flash, images, store};
use super::{folder, kinds, make};

/// Converts a file to one that states this version.
pub(crate) type AsVersion = fn(&[u8], u32) -> Vec<u8>;

/// A format of files or streams.
pub(crate) struct Format {
    /// Name in a sentence.
    pub(crate) title: &'static str,
    /// Stem of its fixtures: NAME_vVERSION.EXTENSION.
    pub(crate) name: &'static str,
    pub(crate) extension: &'static str,
    /// Version that is written at present.
    pub(crate) version: u32,
    /// Results of a file, to the last bit, in a text that no later version changes; or the reason for rejecting it.
    pub(crate) outputs: fn(&[u8]) -> Result<String, String>,
    /// Converts the file to state another version; `None` if there is no version to reject.
    pub(crate) as_version: Option<AsVersion>,
    /// Positions of the bytes whose change must be detected.
    pub(crate) payload: fn(&[u8]) -> Vec<usize>,
    /// A new file, from our own simulator.
    pub(crate) make: fn() -> Vec<u8>,
}

/// Formats in the order in which their files are made: one may be made from those before it.
pub(crate) const FORMATS: &[Format] = &[
    Format {
        title: "model image",
        name: "model",
        extension: "fosm",
        version: fos_core::image::VERSION as u32,
        outputs: of_image,
        as_version: Some(with_version_in_header),
        payload: every_byte,
        make: make::image,
    },
    Format {
        title: "model image, every kind of input",
        name: "kinds",
        extension: "fosm",
        version: fos_core::image::VERSION as u32,
        outputs: kinds::outputs,
        as_version: Some(with_version_in_header),
        payload: every_byte,
        make: kinds::image,
    },
    Format {
        title: "hub log",
        name: "hub_log",
        extension: "fosh",
        version: HubLogHeader::VERSION as u32,
        outputs: of_hub_log,
        as_version: Some(with_version_in_header),
        payload: all_but_absent_temperatures,
        make: make::hub_log,
    },
    Format {
        title: "image store in flash",
        name: "flash",
        extension: "bin",
        // without its own version: sequential-storage's layout, four bytes before the image, and the version of the
        // image
        version: fos_core::image::VERSION as u32,
        outputs: of_flash,
        as_version: None,
        payload: images_in_flash,
        make: make::flash,
    },
    Format {
        title: "telemetry",
        name: "telemetry",
        extension: "stream",
        version: telemetry::VERSION as u32,
        outputs: of_telemetry,
        as_version: Some(make::telemetry_as_version),
        payload: all_but_the_last,
        make: make::telemetry,
    },
    Format {
        title: "study",
        name: "study",
        extension: "json",
        version: number_of(study::SCHEMA),
        outputs: of_study,
        as_version: Some(with_version_in_schema),
        payload: digits_of_results,
        make: make::study,
    },
    Format {
        title: "case description",
        name: "case",
        extension: "json",
        version: number_of(case::SCHEMA),
        outputs: of_case,
        as_version: Some(with_version_in_schema),
        payload: digits_of_results,
        make: make::case,
    },
];

/// Number after the `/` of a schema.
const fn number_of(schema: &str) -> u32 {
    let bytes = schema.as_bytes();
    let (mut number, mut place, mut behind) = (0, 0, false);
    while place < bytes.len() {
        if behind {
            number = 10 * number + (bytes[place] - b'0') as u32;
        }
        behind |= bytes[place] == b'/';
        place += 1;
    }
    number
}

// ---- results of a file ----

/// Hub of a device.
type Device = Hub<16, 128, 256>;

/// Outputs of a hub set up by `load` for the samples of the stored hub log, as printed by `fos_embedded`'s firmware.
fn corrections(load: impl FnOnce(&mut Device) -> Result<(), HubError>) -> Result<String, String> {
    let log = fs::read(folder().join("hub_log_v1.fosh")).map_err(|error| error.to_string())?;
    let header = HubLogHeader::decode(&log).map_err(|error| error.to_string())?;
    let mut hub = Device::new(header.scales);
    load(&mut hub).map_err(|error| error.to_string())?;
    let mut given = vec![0.0; usize::from(header.n_given)];
    let mut digest = HubDigest::default();
    let records = log[HubLogHeader::LENGTH..].chunks(header.record_length());
    let n_records = records.len();
    for bytes in records {
        let record = HubLogRecord::decode(bytes, &mut given).map_err(|error| error.to_string())?;
        digest.update(record.step(&mut hub));
    }
    Ok(format!("samples {n_records}\noutputs {:016x}\n", digest.outputs()))
}

pub(crate) fn of_image(bytes: &[u8]) -> Result<String, String> {
    let image = Image::parse(bytes).map_err(|error| error.to_string())?;
    let info = image.info();
    let lines = |text: &str| text.lines().collect::<Vec<_>>().join(", ");
    let (quantities, effects) = (lines(info.quantities), lines(info.effects));
    let corrections = corrections(|hub| hub.load(bytes))?;
    Ok(format!("{corrections}sensor {}\nquantities {quantities}\neffects {effects}\n", info.sensor))
}

fn of_flash(bytes: &[u8]) -> Result<String, String> {
    let mut outputs = String::new();
    let held = images(&mut store(Flash(bytes.to_vec())))?;
    for (name, image) in ["newest", "previous"].into_iter().zip(held) {
        let corrected = match image {
            Some(image) => corrections(|hub| hub.load(&image))?,
            None => "none\n".to_owned(),
        };
        let _ = write!(outputs, "{name}\n{corrected}");
    }
    Ok(outputs)
}

fn of_telemetry(bytes: &[u8]) -> Result<String, String> {
    let recorded = record(BufReader::new(bytes)).map_err(|error| error.to_string())?;
    let report = recorded.report;
    let mut outputs = format!(
        "samples {} lost {} damaged {} unknown {} restarts {}\n",
        report.samples, report.lost, report.damaged, report.unknown, report.restarts
    );
    for (name, values) in recorded.columns {
        let mut digest = Digest::new();
        digest.numbers(values);
        let _ = writeln!(outputs, "{name} {digest}");
    }
    Ok(outputs)
}

fn of_hub_log(bytes: &[u8]) -> Result<String, String> {
    let header = HubLogHeader::decode(bytes).map_err(|error| error.to_string())?;
    let mut digest = Digest::new();
    let scales = header.scales;
    digest.numbers([scales.accel_mps2, scales.gyro_rads, scales.temperature_k, scales.temperature_zero_c]);
    digest.number(scales.period_s);
    digest.bytes(format!("{:?}", scales.values).as_bytes());
    let mut given = vec![0.0; usize::from(header.n_given)];
    let mut records = 0;
    for bytes in bytes[HubLogHeader::LENGTH..].chunks(header.record_length()) {
        let record = HubLogRecord::decode(bytes, &mut given).map_err(|error| error.to_string())?;
        let raw = record.raw;
        digest.number(f64::from(raw.skipped));
        digest.numbers(raw.accel.into_iter().chain(raw.gyro));
        digest.number(raw.temperature.map_or(f64::NAN, f64::from));
        digest.number(f64::from(raw.faults.bits()));
        digest.bytes(format!("{:?}", record.motion).as_bytes());
        digest.bytes(&record.clock_us.to_le_bytes());
        digest.numbers(record.given.iter().copied());
        records += 1;
    }
    Ok(format!("records {records}\ncontent {digest}\n"))
}

/// A file with this content, for readers of files; in a folder that lives as long as the second value.
fn as_file(name: &str, bytes: &[u8]) -> Result<(std::path::PathBuf, tempfile::TempDir), String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let path = folder.path().join(name);
    fs::write(&path, bytes).map_err(|error| error.to_string())?;
    Ok((path, folder))
}

fn errors(outputs: &mut String, step: &str, column: &str, errors: &ModelErrors) {
    let coast: Vec<f64> = errors.coast.iter().map(|at| at.mse).collect();
    let _ = writeln!(
        outputs,
        "{step}, {column}: one_step_mse {:?}, coast mse {coast:?}, slow_error_coast {:?}",
        errors.one_step_mse, errors.slow_error_coast
    );
}

fn of_study(bytes: &[u8]) -> Result<String, String> {
    let (path, _folder) = as_file("study.json", bytes)?;
    let study = Study::read(&path).map_err(|error| error.to_string())?;
    let mut outputs = corrections(|hub| study.model.with::<f32, _>(|model| hub.load_model(model)))?;
    for axis in &study.model.axes {
        for term in axis.physical.iter().chain(&axis.stochastic) {
            let _ = writeln!(outputs, "{}: coefficient {:?}", axis.column, term.coefficient);
        }
    }
    for step in &study.steps {
        for (axis, left) in study.axes.iter().zip(&step.errors) {
            errors(&mut outputs, &step.name, &axis.column, left);
        }
    }
    for refinement in &study.refinements {
        for step in &refinement.steps {
            let added = step.added.as_ref();
            let name = added.map_or("before", |added| &added.finding.effect);
            errors(&mut outputs, name, &refinement.column, &step.errors);
            for term in step.model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic)) {
                let _ = writeln!(outputs, "{name}: coefficient {:?}", term.coefficient);
            }
            if let Some(added) = added {
                let _ = writeln!(outputs, "{name}: measured reduction {:?}", added.measured_reduction);
                for part in &added.finding.correction {
                    let _ = writeln!(outputs, "{name}: {} times {:?}", part.regressor, part.coefficient);
                }
            }
        }
    }
    let _ = writeln!(outputs, "{}", study.provenance());
    Ok(outputs)
}

fn of_case(bytes: &[u8]) -> Result<String, String> {
    let (path, _folder) = as_file("meta.json", bytes)?;
    let meta = CaseMeta::read(path.parent().unwrap_or(Path::new("."))).map_err(|error| error.to_string())?;
    let mut outputs = format!("{}, target {}, {:?} Hz\n", meta.case, meta.target, meta.nominal_rate_hz);
    // the target determines which numbers are used
    for target in ["ax_mps2", "gx_rads"] {
        let meta = CaseMeta { target: target.to_owned(), ..meta.clone() };
        let sheet = meta.data_sheet().map(|sheet| (sheet.noise_density, sheet.bias_instability));
        let _ = writeln!(outputs, "{target}: {:?} {:?} {sheet:?}", meta.full_scale(), meta.lsb());
    }
    let sheet = &meta.datasheet;
    let _ = writeln!(outputs, "{:?} {:?}", sheet.gyro_tco_dps_per_k, sheet.accel_tco_mg_per_k);
    let _ = writeln!(outputs, "{:?} {:?} {:?}", meta.files.baseline, meta.files.field, meta.files.eval);
    Ok(outputs)
}

// ---- conversion to another version ----

/// Replaces the u16 after the four letters of a header.
fn with_version_in_header(bytes: &[u8], version: u32) -> Vec<u8> {
    let mut other = bytes.to_vec();
    other[4..6].copy_from_slice(&(version as u16).to_le_bytes());
    other
}

/// Replaces the schema and drops everything else, since the content of another version is unknown.
fn with_version_in_schema(bytes: &[u8], version: u32) -> Vec<u8> {
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    let (before, after) = text.split_once("\"schema\": \"").expect("a schema");
    assert_eq!(before.trim(), "{");
    let name = after.split('/').next().expect("a name");
    format!("{{ \"schema\": \"{name}/{version}\" }}").into_bytes()
}

// ---- positions whose change must be detected ----

fn every_byte(bytes: &[u8]) -> Vec<usize> {
    (0..bytes.len()).collect()
}

/// All but the last byte: the end of a stream ends its last frame, with or without a delimiter.
fn all_but_the_last(bytes: &[u8]) -> Vec<usize> {
    (0..bytes.len() - 1).collect()
}

/// All but the temperature codes of samples without a temperature in a hub log, which are ignored.
fn all_but_absent_temperatures(bytes: &[u8]) -> Vec<usize> {
    let header = HubLogHeader::decode(bytes).expect("a header");
    let is_absent = |place: usize| {
        let Some(place) = place.checked_sub(HubLogHeader::LENGTH) else { return false };
        let (record, field) = (place / header.record_length(), place % header.record_length());
        let has_temperature = bytes[HubLogHeader::LENGTH + record * header.record_length() + 7];
        has_temperature == 0 && (28..30).contains(&field)
    };
    every_byte(bytes).into_iter().filter(|place| !is_absent(*place)).collect()
}

/// Images in a flash: the bytes around them may be repaired.
fn images_in_flash(bytes: &[u8]) -> Vec<usize> {
    let images = images(&mut store(Flash(bytes.to_vec()))).expect("images");
    let place = |image: &Vec<u8>| {
        let place =
            bytes.windows(image.len()).position(|window| window == image).expect("it lies in one piece");
        place..place + image.len()
    };
    images.iter().flatten().flat_map(place).collect()
}

/// Digits of results, except for the last two: of seventeen digits they may represent the same number.
fn digits_of_results(bytes: &[u8]) -> Vec<usize> {
    const RESULTS: [&str; 7] = [
        "coefficient",
        "one_step_mse",
        "mse",
        "slow_error_coast",
        "realised_fall",
        "full_scale_",
        "density_",
    ];
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    // the report of the search is no result
    let skipped = match (text.find("\n  \"axes\": ["), text.find("\n  \"steps\": [")) {
        (Some(from), Some(to)) => from..to,
        _ => 0..0,
    };
    let mut places = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let (name, value) = line.trim().split_once(':').unwrap_or(("", ""));
        let name = name.trim_matches('"');
        let is_result =
            RESULTS.iter().any(|result| name == *result || name.contains(result) && result.ends_with('_'));
        if is_result && !skipped.contains(&start) && value.trim_end_matches(',').trim().parse::<f64>().is_ok()
        {
            let number = line.rfind(':').map_or(0, |colon| colon + 1)..line.len();
            let digit = |place: usize| line.as_bytes().get(place).is_some_and(u8::is_ascii_digit);
            places.extend(
                number.filter(|place| (0..3).all(|ahead| digit(place + ahead))).map(|place| start + place),
            );
        }
        start += line.len();
    }
    places
}
