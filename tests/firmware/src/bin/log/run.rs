//! One event after the other, each logged by the library or here.

// the critical section required by the encoder, and the sink of its frames
use cortex_m as _;
use defmt_semihosting as _;

use defmt::info;
use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Image, Info, InnovationStatistics, Model, Range, Sample, Term,
    Validity, y,
};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::hub::{Hub, Motion};
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_embedded::sample_source::SampleSource;
use fos_embedded::store::ModelStore;
use fos_firmware::fail;

use super::flash::{PAGE, RamFlash};
use super::sensor::{SCALES, Sensor};

static TERMS: [Term<f32>; 2] = [Term::new(0.5, &[y(1)]), Term::new(-0.25, &[y(2)])];

static GYRO_Z: AxisModel<'_, f32> = AxisModel {
    parameters: AxisParameters {
        axis: Axis::Gz,
        reference: 0.0,
        offset: 0.25,
        scale: 0.5,
        constant: 0.0,
        range: Range::new(-4.0, 4.0),
        physical_range: Range::new(0.0, 0.0),
        full_scale: 16.0,
        stuck_after_repeats: 50,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
    },
    physical: &[],
    stochastic: &TERMS,
};

static MODEL: Model<'_, f32> = Model {
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: None,
    calibration: None,
    quantities: &[],
    inputs: &[],
    axes: &[GYRO_Z],
};

/// At rest with noise of two values: of 0.5 rad/s on gyro z, about its offset.
fn at_rest(n: u16, shift: i16) -> RawSample {
    let noise = if n % 3 == 0 { 1000 } else { -500 };
    RawSample {
        accel: [0, 0, 9810],
        gyro: [0, 0, 500 + shift + noise],
        temperature: Some(256),
        ..RawSample::default()
    }
}

pub(crate) fn run() {
    let mut buffer = [0; 256];
    let Ok(image) = encode(&MODEL, &Info::default(), &mut buffer) else { fail(format_args!("it fits")) };
    let mut damaged = [0; 256];
    let damaged = &mut damaged[..image.len()];
    damaged.copy_from_slice(image);
    damaged[30] ^= 1;

    models(image, damaged);
    samples(image);
    sensor();
    flash(image, damaged);
}

fn models(image: &[u8], damaged: &[u8]) {
    info!("an image: {}, a term: {}", Image::parse(image), TERMS[0]);
    let mut hub: Hub<1, 2, 4> = Hub::new(SCALES);
    info!("it loads: {}", hub.load(image));
    info!("damaged: {}", hub.load(damaged));
    info!("{}", hub);
    let mut hub: Hub<1, 1, 4> = Hub::new(SCALES);
    info!("with less room: {}", hub.load(image));
    let factory = Scales { values: FittedOn::FactoryCorrected, ..SCALES };
    let mut hub: Hub<1, 2, 4> = Hub::new(factory);
    info!("of another sensor: {}", hub.load_model(&MODEL));
}

fn samples(image: &[u8]) {
    let Ok(parsed) = Image::parse(image) else { fail(format_args!("an image")) };
    let Ok(mut predictor) = parsed.predictor::<f32, 1, 1, 2, 4>() else { fail(format_args!("it fits")) };
    for measured in [0.5, 0.75, 0.5] {
        let corrections = predictor.track(&Sample { measured: &[measured], quantities: &[] });
        info!("a correction: {}", corrections[0]);
    }

    let mut hub: Hub<1, 2, 4> = Hub::new(SCALES);
    let _ = hub.load(image);
    hub.set_motion(Some(Motion::Still));
    for n in 0..200 {
        let _ = hub.update(&at_rest(n, 0));
    }
    info!("still: {}", *hub.output());
    let raw = RawSample { skipped: 30, faults: Faults::BUS | Faults::GAP, ..at_rest(0, 0) };
    let output = hub.update(&raw);
    info!("after a gap: {}, gyro z {}", output.faults, output.validity()[5]);
    hub.clock(0);
    for n in 0..400 {
        let _ = hub.update(&at_rest(n, 0));
    }
    // 400 samples in 10 s
    hub.clock(10_000_000);
    for n in 0..400 {
        let _ = hub.update(&at_rest(n, 500));
    }
    hub.clock(20_000_000);
    info!("{}", hub);
    info!("nothing: {} {}", Validity::VALID, Faults::empty());
}

fn sensor() {
    let mut source = SampleSource::new(Sensor::new());
    for poll in 0..12 {
        let polled = poll_once(source.poll(poll * 50_000));
        if let Some(Ok([.., last])) = polled {
            info!("poll {=u64}, the last sample: {}", poll, last);
        }
    }
    info!("{}", source);
}

fn flash(image: &[u8], damaged: &[u8]) {
    let Ok(mut store) = ModelStore::<_, 256>::new(Blocking(RamFlash::new()), 0..4 * PAGE as u32) else {
        fail(format_args!("whole pages"))
    };
    info!("stored: {}", poll_once(store.store(image)));
    info!("damaged: {}", poll_once(store.store(damaged)));
    info!("stored: {}", poll_once(store.store(image)));
    let slots = 0..4 * PAGE as u32;
    let mut flash = store.release().0;
    flash.corrupt(2 * PAGE..4 * PAGE);
    let Ok(mut store) = ModelStore::<_, 256>::new(Blocking(flash), slots) else {
        fail(format_args!("whole pages"))
    };
    info!("an image is left: {}", matches!(poll_once(store.load()), Some(Ok(Some(_)))));
    info!("{}", store);
}
