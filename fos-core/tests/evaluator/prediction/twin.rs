//! The evaluator as documented, with the complete history in plain vectors.
#![allow(unreachable_pub)] // a module of a test

#[path = "../../../src/exponential.rs"]
mod exponential;

use exponential::exp_m1;
use proptest::prelude::*;

use fos_core::{
    AxisParameters, Channel, Correction, Input, Range, Real, Sample, Source, Term, Transform, Validity,
};

use fos_testkit::models::{OwnedAxis, OwnedModel, PERIOD_S, Roomy};

#[derive(Debug, Clone)]
pub enum Event {
    Track { measured: Vec<f64>, quantities: Vec<f64> },
    TrackAgainst { measured: Vec<f64>, quantities: Vec<f64>, reference: Vec<f64> },
    Coast { measured: Vec<f64>, quantities: Vec<f64> },
    Skip(u32),
    Repeat { measured: Vec<f64>, times: usize },
    Reset,
}

impl Event {
    /// Adds reference and offset of the axes to measured values drawn around 0 in scaled units.
    fn lifted(measured: &[f64], model: &OwnedModel<f64>) -> Vec<f64> {
        let lift = |(value, axis): (&f64, &OwnedAxis<f64>)| {
            value * axis.parameters.scale + axis.parameters.reference + axis.parameters.offset
        };
        measured.iter().zip(&model.axes).map(lift).collect()
    }

    pub fn run(&self, predictor: &mut Roomy<f64>, model: &OwnedModel<f64>) -> Vec<Correction<f64>> {
        match self {
            Self::Track { measured, quantities } => {
                predictor.track(&Sample { measured: &Self::lifted(measured, model), quantities }).to_vec()
            }
            Self::TrackAgainst { measured, quantities, reference } => {
                let measured = Self::lifted(measured, model);
                predictor.track_against(&Sample { measured: &measured, quantities }, reference).to_vec()
            }
            Self::Coast { measured, quantities } => {
                predictor.coast(&Sample { measured: &Self::lifted(measured, model), quantities }).to_vec()
            }
            Self::Skip(ticks) => predictor.skip(*ticks).to_vec(),
            Self::Repeat { measured, times } => {
                let measured = Self::lifted(measured, model);
                let sample = Sample { measured: &measured, quantities: &[0.1, 0.2, 0.3] };
                (0..*times).map(|_| predictor.track(&sample).to_vec()).last().unwrap_or_default()
            }
            Self::Reset => {
                predictor.reset();
                vec![]
            }
        }
    }
}

/// Random events for a predictor: mostly samples at rest without a fault.
pub fn events() -> impl Strategy<Value = Vec<Event>> {
    let values = prop::collection::vec(-1.5..1.5, 6);
    let reading =
        prop_oneof![20 => -1.5..1.5, 1 => Just(f64::NAN), 1 => Just(50.0), 1 => Just(f64::INFINITY)];
    let measured = prop::collection::vec(reading, 0..=6);
    let quantity = prop_oneof![20 => -2.5..2.5, 1 => Just(f64::NAN)];
    let quantities = prop::collection::vec(quantity, 0..=3);
    let one = prop_oneof![
        12 => (measured.clone(), quantities.clone())
            .prop_map(|(measured, quantities)| Event::Track { measured, quantities }),
        // without faults, because otherwise the history would hardly ever be full
        40 => (values.clone(), prop::collection::vec(-2.5..2.5, 3))
            .prop_map(|(measured, quantities)| Event::Track { measured, quantities }),
        6 => (values.clone(), quantities.clone(), prop::collection::vec(prop_oneof![9 => -1.0..1.0, 1 => Just(f64::NAN)], 0..=6)).prop_map(
            |(measured, quantities, reference)| Event::TrackAgainst { measured, quantities, reference }),
        12 => (measured, quantities).prop_map(|(measured, quantities)| Event::Coast { measured, quantities }),
        1 => (1_u32..30).prop_map(Event::Skip),
        1 => (257_u32..2000).prop_map(Event::Skip),
        1 => (values, 2_usize..9).prop_map(|(measured, times)| Event::Repeat { measured, times }),
        1 => Just(Event::Reset),
    ];
    prop::collection::vec(one, 0..250)
}

/// Runs the predictor and its twin over the events; a `tolerance` of 0 requires equal bits. The error describes the first
/// difference.
pub fn compare(model: &OwnedModel<f64>, events: &[Event], tolerance: f64) -> Result<(), String> {
    compare_with(Twin::new(model), model, events, tolerance)
}

/// Same as [`compare`], with a twin that may have another model.
pub fn compare_with(
    mut twin: Twin,
    model: &OwnedModel<f64>,
    events: &[Event],
    tolerance: f64,
) -> Result<(), String> {
    let mut predictor = model.predictor().map_err(|error| error.to_string())?;
    let same = |a: f64, b: f64| if tolerance == 0.0 { a == b } else { (a - b).abs() <= tolerance };
    for (index, event) in events.iter().enumerate() {
        let (found, expected) = (event.run(&mut predictor, model), twin.run(event));
        let agree = |(found, expected): (&Correction<f64>, &Correction<f64>)| {
            same(found.predicted, expected.predicted)
                && same(found.corrected, expected.corrected)
                && found.validity == expected.validity
                && match (found.innovation, expected.innovation) {
                    (Some(found), Some(expected)) => same(found, expected),
                    (found, expected) => found == expected,
                }
        };
        if found.len() != expected.len() || !found.iter().zip(&expected).all(agree) {
            return Err(format!("event {index}, {event:?}: {found:?}, expected {expected:?}"));
        }
    }
    Ok(())
}

enum Reading {
    Still(f64, f64),
    Moving(f64),
    Missing,
}

/// Kind of the history entry of a tick.
#[derive(Clone, Copy, PartialEq)]
enum Entry {
    Measured,
    Own,
    /// No entry: the history of the axis was not full.
    Nothing,
    /// No entry, and earlier entries no longer count.
    Restart,
}

#[derive(Default)]
struct TwinAxis {
    r: Vec<f64>,
    entries: Vec<Entry>,
    measured: Vec<f64>,
    missing: u32,
    coasted: u32,
    gain: f64,
    corrected: f64,
}

#[derive(Default)]
struct TwinInput {
    /// Last x; `None` before the first.
    x: Option<f64>,
    /// State of the low-pass or play; `variance` is that of the variance.
    s: Option<f64>,
    variance: Option<f64>,
    /// Values of u so far, limited.
    u: Vec<f64>,
}

pub struct Twin {
    model: OwnedModel<f64>,
    inputs: Vec<TwinInput>,
    axes: Vec<TwinAxis>,
}

fn widened(low: f64, high: f64, share: f64) -> (f64, f64) {
    (low - share * (high - low), high + share * (high - low))
}

/// u(n) by definition; a transform with a memory starts at the first x, one of a remainder at 0.
fn transformed(parameters: &Input<f64>, state: &mut TwinInput, n: usize, x: Option<f64>) -> f64 {
    let t = n as f64 * PERIOD_S;
    let low_pass = |s: &mut Option<f64>, x: Option<f64>, tau_s: f64| {
        let keep = (-PERIOD_S / tau_s).exp();
        if let Some(x) = x {
            *s = Some(s.map_or(x, |s| keep * s + (1.0 - keep) * x));
        }
        s.unwrap_or(0.0)
    };
    let now = x.unwrap_or(0.0);
    match parameters.transform {
        Transform::Identity => now,
        Transform::Absolute => now.abs(),
        Transform::LowPass { tau_s } => low_pass(&mut state.s, x, tau_s),
        Transform::Rate { tau_s } => (now - low_pass(&mut state.s, x, tau_s)) / tau_s,
        Transform::Variance { tau_s } => {
            let mean = low_pass(&mut state.s, x, tau_s);
            low_pass(&mut state.variance, x.map(|x| (x - mean) * (x - mean)), tau_s)
        }
        Transform::Backlash { half_width } => {
            let r = half_width / parameters.scale;
            // moved by either end of the play
            state.s = x.map(|x| state.s.map_or(x, |play| play.max(x - r).min(x + r)));
            state.s.map_or(0.0, |play| play - now)
        }
        Transform::Decay { tau_s } => (-t / tau_s).exp(),
        Transform::Time => n as f64 * (PERIOD_S / parameters.scale) - parameters.centre / parameters.scale,
        Transform::Sine { frequency_hz } => (core::f64::consts::TAU * frequency_hz * t).sin(),
        Transform::Cosine { frequency_hz } => (core::f64::consts::TAU * frequency_hz * t).cos(),
    }
}

impl Twin {
    pub fn new(model: &OwnedModel<f64>) -> Self {
        let axis = |axis: &OwnedAxis<f64>| TwinAxis {
            gain: 1.0,
            corrected: axis.parameters.reference,
            ..TwinAxis::default()
        };
        Self {
            inputs: model.inputs.iter().map(|_| TwinInput::default()).collect(),
            axes: model.axes.iter().map(axis).collect(),
            model: model.clone(),
        }
    }

    pub fn run(&mut self, event: &Event) -> Vec<Correction<f64>> {
        let still = |measured: &[f64], reference: &[f64], model: &OwnedModel<f64>| -> Vec<Reading> {
            let measured = Event::lifted(measured, model);
            let reading = |index: usize| match measured.get(index) {
                Some(&measured) => {
                    let fitted = model.axes[index].parameters.reference;
                    let reference = *reference.get(index).unwrap_or(&fitted);
                    // a true value that is not finite is unknown
                    if reference.is_finite() {
                        Reading::Still(measured, reference)
                    } else {
                        Reading::Moving(measured)
                    }
                }
                None => Reading::Missing,
            };
            (0..model.axes.len()).map(reading).collect()
        };
        match event {
            Event::Track { measured, quantities } => {
                self.step(&still(measured, &[], &self.model), quantities)
            }
            Event::TrackAgainst { measured, quantities, reference } => {
                self.step(&still(measured, reference, &self.model), quantities)
            }
            Event::Coast { measured, quantities } => {
                let measured = Event::lifted(measured, &self.model);
                let reading =
                    |index: usize| measured.get(index).map_or(Reading::Missing, |&m| Reading::Moving(m));
                let readings: Vec<Reading> = (0..self.axes.len()).map(reading).collect();
                self.step(&readings, quantities)
            }
            Event::Skip(ticks) => {
                if *ticks > self.settling_ticks() + 1 {
                    // longer than every gap limit and lag: all axes restart at once
                    for (axis, parts) in self.axes.iter_mut().zip(&self.model.axes) {
                        axis.restart(&parts.parameters);
                    }
                }
                let missing: Vec<Reading> = self.axes.iter().map(|_| Reading::Missing).collect();
                (0..*ticks).map(|_| self.step(&missing, &[])).last().unwrap_or_default()
            }
            Event::Repeat { measured, times } => {
                let readings = still(measured, &[], &self.model);
                (0..*times).map(|_| self.step(&readings, &[0.1, 0.2, 0.3])).last().unwrap_or_default()
            }
            Event::Reset => {
                *self = Self::new(&self.model);
                vec![]
            }
        }
    }

    /// Longest gap limit or lag of any axis, ticks.
    fn settling_ticks(&self) -> u32 {
        let lag = |terms: &[Term<f64>]| {
            terms.iter().flat_map(Term::factors).map(|factor| u32::from(factor.lag)).max().unwrap_or(0)
        };
        let axes = self.model.axes.iter();
        axes.map(|axis| {
            u32::from(axis.parameters.gap_limit_samples).max(lag(&axis.physical)).max(lag(&axis.stochastic))
        })
        .max()
        .unwrap_or(0)
    }

    fn step(&mut self, readings: &[Reading], quantities: &[f64]) -> Vec<Correction<f64>> {
        let input_validity: Vec<Validity> =
            (0..self.inputs.len()).map(|index| self.update_input(index, quantities)).collect();
        let Self { model, inputs, axes } = self;
        let mut corrections = vec![];
        for ((axis, parts), reading) in axes.iter_mut().zip(&model.axes).zip(readings) {
            let mut correction = axis.step(parts, inputs, reading);
            for factor in parts.physical.iter().chain(&parts.stochastic).flat_map(Term::factors) {
                if let Channel::Input(index) = factor.channel {
                    correction.validity |= input_validity[usize::from(index)];
                }
            }
            corrections.push(correction);
        }
        corrections
    }

    fn update_input(&mut self, index: usize, quantities: &[f64]) -> Validity {
        let parameters = &self.model.inputs[index];
        let state = &mut self.inputs[index];
        let mut validity = Validity::VALID;
        let logged = match parameters.source {
            Source::Clock => None,
            Source::Quantity(index) => quantities.get(usize::from(index)).copied().filter(|x| x.is_finite()),
            Source::Remainder(axis) => {
                let axis = &self.axes[usize::from(axis)];
                matches!(axis.entries.last(), Some(Entry::Measured | Entry::Own))
                    .then(|| *axis.r.last().unwrap())
            }
        };
        let x = match logged {
            Some(logged) => {
                let x = (logged - parameters.centre) * (1.0 / parameters.scale);
                let (low, high) = widened(parameters.source_range.low, parameters.source_range.high, 0.05);
                if !(low..=high).contains(&x) {
                    validity |= Validity::INPUT_OUT_OF_RANGE;
                }
                Some(x.clamp(low, high))
            }
            None => {
                if matches!(parameters.source, Source::Quantity(_)) {
                    validity |= Validity::INPUT_NOT_FINITE;
                }
                match parameters.source {
                    // an unknown remainder is replaced by its mean
                    Source::Remainder(_) => Some(0.0),
                    _ => state.x,
                }
            }
        };
        state.x = x;
        let u = transformed(parameters, state, state.u.len(), x);
        let (low, high) = widened(parameters.range.low, parameters.range.high, 0.05);
        if !(low..=high).contains(&u) {
            validity |= Validity::INPUT_OUT_OF_RANGE;
        }
        state.u.push(u.clamp(low, high));
        validity
    }
}

impl TwinAxis {
    fn restart(&mut self, parameters: &AxisParameters<f64>) {
        self.missing = u32::from(parameters.gap_limit_samples);
        if let Some(last) = self.entries.last_mut() {
            *last = Entry::Restart;
        }
    }

    fn sum(&self, terms: &[Term<f64>], start: f64, inputs: &[TwinInput]) -> f64 {
        let n = self.r.len();
        let back =
            |series: &[f64], lag: u16| n.checked_sub(usize::from(lag)).map_or(0.0, |index| series[index]);
        let mut sum = start;
        for degree in 1..=3 {
            for term in terms.iter().filter(|term| term.factors().len() == degree) {
                let factors = term.factors().iter().map(|factor| match factor.channel {
                    Channel::Output => back(&self.r, factor.lag),
                    Channel::Input(index) => back(&inputs[usize::from(index)].u, factor.lag),
                });
                sum += factors.fold(term.coefficient, |product, factor| product * factor);
            }
        }
        sum
    }

    fn step(&mut self, parts: &OwnedAxis<f64>, inputs: &[TwinInput], reading: &Reading) -> Correction<f64> {
        let parameters = &parts.parameters;
        let lags = parts.physical.iter().chain(&parts.stochastic).flat_map(Term::factors);
        let depth = lags.map(|factor| usize::from(factor.lag)).max().unwrap_or(0);
        let (low, high) = widened(parameters.range.low, parameters.range.high, 0.5);

        let since_restart = self.entries.rsplit(|entry| *entry == Entry::Restart).next().unwrap_or(&[]);
        let ready = since_restart.split(|entry| *entry != Entry::Measured).any(|run| run.len() >= depth);
        let measured_run = since_restart.iter().rev().take_while(|entry| **entry == Entry::Measured).count();
        let own_history = ready && measured_run < depth;

        let mut validity = Validity::VALID;
        let mut p = self.sum(&parts.physical, 0.0, inputs);
        let Range { low: least, high: most } = parameters.physical_range;
        let (least, most) = widened(least, most, 1.0);
        if !parts.physical.is_empty() && !(least..=most).contains(&p) {
            validity |= Validity::INPUT_OUT_OF_RANGE;
            p = p.clamp(least, most);
        }
        let mut r_hat = 0.0;
        if ready {
            r_hat = self.sum(&parts.stochastic, parameters.constant, inputs);
            if !(low..=high).contains(&r_hat) {
                validity |= Validity::OUTPUT_OUT_OF_RANGE;
            }
            r_hat = r_hat.clamp(low, high);
        } else {
            validity |= Validity::WARMING_UP;
        }

        let mut fault = Validity::VALID;
        if let Reading::Still(measured, _) | Reading::Moving(measured) = *reading {
            self.measured.push(measured);
            let same = self.measured.iter().rev().take_while(|value| **value == measured).count();
            if !measured.is_finite() {
                fault |= Validity::NOT_FINITE;
            }
            if parameters.full_scale > 0.0 && measured.abs() >= parameters.full_scale {
                fault |= Validity::SATURATED;
            }
            if parameters.stuck_after_repeats > 0 && same > usize::from(parameters.stuck_after_repeats) {
                fault |= Validity::STUCK;
            }
        } else {
            fault |= Validity::MISSING;
        }
        validity |= fault;

        if let Reading::Still(measured, reference) = *reading
            && fault.is_valid()
        {
            let r = (measured - reference - parameters.offset) * (1.0 / parameters.scale) - p;
            let innovation = ready.then_some(parameters.scale * (r - r_hat));
            if own_history {
                validity |= Validity::OWN_HISTORY;
            }
            if !(low..=high).contains(&r) {
                validity |= Validity::OUTPUT_OUT_OF_RANGE;
            }
            self.r.push(r.clamp(low, high));
            self.entries.push(Entry::Measured);
            (self.missing, self.coasted, self.gain) = (0, 0, 1.0);
            let predicted = parameters.offset + parameters.scale * (p + r_hat);
            self.corrected = measured - predicted;
            return Correction { predicted, innovation, corrected: self.corrected, validity };
        }

        // in motion, or without a usable sample
        let unusable = match reading {
            Reading::Still(..) | Reading::Missing => true,
            Reading::Moving(_) => fault.intersects(Validity::NOT_FINITE),
        };
        self.missing = if unusable { self.missing + 1 } else { 0 };
        let restarted = self.missing > u32::from(parameters.gap_limit_samples);
        let limit = (parameters.coast_limit_s / PERIOD_S).floor();
        if restarted && f64::from(self.coasted) > limit {
            self.gain = 0.0;
        }
        self.coasted += 1;
        if f64::from(self.coasted) > limit {
            validity |= Validity::COASTING_TOO_LONG;
            // the function of the crate, compared with libm in its unit tests: the last bits differ
            self.gain *= 1.0 + exp_m1(-PERIOD_S / parameters.coast_limit_s);
            if self.gain < 1e-6 {
                self.gain = 0.0;
            }
        }
        let goes_on = ready && !restarted;
        if goes_on && depth > 0 {
            validity |= Validity::OWN_HISTORY;
        }
        self.r.push(if goes_on { r_hat } else { 0.0 });
        self.entries.push(match (goes_on, restarted) {
            (true, _) => Entry::Own,
            (false, false) => Entry::Nothing,
            (false, true) => Entry::Restart,
        });
        let predicted = parameters.offset + parameters.scale * (p + r_hat * self.gain);
        if let Reading::Still(measured, _) | Reading::Moving(measured) = *reading
            && measured.is_finite()
        {
            self.corrected = measured - predicted;
        }
        Correction { predicted, innovation: None, corrected: self.corrected, validity }
    }
}
