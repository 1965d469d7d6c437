//! Whoever corrects, as the matrix sees it: one tick in, what is taken off and what is said of it out.

use fos_core::{Monitor, Predictor, Quantity, Sample, Validity};
use fos_embedded::hub::AXES;
use fos_embedded::raw::{Faults, RawSample};

use super::faults::Tick;
use super::places::image;
use crate::models::{AT_REST, OFFSET, SCALES, SIX, SPREAD, TestHub, parameters};

pub(crate) type Roomy = Predictor<f32, AXES, 8, 64, 128>;

/// What comes out at one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Out {
    /// What is taken off each axis.
    pub(crate) predicted: [f32; AXES],
    /// Where it is known.
    pub(crate) innovation: [Option<f32>; AXES],
    /// As the hub says them.
    pub(crate) still: bool,
    pub(crate) temperature_c: Option<f32>,
    /// The monitors' running means, in standard deviations of the fit.
    pub(crate) means: [f32; AXES],
    /// All other numbers are finite.
    pub(crate) finite: bool,
    pub(crate) validity: [Validity; AXES],
    pub(crate) faults: Faults,
    pub(crate) drift: bool,
    /// It did not count for the monitor.
    pub(crate) left_out: bool,
    /// What was said of the samples that were missing before it.
    pub(crate) of_gap: [Validity; AXES],
}

impl Out {
    /// Nothing taken off, nothing said.
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
        left_out: false,
        of_gap: [Validity::VALID; AXES],
    };
}

pub(crate) trait Corrector {
    fn step(&mut self, tick: &Tick) -> Out;

    /// Forgets an alarm.
    fn restart(&mut self) {}
}

/// The predictor, and the monitors behind it.
pub(crate) struct Predicting {
    pub(crate) predictor: Roomy,
    /// The measured values that it gets.
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
            out.left_out |= monitor.samples() == before;
        }
        if self.monitors.is_some() {
            // the monitor's own word alone
            (out.predicted, out.innovation) = ([0.0; AXES], [None; AXES]);
            (out.validity, out.of_gap) = ([Validity::VALID; AXES], [Validity::VALID; AXES]);
        }
        out
    }

    fn restart(&mut self) {
        self.monitors.iter_mut().flatten().for_each(Monitor::restart);
    }
}

/// Axes at rest on which nothing happens.
pub(crate) fn quiet(tick: &Tick) -> [f32; AXES] {
    core::array::from_fn(|axis| AT_REST[axis] + OFFSET[axis] + (tick.index % 3) as f32 * SPREAD[axis])
}

/// Codes, as a sensor gives them.
pub(crate) fn raw(tick: &Tick) -> RawSample {
    let mut codes = [0; AXES];
    for (axis, code) in codes.iter_mut().enumerate() {
        let lsb = if axis < 3 { SCALES.accel_mps2 } else { SCALES.gyro_rads };
        // no code is NaN: what is not finite comes by another way
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
        // what is flagged, the hub has found itself
        faults: Faults::empty(),
    }
}

/// The clock is looked at after so many samples.
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
            left_out: false,
            of_gap: [Validity::VALID; AXES],
        }
    }

    fn restart(&mut self) {
        self.restart_watch();
    }
}

/// A bias by an exponential average of the error, as it is written in an afternoon: it has no flags, and forgets
/// nothing.
pub(crate) struct Naive {
    pub(crate) bias: [f32; AXES],
    pub(crate) gain: f32,
    /// An error counts for at most so much; a check that the plain average does not have.
    pub(crate) at_most: Option<f32>,
}

impl Corrector for Naive {
    fn step(&mut self, tick: &Tick) -> Out {
        for (axis, bias) in self.bias.iter_mut().enumerate() {
            let error = tick.axes[axis] - AT_REST[axis] - *bias;
            *bias += self.gain
                * match self.at_most {
                    None => error,
                    Some(_) if error.is_nan() => 0.0,
                    Some(limit) => error.clamp(-limit, limit),
                };
        }
        Out { predicted: self.bias, ..Out::NOTHING }
    }
}
