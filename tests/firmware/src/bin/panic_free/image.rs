//! Every function of fos-core that a device calls, on values unknown to the compiler.

use core::hint::black_box;

use fos_core::align::{Aligner, Stream};
use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, Correction, FittedOn, Fixed, Image, Info, InnovationStatistics, Input,
    Model, Monitor, Predictor, Quantity, Range, Sample, Scalar, Source, StillnessDetector, StillnessLimits,
    Term, Transform, Validity, u, y,
};
use fos_embedded::hub::{Hub, MAX_LOGGED, Motion};
use fos_embedded::raw::{Faults, RawSample, Scales, SiSample};
use fos_embedded::telemetry::{
    AlarmRecorder, Frame, HUB_AXES, Recorder, Snapshot, StartFrame, VERSION, encode as encode_frame,
};
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord, PredictorDigest};
use fos_embedded::test_vector::TestVector;

/// A model as `fos export --rust` writes it.
#[allow(dead_code, unreachable_pub, reason = "only the model is used")]
mod exported {
    include!("../../../../golden/model.rs");
}

type Device = Predictor<f32, 6, 16, 128, 256>;

unsafe extern "C" {
    /// Defined nowhere: an image in which a panic can be reached does not link.
    safe fn a_panic_can_be_reached() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    a_panic_can_be_reached()
}

pub(crate) fn exercise() {
    from_image(black_box(&[0; 64]));
    from_model();
    stillness();
    joined();
    written();
    hubs(black_box(&[0; 64]));
}

fn from_image(bytes: &[u8]) {
    let Ok(image) = Image::parse(bytes) else { return };
    black_box((image.period_s(), image.fitted_on(), image.stillness(), image.info()));
    for quantity in image.quantities() {
        black_box(quantity);
    }
    for input in image.inputs() {
        black_box(input);
    }
    for axis in image.axes() {
        let mut monitor = Monitor::new(&axis.parameters, image.period_s());
        if let Ok(mut predictor) = image.predictor::<f32, 6, 16, 128, 256>() {
            run(&mut predictor, &mut monitor);
        }
        black_box((axis.physical.count(), axis.stochastic.count()));
    }
}

fn run(predictor: &mut Device, monitor: &mut Monitor<f32>) {
    let values: [f32; 8] = black_box([0.0; 8]);
    let lengths: [usize; 3] = black_box([6, 8, 6]);
    let some = |length: usize| values.get(..length).unwrap_or(&[]);
    let sample = Sample { measured: some(lengths[0]), quantities: some(lengths[1]) };
    look(predictor.track(&sample), monitor);
    look(predictor.track_against(&sample, some(lengths[2])), monitor);
    look(predictor.coast(&sample), monitor);
    look(predictor.skip(black_box(3)), monitor);
    predictor.reset();
    black_box(predictor.n_axes());
    black_box(monitor.samples());
    black_box((monitor.statistics(), monitor.mean_in_unit()));
    black_box((monitor.deviation_ratio(), monitor.deviation_in_unit()));
    let _ = black_box(monitor.drift());
    monitor.restart();
}

fn look(corrections: &[Correction<f32>], monitor: &mut Monitor<f32>) {
    let mut digest = PredictorDigest::default();
    digest.update(corrections);
    black_box((digest.corrections(), digest.innovations()));
    for correction in corrections {
        let validity: Validity = correction.validity;
        for name in validity.names() {
            black_box(name);
        }
        black_box((correction.predicted, correction.innovation, correction.corrected, validity.bits()));
        black_box((validity.is_valid(), validity.contains(Validity::STUCK)));
        let _ = black_box(monitor.update(correction));
        let _ = black_box(validity | Validity::MISSING);
    }
}

const RANGE: Range<f32> = Range::new(-3.0, 3.0);

fn parameters() -> AxisParameters<f32> {
    AxisParameters {
        axis: black_box(Axis::Gx),
        reference: black_box(0.0),
        offset: black_box(0.0),
        scale: black_box(1.0),
        constant: black_box(0.0),
        range: black_box(RANGE),
        physical_range: black_box(RANGE),
        full_scale: black_box(0.0),
        stuck_after_repeats: black_box(0),
        gap_limit_samples: black_box(0),
        coast_limit_s: black_box(1.0),
        innovation: black_box(InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 }),
    }
}

fn input() -> Input<f32> {
    Input {
        source: black_box(Source::Quantity(0)),
        transform: black_box(Transform::Sine { frequency_hz: 16.0 }),
        centre: black_box(0.0),
        scale: black_box(1.0),
        source_range: black_box(RANGE),
        range: black_box(RANGE),
    }
}

/// Calls `with` on a model unknown to the compiler.
fn with_model(with: impl FnOnce(&Model<'_, f32>)) {
    let factors = black_box([y(1), u(0, 0), y(2)]);
    let Some(term) = Term::try_new(black_box(1.0), factors.get(..black_box(2)).unwrap_or(&[])) else {
        return;
    };
    let physical = black_box([term; 3]);
    let stochastic = black_box([term.with_coefficient(0.5_f32); 3]);
    let axes = [AxisModel { parameters: parameters(), physical: &physical, stochastic: &stochastic }; 2];
    let inputs = [input(); 3];
    let quantities = black_box([Quantity::Temperature; 3]);
    with(&Model {
        period_s: black_box(0.005),
        fitted_on: black_box(FittedOn::Raw),
        stillness: black_box(None),
        calibration: black_box(None),
        quantities: quantities.get(..black_box(3)).unwrap_or(&[]),
        inputs: inputs.get(..black_box(3)).unwrap_or(&[]),
        axes: axes.get(..black_box(2)).unwrap_or(&[]),
    });
}

fn from_model() {
    with_model(|model| {
        if let Ok(mut predictor) = Device::new(model) {
            run(&mut predictor, &mut Monitor::new(&parameters(), model.period_s));
        }
    });
}

fn written() {
    let mut buffer = black_box([0; 512]);
    let buffer = buffer.get_mut(..black_box(512)).unwrap_or_default();
    let info = black_box(Info { sensor: "sensor", ..Info::default() });
    with_model(|model| {
        if let Ok(image) = encode(model, &info, buffer) {
            black_box(image);
        }
    });
}

fn stillness() {
    let limits = black_box(StillnessLimits::<f32> {
        window: 100,
        accel_variance: 0.01,
        gyro_variance: 0.001,
        gyro_at_rest: [0.0; 3],
        gyro_deviation: 0.01,
    });
    if let Ok(mut detector) = StillnessDetector::<f32>::new(limits) {
        black_box(detector.update(black_box([0.0; 3]), black_box([0.0; 3])));
        black_box(detector.disturbed());
    }
}

fn joined() {
    let [stamp, period, index]: [i64; 3] = black_box([0; 3]);
    let (values, index) = (black_box([0.0_f32; 3]), index as usize);
    let mut aligner = Aligner::<f32, 2, 2, 32>::new([period; 2], [period; 2]);
    aligner.set_follower_period(index, period);
    aligner.set_slow_period(index, period);
    let _ = black_box(aligner.push_lead(stamp, values));
    let _ = black_box(aligner.push_follower(index, stamp, values));
    let _ = black_box(aligner.push_slow(index, stamp, values[0]));
    black_box((aligner.pop(), aligner.flush()));
    for stream in [Stream::Lead, Stream::Follower(index), Stream::Slow(index)] {
        black_box(aligner.counts(stream));
    }
}

/// A writer that accepts part of its input.
struct Writer;

impl embedded_io::ErrorType for Writer {
    type Error = embedded_io::ErrorKind;
}

impl embedded_io::Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, embedded_io::ErrorKind> {
        black_box(bytes);
        black_box(Ok(1))
    }

    fn flush(&mut self) -> Result<(), embedded_io::ErrorKind> {
        Ok(())
    }
}

fn hubs(bytes: &[u8]) {
    let scales = black_box(Scales {
        accel_mps2: 1.0,
        gyro_rads: 1.0,
        temperature_k: 1.0,
        temperature_zero_c: 25.0,
        period_s: 0.005,
        values: FittedOn::Raw,
    });
    let _ = black_box(hub::<Fixed>(bytes, scales));
    let mut hub = hub::<f32>(bytes, scales);
    let vector = black_box(TestVector {
        scales,
        channels: &[],
        given: &[],
        samples: &[],
        given_bits: &[],
        expected: &[],
    });
    black_box(vector.run(&mut hub).is_ok());
}

fn hub<R: Scalar<Stored = f32>>(bytes: &[u8], scales: Scales) -> Hub<16, 128, 256, R> {
    let mut hub: Hub<16, 128, 256, R> = Hub::new(scales);
    black_box(hub.load(bytes).is_ok());
    with_model(|model| {
        black_box(hub.load_model(model).is_ok());
        black_box(hub.load_checked(black_box(&exported::MODEL)).is_ok());
    });
    black_box(hub.give(black_box(Quantity::Supply), black_box(1.0)));
    black_box(hub.give_application(black_box(1), black_box(1.0)));
    hub.set_motion(black_box(Some(Motion::Still)));
    let raw = black_box(RawSample { temperature: Some(1), faults: Faults::BUS, ..RawSample::default() });
    let output = *hub.update(&raw);
    let sample = black_box(SiSample {
        skipped: 1,
        accel: [1.0; 3],
        gyro: [1.0; 3],
        temperature_c: 25.0,
        faults: Faults::empty(),
    });
    black_box(hub.update_si(&sample).predicted());
    hub.clock(black_box(1));
    black_box((output.accel(), output.gyro(), output.is_valid(), hub.rate_hz()));
    for axis in black_box([Axis::Gx, Axis::Other]) {
        let _ = black_box((hub.drift(axis), hub.statistics(axis), hub.deviation_ratio(axis)));
    }
    hub.restart_watch();
    let logged = hub.logged();
    let names = hub.columns::<64>(&black_box(Info::default()));

    let start = StartFrame {
        version: VERSION,
        period_s: black_box(0.005),
        axes: HUB_AXES,
        quantities: names.as_deref().unwrap_or(""),
    };
    let mut alarmed: AlarmRecorder<_, 320, 4, 8> = AlarmRecorder::new(Recorder::new(Writer), black_box(8));
    black_box(alarmed.sample(&start, &output, &logged).is_ok());
    alarmed.trigger();
    black_box((alarmed.is_sending(), alarmed.recorder().failed()));
    let mut buffer = black_box([0; 320]);
    let room = buffer.get_mut(..black_box(320)).unwrap_or_default();
    let snapshot: Snapshot<MAX_LOGGED> = Snapshot::new(&output, &logged);
    black_box(encode_frame(&Frame::Sample(snapshot.frame()), room).map(<[u8]>::len));

    let mut given = black_box([0.0; 16]);
    if let (Ok(header), Ok(record)) = (HubLogHeader::decode(bytes), HubLogRecord::decode(bytes, &mut given)) {
        black_box((header.encode(), header.record_length()));
        for byte in record.encode() {
            black_box(byte);
        }
        let mut digest = HubDigest::default();
        digest.update(record.step(&mut hub));
        black_box(digest.outputs());
    }
    hub
}
