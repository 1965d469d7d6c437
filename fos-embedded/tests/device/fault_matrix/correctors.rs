//! Correctors in the view of the matrix: one tick in, predicted errors and flags out.

use fos_core::{Monitor, Predictor, Quantity, Sample, Validity};
use fos_embedded::hub::AXES;
use fos_embedded::raw::{Faults, RawSample};

use super::faults::Tick;
use super::places::image;
use crate::models::{AT_REST, OFFSET, SCALES, SIX, SPREAD, TestHub, parameters};

pub(crate) type Roomy = Predictor<f32, AXES, 8, 64, 128>;

/// Output at one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Out {
    /// Predicted error of each axis.
    pub(crate) predicted: [f32; AXES],
    /// Innovation of each axis, if known.
    pub(crate) innovation: [Option<f32>; AXES],
    /// Stillness, and below temperature, as reported by the hub.
    pub(crate) still: bool,
    pub(crate) temperature_c: Option<f32>,
    /// Running means of the monitors, in standard deviations of the fit.
    pub(crate) means: [f32; AXES],
    /// All other numbers are finite.
    pub(crate) finite: bool,
    pub(crate) validity: [Validity; AXES],
    pub(crate) faults: Faults,
    pub(crate) drift: bool,
    /// The monitor did not count the sample.
    pub(crate) excluded: bool,
    /// Validity of the missing samples before this one.
    pub(crate) of_gap: [Validity; AXES],
}

impl Out {
    /// No prediction, no flags.
    const NOTHING: Self = Self {
        predicted: [0.0; AXES],
        innovation: [None; AXES],
        still: true,
        temperature_c: None,
        means: [0.0; AXES],
        finite: true,
        validity: [Validity::VALID; AXES],
        faults: Faults::empty(),
        drift: false,
        excluded: false,
        of_gap: [Validity::VALID; AXES],
    };
}

pub(crate) trait Corrector {
    fn step(&mut self, tick: &Tick) -> Out;

    /// Clears an alarm.
    fn restart(&mut self) {}
}

/// The predictor, with monitors if present.
pub(crate) struct Predicting {
    pub(crate) predictor: Roomy,
    /// Selects its measured values.
    pub(crate) reads: fn(&Tick) -> [f32; AXES],
    pub(crate) monitors: Option<[Monitor<f32>; AXES]>,
}

impl Corrector for Predicting {
    fn step(&mut self, tick: &Tick) -> Out {
        if tick.reset {
            self.predictor.reset();
        }
        let mut out = Out::NOTHING;
        if tick.skipped > 0 {
            for (validity, correction) in out.of_gap.iter_mut().zip(self.predictor.skip(tick.skipped)) {
                *validity = correction.validity;
            }
        }
        let measured = (self.reads)(tick);
        let sample = Sample { measured: &measured, quantities: &[tick.temperature, tick.supply] };
        let corrections =
            if tick.moving { self.predictor.coast(&sample) } else { self.predictor.track(&sample) };
        for (axis, correction) in corrections.iter().enumerate() {
            (out.predicted[axis], out.innovation[axis]) = (correction.predicted, correction.innovation);
            out.finite &=
                correction.corrected.is_finite() && correction.innovation.is_none_or(f32::is_finite);
            out.validity[axis] = correction.validity;
            let Some(monitors) = &mut self.monitors else { continue };
            let monitor = &mut monitors[axis];
            let before = monitor.samples();
            let drift = monitor.update(correction);
            let statistics = monitor.statistics();
            out.finite &= statistics.mean.is_finite()
                && statistics.variance.is_finite()
                && statistics.lag_1_correlation.abs() <= 1.0;
            let fitted = parameters(SIX[axis]).innovation;
            out.means[axis] = (statistics.mean - fitted.mean) / fitted.variance.sqrt();
            out.drift |= drift.mean || drift.variance;
            out.excluded |= monitor.samples() == before;
        }
        if self.monitors.is_some() {
            // only the output of the monitor
            (out.predicted, out.innovation) = ([0.0; AXES], [None; AXES]);
            (out.validity, out.of_gap) = ([Validity::VALID; AXES], [Validity::VALID; AXES]);
        }
        out
    }

    fn restart(&mut self) {
        self.monitors.iter_mut().flatten().for_each(Monitor::restart);
    }
}

/// Undisturbed axes at rest.
pub(crate) fn quiet(tick: &Tick) -> [f32; AXES] {
    core::array::from_fn(|axis| AT_REST[axis] + OFFSET[axis] + (tick.index % 3) as f32 * SPREAD[axis])
}

/// Codes of a sensor.
pub(crate) fn raw(tick: &Tick) -> RawSample {
    let mut codes = [0; AXES];
    for (axis, code) in codes.iter_mut().enumerate() {
        let lsb = if axis < 3 { SCALES.accel_mps2 } else { SCALES.gyro_rads };
        // codes cannot be NaN, so non-finite values are replaced
        let value = if tick.axes[axis].is_finite() { tick.axes[axis] } else { quiet(tick)[axis] };
        *code = (value / lsb).round() as i16;
    }
    let [ax, ay, az, gx, gy, gz] = codes;
    let temperature = (tick.temperature - SCALES.temperature_zero_c) / SCALES.temperature_k;
    RawSample {
        skipped: tick.skipped,
        accel: [ax, ay, az],
        gyro: [gx, gy, gz],
        temperature: temperature.is_finite().then_some(temperature.round() as i16),
        // every flag must come from the hub itself
        faults: Faults::empty(),
    }
}

/// Samples between readings of the clock.
pub(crate) const POLL: usize = 10;

impl Corrector for TestHub {
    fn step(&mut self, tick: &Tick) -> Out {
        if tick.reset {
            self.load(&image()).expect("as before");
        }
        self.give(Quantity::Supply, tick.supply);
        let output = *self.update(&raw(tick));
        if tick.index % POLL == POLL - 1 {
            self.clock(tick.clock_us);
        }
        let known = |value: f32| Some(value).filter(|value| !value.is_nan());
        let rest = output.innovation().iter().all(|value| value.is_nan() || value.is_finite());
        Out {
            predicted: core::array::from_fn(|axis| output.measured[axis] - output.corrected()[axis]),
            innovation: output.innovation().map(known),
            still: output.still,
            temperature_c: known(output.temperature_c),
            means: [0.0; AXES],
            finite: rest && output.corrected().iter().chain(&output.measured).all(|value| value.is_finite()),
            validity: output.validity(),
            faults: output.faults,
            drift: output.drift,
            excluded: false,
            of_gap: [Validity::VALID; AXES],
        }
    }

    fn restart(&mut self) {
        self.restart_watch();
    }
}

/// A naive bias estimate by an exponential average of the error, without flags or recovery.
pub(crate) struct Naive {
    pub(crate) bias: [f32; AXES],
    pub(crate) gain: f32,
    /// Limit of the error; the plain average has none.
    pub(crate) clamp_at: Option<f32>,
}

impl Corrector for Naive {
    fn step(&mut self, tick: &Tick) -> Out {
        for (axis, bias) in self.bias.iter_mut().enumerate() {
            let error = tick.axes[axis] - AT_REST[axis] - *bias;
            *bias += self.gain
                * match self.clamp_at {
                    None => error,
                    Some(_) if error.is_nan() => 0.0,
                    Some(limit) => error.clamp(-limit, limit),
                };
        }
        Out { predicted: self.bias, ..Out::NOTHING }
    }
}
