//! Makes the fixtures of versions that have none yet, from our own simulator.

use std::fs;

use embedded_io::{ErrorType, Write};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_diagnose::compare::study_of;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::Refiner;
use fos_diagnose::study::LogSources;
use fos_diagnose::study::Study;
use fos_embedded::blocking::poll_once;
use fos_embedded::hub::{Hub, MAX_LOGGED, Motion};
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_embedded::telemetry::{Frame, HUB_AXES, Recorder, Snapshot, StartFrame, VERSION, encode};
use fos_embedded::test_log::{HubLogHeader, HubLogRecord};
use fos_fit::fit::{FitOptions, fit_axis};
use fos_simulate::{Axis, CasePlan, Effect, Plant, Setup, SimulatedCase, Simulation};

use super::flash::{BYTES, Flash, store};
use super::formats::FORMATS;
use super::{file_of, folder, read, recorded};

/// Existing files are kept: a released file never changes.
#[test]
#[ignore = "writes files: tests/fixtures/README.md"]
fn write_the_fixtures_of_new_versions() {
    let new: Vec<_> = FORMATS.iter().filter(|format| !recorded(&file_of(format)).exists()).collect();
    for format in &new {
        let path = file_of(format);
        if !path.exists() {
            fs::write(&path, (format.make)()).expect("written");
        }
    }
    for format in &new {
        let path = file_of(format);
        let outputs = (format.outputs)(&read(&path)).expect("it is read");
        fs::write(recorded(&path), outputs).expect("written");
    }
}

const SCALES: Scales = Scales {
    accel_mps2: 0.001_197,
    gyro_rads: 0.000_305,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: fos_core::FittedOn::Raw,
};

/// Two seconds of a simulated device: six axes, and °C.
fn simulated() -> Vec<([f64; 6], f64)> {
    let log = fos_simulate::simulate(&Simulation { duration_s: 2.0, seed: 21, ..Simulation::default() });
    let column = |name: &str| &log.columns.iter().find(|(column, _)| column == name).expect("a column").1;
    let axes = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"].map(column);
    let celsius = column("temp_c");
    (0..120).map(|row| (axes.map(|axis| axis[row]), celsius[row])).collect()
}

/// Still, then moving, then still; with a gap, a fault, and a sample without a temperature.
pub(crate) fn hub_log() -> Vec<u8> {
    let header = HubLogHeader { scales: SCALES, n_given: 1 };
    let mut bytes = header.encode().to_vec();
    for (tick, (axes, celsius)) in simulated().into_iter().enumerate() {
        let code = |value: f64, scale: f32| (value / f64::from(scale)).round() as i16;
        let [ax, ay, az, gx, gy, gz] = axes;
        let celsius = (tick != 70).then(|| code(celsius - 25.0, SCALES.temperature_k));
        let raw = RawSample {
            skipped: if tick == 60 { 3 } else { 0 },
            accel: [ax, ay, az].map(|value| code(value, SCALES.accel_mps2)),
            gyro: [gx, gy, gz].map(|value| code(value, SCALES.gyro_rads)),
            temperature: celsius,
            faults: if tick == 30 { Faults::BUS } else { Faults::empty() },
        };
        let motion = match tick {
            0 => None,
            80..100 => Some(Motion::Moving),
            _ => Some(Motion::Still),
        };
        let clock_us = if tick % 10 == 9 { 5000 * (tick as u64 + 1) } else { 0 };
        let supply = [3.3 + 0.01 * (tick as f32 / 8.0)];
        bytes.extend(HubLogRecord { raw, motion, clock_us, given: &supply }.encode());
    }
    bytes
}

/// Model of the study.
pub(crate) fn image() -> Vec<u8> {
    let model = written_study().model;
    fos_export::image(&model, "simulated", "tests/tests/compatibility").expect("an image")
}

fn stored_image() -> Vec<u8> {
    read(&folder().join("model_v1.fosm"))
}

/// A flash with the stored image, then the model of the study.
pub(crate) fn flash() -> Vec<u8> {
    let mut store = store(Flash(vec![0xff; BYTES]));
    for bytes in [stored_image(), image()] {
        poll_once(store.store(&bytes)).expect("done at once").unwrap_or_else(|error| panic!("{error:?}"));
    }
    store.release().0.0
}

/// Bytes sent.
struct Line(Vec<u8>);

impl ErrorType for Line {
    type Error = core::convert::Infallible;
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// Telemetry of a hub with the stored image for the first samples of the stored hub log; one frame is lost.
pub(crate) fn telemetry() -> Vec<u8> {
    let log = read(&folder().join("hub_log_v1.fosh"));
    let header = HubLogHeader::decode(&log).expect("a header");
    let mut hub: Hub<16, 128, 256> = Hub::new(header.scales);
    hub.load(&stored_image()).expect("loaded");
    let start =
        StartFrame { version: VERSION, period_s: 0.005, axes: HUB_AXES, quantities: "temp_c\nsupply_v" };
    let mut recorder: Recorder<_, 320> = Recorder::new(Line(Vec::new()));
    let mut given = [0.0];
    for (place, bytes) in log[HubLogHeader::LENGTH..].chunks(header.record_length()).take(40).enumerate() {
        let record = HubLogRecord::decode(bytes, &mut given).expect("a record");
        let output = *record.step(&mut hub);
        if place != 20 {
            recorder
                .sample(&start, Snapshot::<MAX_LOGGED>::new(&output, &hub.logged()).frame())
                .expect("sent");
        }
    }
    recorder.release().0
}

/// A stream whose start frame states another version.
pub(crate) fn telemetry_as_version(bytes: &[u8], version: u32) -> Vec<u8> {
    let start = StartFrame {
        version: version as u16,
        period_s: 0.005,
        axes: HUB_AXES,
        quantities: "temp_c\nsupply_v",
    };
    let mut buffer = [0; 320];
    let mut other = encode(&Frame::Start(start), &mut buffer).expect("room").to_vec();
    let after_start = bytes.iter().position(|byte| *byte == 0).map_or(0, |end| end + 1);
    other.extend_from_slice(&bytes[after_start..]);
    other
}

fn simulated_case() -> SimulatedCase {
    let mut plan = CasePlan::new(8, "bmi270", Setup::Bench, Axis::named("gx").expect("an axis"));
    plan.planted.push(Plant { effect: Effect::ThermalLag, parameter: Some(60.0), size: 120.0 });
    fos_simulate::simulate_case(&plan).expect("a case")
}

pub(crate) fn case() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().join("thermal_lag");
    simulated_case().write(&folder).expect("written");
    read(&folder.join("meta.json"))
}

/// Study of a gyro axis with a thermal lag added to it.
fn written_study() -> Study {
    let case = simulated_case();
    let recording = |name: &str, columns| {
        let options = LoadOptions { rate_hz: Some(200.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by(name), columns, &options).expect("a log")
    };
    let (reference, log) =
        (recording("simulated reference log", case.reference), recording("simulated log", case.log));
    let stillness = stillness::find(&reference);
    let options = FitOptions { max_terms: 2, memory_s: vec![], ..FitOptions::default() };
    let fit = fit_axis(&reference, &stillness, "gx", &options).expect("fits");
    let mut study = study_of(&reference, &stillness, vec![fit], options, LoadOptions::default(), &mut |_| {})
        .expect("evaluated");
    let library = Library::built_in();
    let refiner = Refiner::new(&log, Some(&reference), None, &library);
    let logs = LogSources {
        log: log.sources[0].clone(),
        reference: Some(reference.sources[0].clone()),
        evaluation: None,
        fitted_rows: refiner.fitted_rows(),
        read: LoadOptions { rate_hz: Some(200.0), ..LoadOptions::default() },
    };
    let mut refinement = refiner.begin(&study, "gx_rads", logs).expect("begun");
    let step = refiner.add(&refinement, library.get("thermal_lag").expect("an effect")).expect("added");
    refinement.steps.push(step);
    study.keep(refinement);
    study
}

pub(crate) fn study() -> Vec<u8> {
    written_study().to_bytes()
}
