//! The hub against its documentation: the same bits as a predictor driven by hand, and close to a naive twin in f64.
#![no_main]

use fos_core::image::encode;
use fos_core::{
    Correction, FittedOn, Fixed, Info, Quantity, Scalar, Sample, Source, StillnessDetector, StillnessLimits, Transform,
    Validity,
};
use fos_embedded::hub::{Hub, Motion, OTHER_POSE, Output, SIX};
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_fuzz::drawn::{between, events, model};
use fos_testkit::models::{Draw, OwnedModel, Roomy};
use fos_fuzz::twin::{Event, Twin};
use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;

/// Temperature codes are exact in f32, so that a rate does not magnify their rounding.
const SCALES: Scales = Scales {
    accel_mps2: 0.001,
    gyro_rads: 0.001,
    temperature_k: 1.0 / 16_384.0,
    temperature_zero_c: 0.0,
    period_s: 0.005,
    values: FittedOn::Raw,
};

/// Largest difference between f32 and f64, in the axis' unit: 6e-8 of inputs up to 3.3, a hundredfold in a rate over 10
/// ms, times up to 90 in a product of three, in eight terms, fed back with 0.8, times a scale of 2.
const TOLERANCE: f64 = 0.05;

#[derive(Debug, Clone)]
enum Happens {
    /// Measured values in scaled units; beyond the codes they are at full scale.
    Sample {
        measured: [f64; 6],
        temperature: Option<i16>,
        skipped: u32,
        faults: u16,
    },
    Motion(Option<bool>),
    Give(f32, f32),
    Clock(u64),
    Load,
}

fn event(bytes: &mut Unstructured<'_>) -> Result<Happens> {
    let usual = |bytes: &mut Unstructured<'_>| -> Result<[f64; 6]> {
        let mut measured = [0.0; 6];
        for value in &mut measured {
            *value = between(bytes, -1.5, 1.5)?;
        }
        Ok(measured)
    };
    Ok(match bytes.int_in_range(0..=31_u8)? {
        0..20 => Happens::Sample {
            measured: usual(bytes)?,
            temperature: Some(bytes.arbitrary()?),
            skipped: 0,
            faults: 0,
        },
        20..26 => {
            let mut measured = usual(bytes)?;
            let [wild, far] = bytes.arbitrary::<[u8; 2]>()?;
            if let Some(value) = measured.get_mut(usize::from(wild)) {
                *value = f64::from(far) - 128.0;
            }
            let skipped = match bytes.arbitrary::<u8>()? {
                0..20 => bytes.int_in_range(1..=29)?,
                20..23 => bytes.arbitrary()?,
                _ => 0,
            };
            let faults = if bytes.ratio(1, 10)? { bytes.arbitrary()? } else { 0 };
            Happens::Sample { measured, temperature: bytes.arbitrary()?, skipped, faults }
        }
        26..28 => Happens::Motion(bytes.arbitrary()?),
        28 => Happens::Give(bytes.arbitrary()?, between(bytes, -2.5, 2.5)? as f32),
        29 => Happens::Clock(bytes.arbitrary()?),
        30 => Happens::Clock(bytes.arbitrary::<u32>()?.into()),
        _ => Happens::Load,
    })
}

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let stillness = bytes.arbitrary().unwrap_or(false).then_some(StillnessLimits {
        window: 10,
        accel_variance: 20.0,
        gyro_variance: 20.0,
        gyro_at_rest: [0.0; 3],
        gyro_deviation: 10.0,
    });
    let Ok(mut model) = model(&mut bytes, Draw::Contracting) else { return };
    for (axis, name) in model.axes.iter_mut().zip(SIX) {
        axis.parameters.axis = name;
    }
    let mut single = model.convert::<f32>();
    single.stillness = stillness;
    let mut buffer = vec![0; 1 << 16];
    let image = single.borrow(|model| encode(model, &Info::default(), &mut buffer).expect("room").to_vec());
    let mut expected = Expected::new(&single);
    let mut hub: Hub<8, 128, 256> = Hub::new(SCALES);
    let mut fixed: Hub<8, 128, 256, Fixed> = Hub::new(SCALES);
    // A model that does not fit is refused, and the hub then passes measurements through.
    let _ = fixed.load(&image);
    let (mut ticks, mut since_power_on) = (0_u32, 0_u32);
    hub.load(&image).expect("a model that the predictor takes");
    for event in events(&mut bytes, event) {
        match event {
            Happens::Sample { measured, temperature, skipped, faults } => {
                let code = |axis: usize| expected.code(axis, measured[axis]);
                let raw = RawSample {
                    skipped,
                    accel: [code(0), code(1), code(2)],
                    gyro: [code(3), code(4), code(5)],
                    temperature,
                    faults: Faults::from_bits_truncate(faults),
                };
                let output = *hub.update(&raw);
                assert!(output.corrected().iter().all(|value| value.is_finite()));
                let passed = raw.skipped.saturating_add(1);
                (ticks, since_power_on) = (ticks.wrapping_add(passed), since_power_on.saturating_add(passed));
                assert_eq!(output.tick, ticks.wrapping_sub(1));
                in_fixed_point(&mut fixed, &raw, &output);
                let mut faults = raw.faults;
                faults.set(Faults::GAP, faults.contains(Faults::GAP) || skipped > 0);
                let saturated = output.validity().iter().any(|validity| validity.contains(Validity::SATURATED));
                faults.set(Faults::SATURATED, faults.contains(Faults::SATURATED) || saturated);
                // The clock error is not modelled here.
                assert_eq!(output.faults - Faults::RATE, faults - Faults::RATE);
                let (still, corrections) = expected.sample(&raw);
                assert_eq!(output.still, still);
                for (axis, correction) in corrections.iter().enumerate() {
                    let mut validity = correction.validity;
                    validity |=
                        if raw.faults.contains(Faults::STUCK) { Validity::STUCK } else { Validity::VALID };
                    assert_eq!(
                        output.corrected()[axis].to_bits(),
                        correction.corrected.to_bits(),
                        "axis {axis}"
                    );
                    assert_eq!(output.validity()[axis], validity, "axis {axis}");
                    let innovation = Some(output.innovation()[axis]).filter(|value| !value.is_nan());
                    assert_eq!(innovation, correction.innovation, "axis {axis}");
                }
            }
            Happens::Motion(still) => {
                let motion = still.map(|still| if still { Motion::Still } else { Motion::Moving });
                hub.set_motion(motion);
                fixed.set_motion(motion);
                expected.set_motion(motion);
            }
            Happens::Give(supply, load) => {
                hub.give(Quantity::Supply, supply);
                hub.give(Quantity::Load, load);
                fixed.give(Quantity::Supply, supply);
                fixed.give(Quantity::Load, load);
                expected.given = [supply, load];
            }
            Happens::Clock(now_us) => {
                hub.clock(now_us);
                fixed.clock(now_us);
                assert!(hub.rate_hz().is_none_or(f32::is_finite));
            }
            Happens::Load => {
                hub.load(&image).expect("as before");
                let _ = fixed.load(&image);
                let motion = expected.motion;
                expected = Expected::new(&single);
                expected.motion = motion;
                expected.begin_after(since_power_on);
            }
        }
    }
});

/// In fixed point, any input gives finite output, with the same statements about the sample as in f32.
fn in_fixed_point(hub: &mut Hub<8, 128, 256, Fixed>, raw: &RawSample, single: &Output) {
    let output = *hub.update(raw);
    let corrections = output.corrections.iter();
    assert!(corrections.clone().all(|axis| axis.corrected.is_finite() && axis.predicted.is_finite()));
    assert!(corrections.clone().all(|axis| axis.innovation.is_none_or(Fixed::is_finite)));
    assert_eq!(output.tick, single.tick);
    let sample = Faults::GAP | Faults::BUS | Faults::STUCK | Faults::RESET | Faults::OVERRUN;
    assert_eq!(output.faults & sample, single.faults & sample);
}

/// Expected output of the hub.
struct Expected {
    model: OwnedModel<f32>,
    predictor: Roomy<f32>,
    /// None if rounding errors may grow: after a steep transform of the fed-back output.
    twin: Option<Twin>,
    detector: Option<StillnessDetector<f32>>,
    motion: Option<Motion>,
    given: [f32; 2],
    in_pose: Vec<bool>,
}

impl Expected {
    fn new(model: &OwnedModel<f32>) -> Self {
        let steep = model.inputs.iter().any(|input| {
            matches!(input.source, Source::Remainder(_))
                && matches!(input.transform, Transform::Rate { .. } | Transform::Variance { .. })
        });
        Self {
            predictor: model.predictor().expect("a model"),
            twin: (!steep).then(|| Twin::new(&model.convert())),
            detector: model.stillness.and_then(|limits| StillnessDetector::new(limits).ok()),
            motion: None,
            given: [f32::NAN; 2],
            // The orientation of an accelerometer is not known yet; a gyro has none.
            in_pose: (0..model.axes.len()).map(|axis| axis >= 3).collect(),
            model: model.clone(),
        }
    }

    /// Advances the clocks.
    fn begin_after(&mut self, ticks: u32) {
        self.predictor.begin_after(ticks);
        // Restarts the twin.
        self.twin = self
            .twin
            .take()
            .filter(|_| ticks == 0 || !self.model.inputs.iter().any(|input| input.source == Source::Clock));
    }

    fn set_motion(&mut self, motion: Option<Motion>) {
        if motion != self.motion {
            self.disturb();
        }
        self.motion = motion;
    }

    fn disturb(&mut self) {
        if let Some(detector) = &mut self.detector {
            detector.disturbed();
        }
    }

    /// Code of a measured value in scaled units.
    fn code(&self, axis: usize, scaled: f64) -> i16 {
        let (at, scale) = self.model.axes.get(axis).map_or((0.0, 1.0), |axis| {
            (axis.parameters.reference + axis.parameters.offset, axis.parameters.scale)
        });
        ((f64::from(at) + scaled * f64::from(scale)) / 0.001).round() as i16
    }

    fn sample(&mut self, raw: &RawSample) -> (bool, Vec<Correction<f32>>) {
        if raw.skipped > 0 {
            let _ = self.predictor.skip(raw.skipped);
            match &mut self.twin {
                // The twin executes every step.
                Some(twin) if raw.skipped < 3000 => {
                    twin.run(&Event::Skip(raw.skipped));
                }
                twin => *twin = None,
            }
        }
        if raw.skipped > 0 || raw.faults.contains(Faults::STUCK) {
            self.disturb();
        }
        let measured = SCALES.measured(raw);
        let [ax, ay, az, gx, gy, gz] = measured;
        let still = !raw.faults.contains(Faults::STUCK)
            && match (self.motion, &mut self.detector) {
                (Some(motion), _) => motion == Motion::Still,
                (None, Some(detector)) => detector.update([ax, ay, az], [gx, gy, gz]),
                (None, None) => false,
            };
        let quantities = [SCALES.temperature_c(raw), self.given[0], self.given[1]];
        let sample = Sample { measured: &measured[..self.model.axes.len()], quantities: &quantities };
        let bits =
            self.in_pose.iter().rev().fold(0, |bits, &in_pose| bits << 1 | u32::from(in_pose && still));
        let corrections = self.predictor.track_some(&sample, bits).to_vec();
        self.hold_against_twin(&measured, &quantities, bits, &corrections);
        self.in_pose = self
            .model
            .axes
            .iter()
            .zip(&corrections)
            .enumerate()
            .map(|(index, (axis, correction))| {
                let limit = OTHER_POSE as f32 * axis.parameters.scale;
                index >= 3 || (correction.corrected - axis.parameters.reference).abs() <= limit
            })
            .collect();
        // An accelerometer outside its orientation affects the others.
        let accelerometers = self.in_pose.len().min(3);
        if self.in_pose[..accelerometers].contains(&false) {
            self.in_pose[..accelerometers].fill(false);
        }
        (still, corrections)
    }

    fn hold_against_twin(
        &mut self,
        measured: &[f32],
        quantities: &[f32],
        tracked: u32,
        corrections: &[Correction<f32>],
    ) {
        let Some(twin) = &mut self.twin else { return };
        let axes = self.model.axes.iter().zip(measured).enumerate();
        let (measured, reference) = axes
            .map(|(index, (axis, &measured))| {
                let [at, offset, scale] =
                    [axis.parameters.reference, axis.parameters.offset, axis.parameters.scale].map(f64::from);
                let known = tracked >> index & 1 == 1;
                ((f64::from(measured) - at - offset) / scale, if known { at } else { f64::NAN })
            })
            .unzip();
        let quantities = quantities.iter().map(|&value| f64::from(value)).collect();
        let expected = twin.run(&Event::TrackAgainst { measured, quantities, reference });
        // A value near a limit may fall on either side by rounding.
        let limits = Validity::INPUT_OUT_OF_RANGE | Validity::OUTPUT_OUT_OF_RANGE;
        for (found, expected) in corrections.iter().zip(&expected) {
            let off = (f64::from(found.predicted) - expected.predicted).abs();
            assert!(off <= TOLERANCE, "{found:?}, expected {expected:?}");
            let bits = |validity: Validity| validity.bits() & !limits.bits();
            assert_eq!(bits(found.validity), bits(expected.validity), "{found:?}, expected {expected:?}");
        }
    }
}
