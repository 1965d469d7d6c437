//! Every public type of both crates can be logged.
//!
//! The text of the log exists only on the target: `.ci/device defmt` checks it.

use std::any::type_name;
use std::collections::BTreeSet;
use std::path::Path;

use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::Mock;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use fos_core::align::{self, Aligner, Held, Interpolated, Joined};
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, Channel, CheckedModel, Correction, Drift, Evaluator,
    Factor, FittedOn, Fixed, Image, ImageError, Info, InnovationStatistics, Input, Model, ModelError,
    Monitor, PoseGate, Predictor, Quantity, Range, Sample, Scalar, Source, StillnessDetector,
    StillnessLimits, Term, Transform, Transformer, TriadCalibration, Validity, image,
};
use fos_embedded::blocking::Blocking;
use fos_embedded::c_api;
use fos_embedded::hub::{Hub, HubError, Motion, Output};
use fos_embedded::raw::{Faults, RawSample, Scales, SiSample};
use fos_embedded::sample_source::{
    self, Address, Batch, Bmi323, Counts, Icm42688, Lsm6dso, Lsm6dsv16x, SampleSource, SensorClock,
    SourceError,
};
use fos_embedded::store::{ModelStore, StoreError};
use fos_embedded::streams::{Periods, StampedSample, StreamCounts, Streams};
use fos_embedded::telemetry::{
    self, AlarmRecorder, ImageReceiver, Recorder, SampleFrame, Snapshot, StartFrame, TelemetryError,
};
use fos_embedded::test_log::{
    HubDigest, HubLogHeader, HubLogRecord, PredictorDigest, PredictorLogHeader, PredictorLogRecord,
    TestLogError,
};
use fos_embedded::test_vector::{CheckError, Expected, TestSample, TestVector};

/// A flash that is never used.
enum NoFlash {}

impl ErrorType for NoFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for NoFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), Self::Error> {
        match *self {}
    }

    fn capacity(&self) -> usize {
        match *self {}
    }
}

impl NorFlash for NoFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 4096;

    async fn erase(&mut self, _: u32, _: u32) -> Result<(), Self::Error> {
        match *self {}
    }

    async fn write(&mut self, _: u32, _: &[u8]) -> Result<(), Self::Error> {
        match *self {}
    }
}

type Part = Lsm6dsv16x<Blocking<Mock>, Blocking<NoopDelay>>;

/// File and name of a type. Compiles only if the type can be logged.
fn named<T: defmt::Format>(file: &str) -> String {
    let whole = type_name::<T>();
    let path = whole.split('<').next().unwrap_or(whole);
    format!("{file} {}", path.rsplit("::").next().unwrap_or(path))
}

/// File and name of a type that is reachable only through a scalar.
fn named_gain<R: Scalar>(file: &str) -> String
where
    R::Gain: defmt::Format,
{
    named::<R::Gain>(file)
}

fn named_slow<R: Scalar>(file: &str) -> String
where
    R::Slow: defmt::Format,
{
    named::<R::Slow>(file)
}

/// File and name of all types that can be logged.
fn loggable() -> BTreeSet<String> {
    let types = [
        named::<align::Counts>("fos-core/align/counts.rs"),
        named::<align::Refused>("fos-core/align/counts.rs"),
        named::<Interpolated<f32>>("fos-core/align/follower.rs"),
        named::<Aligner<f32, 1, 1, 32>>("fos-core/align/mod.rs"),
        named::<Joined<f32, 1, 1>>("fos-core/align/mod.rs"),
        named::<align::Stream>("fos-core/align/mod.rs"),
        named::<Held<f32>>("fos-core/align/slow.rs"),
        named::<Correction<f32>>("fos-core/axis/mod.rs"),
        named::<CheckedModel<'_>>("fos-core/check.rs"),
        named::<Calibration<f32>>("fos-core/calibration.rs"),
        named::<TriadCalibration<f32>>("fos-core/calibration.rs"),
        named::<Evaluator<f32, 6, 8, 64, 128>>("fos-core/evaluator/mod.rs"),
        named::<Sample<'_, f32>>("fos-core/evaluator/mod.rs"),
        named::<image::AxisImage<'_>>("fos-core/image/read.rs"),
        named::<Image<'_>>("fos-core/image/read.rs"),
        named::<image::Terms<'_>>("fos-core/image/read.rs"),
        named::<ImageError>("fos-core/image/mod.rs"),
        named::<image::UnitError>("fos-core/image/unit.rs"),
        named::<image::UnitRecord<'_>>("fos-core/image/unit.rs"),
        named::<Fixed>("fos-core/fixed.rs"),
        named_gain::<Fixed>("fos-core/fixed.rs"),
        named_slow::<f32>("fos-core/arithmetic.rs"),
        named::<Info<'_>>("fos-core/image/mod.rs"),
        named::<Input<f32>>("fos-core/input.rs"),
        named::<Source>("fos-core/input.rs"),
        named::<Axis>("fos-core/model.rs"),
        named::<AxisModel<'_, f32>>("fos-core/model.rs"),
        named::<AxisParameters<f32>>("fos-core/model.rs"),
        named::<FittedOn>("fos-core/model.rs"),
        named::<InnovationStatistics<f32>>("fos-core/model.rs"),
        named::<Model<'_, f32>>("fos-core/model.rs"),
        named::<ModelError>("fos-core/error.rs"),
        named::<Quantity>("fos-core/model.rs"),
        named::<Drift>("fos-core/monitor.rs"),
        named::<Monitor<f32>>("fos-core/monitor.rs"),
        named::<PoseGate<f32>>("fos-core/pose.rs"),
        named::<Predictor<f32, 6, 8, 64, 128>>("fos-core/predictor.rs"),
        named::<Range<f32>>("fos-core/range.rs"),
        named::<StillnessDetector<f32>>("fos-core/stillness.rs"),
        named::<StillnessLimits<f32>>("fos-core/stillness.rs"),
        named::<Channel>("fos-core/term.rs"),
        named::<Factor>("fos-core/term.rs"),
        named::<Term<f32>>("fos-core/term.rs"),
        named::<Transform<f32>>("fos-core/transform.rs"),
        named::<Transformer<f32>>("fos-core/transformer.rs"),
        named::<Validity>("fos-core/validity.rs"),
        named::<Blocking<u8>>("fos-embedded/blocking.rs"),
        named::<c_api::fos_flash>("fos-embedded/c_api/flash.rs"),
        named::<c_api::fos_store>("fos-embedded/c_api/store.rs"),
        named::<c_api::fos_hub>("fos-embedded/c_api/hub.rs"),
        named::<c_api::fos_status>("fos-embedded/c_api/status.rs"),
        named::<c_api::fos_stream_count>("fos-embedded/c_api/streams.rs"),
        named::<c_api::fos_stream_counts>("fos-embedded/c_api/streams.rs"),
        named::<c_api::fos_stream_periods>("fos-embedded/c_api/streams.rs"),
        named::<c_api::fos_streams>("fos-embedded/c_api/streams.rs"),
        named::<c_api::fos_output>("fos-embedded/c_api/values.rs"),
        named::<c_api::fos_raw_sample>("fos-embedded/c_api/values.rs"),
        named::<c_api::fos_scales>("fos-embedded/c_api/values.rs"),
        named::<c_api::fos_si_output>("fos-embedded/c_api/values.rs"),
        named::<c_api::fos_si_sample>("fos-embedded/c_api/values.rs"),
        named::<HubError>("fos-embedded/hub/error.rs"),
        named::<Hub<8, 64, 128>>("fos-embedded/hub/mod.rs"),
        named::<Motion>("fos-embedded/hub/mod.rs"),
        named::<Output>("fos-embedded/hub/output.rs"),
        named::<Faults>("fos-embedded/raw.rs"),
        named::<RawSample>("fos-embedded/raw.rs"),
        named::<Scales>("fos-embedded/raw.rs"),
        named::<SiSample>("fos-embedded/raw.rs"),
        named::<Bmi323<(), ()>>("fos-embedded/sample_source/bmi323.rs"),
        named::<Counts>("fos-embedded/sample_source/counts.rs"),
        named::<SourceError<u8>>("fos-embedded/sample_source/error.rs"),
        named::<Batch>("fos-embedded/sample_source/frame.rs"),
        named::<sample_source::FifoFrame>("fos-embedded/sample_source/frame.rs"),
        named::<Icm42688<(), ()>>("fos-embedded/sample_source/icm42688.rs"),
        named::<SampleSource<Part>>("fos-embedded/sample_source/mod.rs"),
        named::<Address>("fos-embedded/sample_source/st.rs"),
        named::<Lsm6dso<(), ()>>("fos-embedded/sample_source/st.rs"),
        named::<Lsm6dsv16x<(), ()>>("fos-embedded/sample_source/st.rs"),
        named::<SensorClock>("fos-embedded/sample_source/timeline.rs"),
        named::<ModelStore<NoFlash, 2048>>("fos-embedded/store.rs"),
        named::<StoreError<u8>>("fos-embedded/store.rs"),
        named::<Periods>("fos-embedded/streams.rs"),
        named::<StampedSample>("fos-embedded/streams.rs"),
        named::<StreamCounts>("fos-embedded/streams.rs"),
        named::<Streams<64>>("fos-embedded/streams.rs"),
        named::<AlarmRecorder<Vec<u8>, 320, 1, 8>>("fos-embedded/telemetry/alarm.rs"),
        named::<Recorder<Vec<u8>, 320>>("fos-embedded/telemetry/mod.rs"),
        named::<ImageReceiver<64>>("fos-embedded/telemetry/image.rs"),
        named::<Snapshot<8>>("fos-embedded/telemetry/snapshot.rs"),
        named::<telemetry::Borrowed<'_>>("fos-embedded/telemetry/mod.rs"),
        named::<SampleFrame<&[f32], &[Validity]>>("fos-embedded/telemetry/mod.rs"),
        named::<StartFrame<&str>>("fos-embedded/telemetry/mod.rs"),
        named::<TelemetryError<u8>>("fos-embedded/telemetry/mod.rs"),
        named::<HubDigest>("fos-embedded/test_log/digest.rs"),
        named::<PredictorDigest>("fos-embedded/test_log/digest.rs"),
        named::<TestLogError>("fos-embedded/test_log/fields.rs"),
        named::<HubLogHeader>("fos-embedded/test_log/hub_log.rs"),
        named::<HubLogRecord<'_>>("fos-embedded/test_log/hub_log.rs"),
        named::<PredictorLogHeader>("fos-embedded/test_log/predictor_header.rs"),
        named::<PredictorLogRecord<'_>>("fos-embedded/test_log/predictor_log.rs"),
        named::<CheckError>("fos-embedded/test_vector.rs"),
        named::<Expected>("fos-embedded/test_vector.rs"),
        named::<TestSample>("fos-embedded/test_vector.rs"),
        named::<TestVector<'_>>("fos-embedded/test_vector.rs"),
    ];
    types.into()
}

/// A type of a feature for hosts, and types without a value.
const NOT_LOGGED: [&str; 3] = [
    "fos-core/evaluator/coasts.rs Coasts",
    "fos-embedded/sample_source/lsm6dso.rs Lsm6dsoRegisters",
    "fos-embedded/sample_source/lsm6dsv16x.rs Lsm6dsv16xRegisters",
];

/// File and name of every public type in the lines of `source`.
fn public_types<'s>(file: &'s str, source: &'s str) -> impl Iterator<Item = String> + 's {
    source.lines().filter_map(move |line| {
        let line = line.trim_start();
        let rest =
            ["pub struct ", "pub enum ", "pub union "].iter().find_map(|start| line.strip_prefix(start));
        let name = rest?.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next()?;
        Some(format!("{file} {name}"))
    })
}

fn search(folder: &Path, name: &str, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = format!("{name}/{}", path.file_name().expect("a name").to_string_lossy());
        if path.is_dir() {
            search(&path, &name, found);
        } else {
            found.extend(public_types(&name, &std::fs::read_to_string(&path).expect("text")));
        }
    }
}

#[test]
fn every_public_type_can_be_logged() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let mut public = BTreeSet::new();
    for name in ["fos-core", "fos-embedded"] {
        search(&root.join(name).join("src"), name, &mut public);
    }
    for name in NOT_LOGGED {
        assert!(public.remove(name), "{name} is no type, or not public");
    }
    let loggable = loggable();
    let forgotten: Vec<_> = public.difference(&loggable).collect();
    let gone: Vec<_> = loggable.difference(&public).collect();
    assert!(forgotten.is_empty() && gone.is_empty(), "forgotten here: {forgotten:?}; gone: {gone:?}");
}

#[test]
fn detects_types_missing_from_the_list() {
    let source =
        "/// Text.\npub struct New<T> {\n    pub enum Inner;\npub(crate) struct Own;\nstruct Private;\n";
    let found: Vec<_> = public_types("a.rs", source).collect();
    assert_eq!(found, ["a.rs New", "a.rs Inner"]);
    assert!(found.iter().all(|name| !loggable().contains(name)));
}
