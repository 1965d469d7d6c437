//! Bound on the difference between fixed point and f64: docs/MATHS.md, "In fixed point".

use fos_core::{Channel, Input, Source, Term, Transform};
use fos_testkit::models::{OwnedAxis, OwnedModel, PERIOD_S};

/// Step of the values.
pub(crate) const STEP: f64 = 1.0 / 8_388_608.0;
/// Error of one rounding.
const ROUNDED: f64 = STEP / 2.0;
/// Relative error of a gain with 31 bits.
const GAIN: f64 = 1.0 / 2_147_483_648.0;

/// Bounds of an axis, in its unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    /// Bound of the predicted error.
    pub(crate) predicted: f64,
    /// Bound of the innovation, with a measured history.
    pub(crate) innovation: f64,
}

/// Error and magnitude of a value.
#[derive(Debug, Clone, Copy)]
struct Part {
    error: f64,
    magnitude: f64,
}

/// Bounds of every axis over `samples` tracked or coasted samples; a nonlinear stochastic part may only be tracked.
pub(crate) fn bounds(model: &OwnedModel<f64>, samples: u32) -> Vec<Bound> {
    // an input over a remainder has the error of the remainder, which has that of the logged inputs
    let logged: Vec<Part> = model.inputs.iter().map(|input| of_input(input, 0.0, samples)).collect();
    let remainders: Vec<f64> = model.axes.iter().map(|axis| remainder(axis, &logged).1).collect();
    let inputs: Vec<Part> = model
        .inputs
        .iter()
        .map(|input| match input.source {
            Source::Remainder(axis) => of_input(input, remainders[usize::from(axis)], samples),
            Source::Clock | Source::Quantity(_) => of_input(input, 0.0, samples),
        })
        .collect();
    model.axes.iter().map(|axis| of_axis(axis, &inputs)).collect()
}

/// Error of p, and of r = y − p.
fn remainder(axis: &OwnedAxis<f64>, inputs: &[Part]) -> (f64, f64) {
    let p = axis.physical.iter().map(|term| of_term(term, inputs, Part::NONE)).sum::<f64>() + 2.0 * ROUNDED;
    let parameters = &axis.parameters;
    // measured is exact here; reference and offset are rounded, and so is the product
    let y = 2.0 * ROUNDED / parameters.scale + ROUNDED + GAIN * 256.0;
    (p, y + p)
}

fn of_axis(axis: &OwnedAxis<f64>, inputs: &[Part]) -> Bound {
    let parameters = &axis.parameters;
    let (p, remainder) = remainder(axis, inputs);
    let limits = parameters.range;
    let width = limits.high - limits.low;
    let magnitude = (limits.low - 0.5 * width).abs().max((limits.high + 0.5 * width).abs());
    let output = Part { error: remainder + ROUNDED, magnitude };
    let once: f64 =
        axis.stochastic.iter().map(|term| of_term(term, inputs, output)).sum::<f64>() + 2.0 * ROUNDED;
    // while coasting, errors are fed back: amplified by the sum of the impulse response
    let predicted = once * response(&axis.stochastic);
    let all = parameters.scale * (p + predicted + 2.0 * ROUNDED);
    let slack = ROUNDED + parameters.scale * GAIN * 256.0;
    Bound {
        predicted: all + 2.0 * ROUNDED + slack,
        innovation: parameters.scale * (remainder + once + 2.0 * ROUNDED) + ROUNDED + slack,
    }
}

/// Σ|h(k)| of 1/(1 − Σ c z^−k), of the linear terms of the output.
fn response(terms: &[Term<f64>]) -> f64 {
    let lags: Vec<(usize, f64)> = terms
        .iter()
        .filter_map(|term| match term.factors() {
            [factor] if factor.channel == Channel::Output => {
                Some((usize::from(factor.lag), term.coefficient))
            }
            _ => None,
        })
        .collect();
    if lags.len() < terms.len() {
        return 1.0;
    }
    let mut h = vec![1.0_f64];
    for n in 1..5000 {
        h.push(lags.iter().map(|&(lag, c)| if lag > n { 0.0 } else { c * h[n - lag] }).sum());
    }
    h.iter().map(|value| value.abs()).sum()
}

impl Part {
    const NONE: Self = Self { error: 0.0, magnitude: 0.0 };
}

/// Error of a term: |c|·Σ δ_i Π m_k over the other factors, the rounding of the coefficient, and that of partial products
/// times the following factors.
fn of_term(term: &Term<f64>, inputs: &[Part], output: Part) -> f64 {
    let factors: Vec<Part> = term
        .factors()
        .iter()
        .map(|factor| match factor.channel {
            Channel::Output => output,
            Channel::Input(input) => inputs[usize::from(input)],
        })
        .collect();
    let product = |parts: &mut dyn Iterator<Item = f64>| parts.product::<f64>();
    let with = |changed: &[bool]| {
        product(
            &mut factors
                .iter()
                .zip(changed)
                .map(|(part, changed)| part.magnitude + if *changed { part.error } else { 0.0 }),
        )
    };
    let all = vec![true; factors.len()];
    let moved = term.coefficient.abs() * (with(&all) - with(&vec![false; factors.len()]));
    let coefficient = ROUNDED * with(&all);
    let partial: f64 = (1..factors.len())
        .map(|n| ROUNDED * product(&mut factors[n..].iter().map(|part| part.magnitude + part.error)))
        .sum();
    moved + coefficient + partial
}

/// Error and magnitude of u.
fn of_input(input: &Input<f64>, of_source: f64, samples: u32) -> Part {
    let x = input.source_range;
    let reach = 1.1 * x.low.abs().max(x.high.abs()) + 0.1;
    // rounding of centre, product and limits
    let x = (of_source + ROUNDED) / input.scale + 2.0 * ROUNDED + GAIN * 256.0;
    let slow = |error: f64| error + ROUNDED + 2.0 * GAIN * reach;
    let error = match input.transform {
        Transform::Identity | Transform::Absolute => x,
        Transform::LowPass { .. } => slow(x),
        Transform::Rate { tau_s } => (x + slow(x)) / tau_s + ROUNDED + GAIN * 256.0,
        Transform::Variance { .. } => {
            let deviation = x + slow(x);
            slow(4.0 * reach * deviation + deviation * deviation + ROUNDED)
        }
        Transform::Backlash { .. } => 2.0 * x + 2.0 * ROUNDED,
        Transform::Decay { .. } => 4.0 * ROUNDED,
        Transform::Time => 2.0 * ROUNDED + GAIN * 256.0 + GAIN * f64::from(samples) * PERIOD_S / input.scale,
        // the rotation, its product and its normalisation
        Transform::Sine { .. } | Transform::Cosine { .. } => 8.0 * ROUNDED * f64::from(samples),
    };
    let range = input.range;
    let width = range.high - range.low;
    let magnitude = (range.low - 0.05 * width).abs().max((range.high + 0.05 * width).abs());
    Part { error: error + ROUNDED, magnitude }
}
