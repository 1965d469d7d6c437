//! The loop from the device back to the host: a device sends its measurements, the host converts them to a log and
//! identifies the missing effect.

use std::io::BufReader;

use embedded_io::{ErrorKind, ErrorType, Write};
use fos_core::{Image, Predictor, Sample, Validity};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_device_io::record::record;
use fos_diagnose::detect::{Question, Verdict, diagnose};
use fos_diagnose::effects::Library;
use fos_embedded::telemetry::{Recorder, SampleFrame, StartFrame, TelemetryError, VERSION};
use fos_export::image;
use fos_fit::fit::{FitOptions, fit_axis};
use fos_simulate::{Axis, CasePlan, Effect, Plant, Setup, simulate_case};

/// A cable that occasionally loses a byte.
struct Cable {
    bytes: Vec<u8>,
    sent: usize,
    loses_every: usize,
}

impl ErrorType for Cable {
    type Error = ErrorKind;
}

impl Write for Cable {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        for byte in bytes {
            self.sent += 1;
            if !self.sent.is_multiple_of(self.loses_every) {
                self.bytes.push(*byte);
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

fn recording(name: &str, columns: Vec<(String, Vec<f64>)>) -> Recording {
    let options = LoadOptions { rate_hz: Some(200.0), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by(name), columns, &options).expect("a log")
}

#[test]
fn identifies_a_hidden_effect_from_telemetry() {
    let mut plan = CasePlan::new(8, "bmi270", Setup::Bench, Axis::named("gx").expect("an axis"));
    plan.planted.push(Plant { effect: Effect::ThermalLag, parameter: Some(60.0), size: 120.0 });
    let case = simulate_case(&plan).expect("a case");
    let reference = recording("reference", case.reference);
    let fitted =
        fit_axis(&reference, &stillness::find(&reference), "gx", &FitOptions::default()).expect("a fit");
    let bytes = image(&fitted.model, "simulated", "").expect("an image");

    // on the device
    let field = recording("field", case.log);
    let column = |name: &str| field.held(field.channel(name).expect("a column"));
    let (rate, temperature) = (column("gx_rads"), column("temp_c"));
    let mut predictor: Predictor<f32, 6, 16, 128, 256> =
        Image::parse(&bytes).expect("an image").predictor().expect("it fits");
    let start = StartFrame {
        version: VERSION,
        period_s: field.rate.period_s as f32,
        axes: "gx_rads",
        quantities: "temp_c",
    };
    let cable = Cable { bytes: Vec::new(), sent: 0, loses_every: 40_009 };
    let mut recorder: Recorder<_, 128> = Recorder::new(cable);
    for (tick, (rate, celsius)) in rate.iter().zip(temperature.iter()).enumerate() {
        let quantities = [*celsius as f32];
        let sample = Sample { measured: &[*rate as f32], quantities: &quantities };
        let correction = predictor.track(&sample)[0];
        let validity = [correction.validity];
        let frame = SampleFrame {
            tick: tick as u32,
            still: true,
            measured: sample.measured,
            quantities: sample.quantities,
            innovations: &[correction.innovation.unwrap_or(f32::NAN)],
            validity: validity.as_slice(),
        };
        recorder.sample(&start, frame).expect("sent");
    }
    let cable = recorder.release();

    // on the host
    let recorded = record(BufReader::new(&cable.bytes[..])).expect("a log");
    let report = &recorded.report;
    let lost_bytes = (cable.sent / cable.loses_every) as u64;
    assert!(lost_bytes > 100, "the cable is bad enough: {lost_bytes}");
    // a lost delimiter costs two frames
    assert!((lost_bytes / 2..=2 * lost_bytes).contains(&report.lost), "{report:?}, {lost_bytes} bytes lost");
    assert!(report.samples + report.lost + 2 >= rate.len() as u64, "{report:?}");
    let log = recording("telemetry", recorded.columns);
    assert!(log.segments.len() > 50, "lost frames are gaps: {}", log.segments.len());
    let library = Library::built_in();
    let question = Question { reference: Some(&reference), ..Question::new(&log, "gx_rads", &library) };
    let answer = diagnose(&question).expect("an answer");
    let named: Vec<&str> = answer.findings.iter().map(|finding| finding.effect.as_str()).collect();
    assert_eq!(answer.verdict, Verdict::Missing, "{}", answer.sentence);
    assert!(named.contains(&"thermal_lag"), "{named:?}");
}

/// A stream that accepts no more bytes.
struct Full;

impl ErrorType for Full {
    type Error = ErrorKind;
}

impl Write for Full {
    fn write(&mut self, _: &[u8]) -> Result<usize, ErrorKind> {
        Err(ErrorKind::OutOfMemory)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

#[test]
fn counts_unsent_frames() {
    let start = StartFrame { version: VERSION, period_s: 0.005, axes: "gx_rads", quantities: "" };
    let (measured, validity) = ([0.1], [Validity::VALID]);
    let frame = |tick| SampleFrame {
        tick,
        still: true,
        measured: measured.as_slice(),
        quantities: &[],
        innovations: measured.as_slice(),
        validity: validity.as_slice(),
    };
    let mut full: Recorder<_, 128> = Recorder::new(Full);
    for tick in 0..3 {
        let result = full.sample(&start, frame(tick));
        assert_eq!(result, Err(TelemetryError::Stream(ErrorKind::OutOfMemory)));
    }
    assert_eq!(full.failed(), 6, "every sample, and with it what it holds");
    let cable = Cable { bytes: Vec::new(), sent: 0, loses_every: usize::MAX };
    let mut small: Recorder<_, 8> = Recorder::new(cable);
    assert_eq!(small.sample(&start, frame(0)), Err(TelemetryError::TooLong));
    assert!(small.release().bytes.is_empty(), "no half frame");
}
