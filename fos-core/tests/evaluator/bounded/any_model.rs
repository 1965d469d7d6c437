//! Adversarial models, coasted for a long time over adversarial samples.
//!
//! |predicted| ≤ |offset| + scale·(Σ|c|·Π|u| or the limit of p + limit of the remainder), the inputs at the limits of their
//! ranges.

use std::fmt;

use fos_core::{
    Axis, AxisParameters, Channel, Factor, Input, ModelError, Quantity, Range, Sample, Source, Term,
    Transform,
};

use fos_testkit::models::{OwnedAxis, OwnedModel, PERIOD_S, Roomy, plain};
use fos_testkit::noise::Noise;

/// Results of a run over many models.
#[derive(Default)]
struct Findings {
    models: u32,
    samples: u64,
    refused: u32,
    worst: f64,
    /// Models whose terms leave the bound without the limits.
    naive_beyond: u32,
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { models, samples, refused, worst, naive_beyond } = self;
        write!(
            f,
            "{models} models, {samples} samples each, reach at most {worst:.7} of the bound, {refused} more are refused \
             as unbounded; without the limit {naive_beyond} of the {models} exceed the bound"
        )
    }
}

/// One of `all`, at random.
fn pick<T: Copy>(noise: &mut Noise, all: &[T]) -> T {
    all[noise.bits() as usize % all.len()]
}

/// 10 to a power between `low` and `high`.
fn decade(noise: &mut Noise, low: f64, high: f64) -> f64 {
    10.0_f64.powf(low + (high - low) * noise.uniform())
}

/// Mostly unstable coefficients, sometimes any number of f32.
fn coefficient(noise: &mut Noise) -> f64 {
    let sign = pick(noise, &[-1.0, 1.0]);
    sign * match noise.bits() % 8 {
        0 => decade(noise, -45.0, 0.0),
        1 => decade(noise, 0.0, 12.0),
        2 => decade(noise, 0.0, 38.0),
        3 => 1.0 + f64::from(f32::EPSILON),
        _ => 3.0 * noise.uniform(),
    }
}

fn range(noise: &mut Noise, largest: f64) -> Range<f64> {
    let reach = decade(noise, -3.0, largest);
    let low = pick(noise, &[-reach, 0.0, -0.1 * reach, 0.99 * reach, reach]);
    Range::new(low, reach)
}

/// A random input whose transform has the index `kind`, so that every transform is used.
fn input(noise: &mut Noise, kind: usize, n_axes: u8) -> Input<f64> {
    let tau_s = decade(noise, -40.0, 30.0);
    let frequency_hz = decade(noise, -30.0, 9.0);
    let transform = match kind % 10 {
        0 => Transform::Identity,
        1 => Transform::LowPass { tau_s },
        2 => Transform::Rate { tau_s },
        3 => Transform::Variance { tau_s },
        4 => Transform::Backlash { half_width: pick(noise, &[0.0, 1e-30, 0.3, 1e30]) },
        5 => Transform::Absolute,
        6 => Transform::Decay { tau_s },
        7 => Transform::Time,
        8 => Transform::Sine { frequency_hz },
        _ => Transform::Cosine { frequency_hz },
    };
    let source = if transform.is_clock() {
        Source::Clock
    } else if noise.bits().is_multiple_of(2) {
        Source::Quantity(noise.bits() as u8 % 3)
    } else {
        Source::Remainder(noise.bits() as u8 % n_axes)
    };
    Input {
        source,
        transform,
        centre: pick(noise, &[0.0, 25.0, -1e30, 3e38]),
        scale: pick(noise, &[1.0, 1e-3, 1e20, 1e-30]),
        source_range: range(noise, 14.0),
        range: range(noise, 8.0),
    }
}

fn terms(noise: &mut Noise, channels: &[Channel]) -> Vec<Term<f64>> {
    let n = if channels.is_empty() { 0 } else { noise.bits() % 8 };
    (0..n)
        .map(|_| {
            let degree = 1 + noise.bits() as usize % 3;
            let factors: Vec<Factor> = (0..degree)
                .map(|_| {
                    let channel = pick(noise, channels);
                    let lag = (noise.bits() % 13) as u16;
                    Factor { channel, lag: if channel == Channel::Output { lag.max(1) } else { lag } }
                })
                .collect();
            Term::new(coefficient(noise), &factors)
        })
        .collect()
}

fn model(noise: &mut Noise, number: usize) -> OwnedModel<f32> {
    let n_axes = 1 + noise.bits() as u8 % 6;
    let inputs: Vec<Input<f64>> =
        (0..1 + noise.bits() as usize % 8).map(|place| input(noise, number + 3 * place, n_axes)).collect();
    let is_logged = |input: &Input<f64>| !matches!(input.source, Source::Remainder(_));
    let all: Vec<Channel> =
        [Channel::Output; 4].into_iter().chain((0..inputs.len() as u8).map(Channel::Input)).collect();
    let logged: Vec<Channel> = (0..)
        .zip(&inputs)
        .filter(|(_, input)| is_logged(input))
        .map(|(index, _)| Channel::Input(index))
        .collect();
    let axes = (0..n_axes)
        .map(|_| OwnedAxis {
            parameters: AxisParameters {
                axis: Axis::Other,
                reference: pick(noise, &[0.0, 9.81, -1e6]),
                offset: pick(noise, &[0.0, 0.5, -1e3]),
                scale: decade(noise, -6.0, 3.0),
                constant: coefficient(noise),
                range: range(noise, 6.0),
                physical_range: if noise.bits().is_multiple_of(2) {
                    range(noise, 6.0)
                } else {
                    Range::unlimited()
                },
                gap_limit_samples: pick(noise, &[0, 20, 255]),
                coast_limit_s: pick(noise, &[0.0, 10.0, 1e9, 1e9, 1e9]),
                ..plain()
            },
            physical: terms(noise, &logged),
            stochastic: terms(noise, &all),
        })
        .collect();
    let quantities = vec![Quantity::Temperature, Quantity::Supply, Quantity::Load];
    OwnedModel::<f64> { period_s: PERIOD_S, stillness: None, calibration: None, quantities, inputs, axes }
        .convert()
}

/// Bound of every axis, with the rounding of its terms in f32: half a unit for each addition and multiplication.
fn bounds(model: &OwnedModel<f32>) -> Vec<f64> {
    let limit = |range: &Range<f32>, margin: f64| {
        let (low, high) = (f64::from(range.low), f64::from(range.high));
        // the limits themselves are rounded
        (low - margin * (high - low)).abs().max((high + margin * (high - low)).abs())
            * (1.0 + f64::from(f32::EPSILON))
    };
    model
        .axes
        .iter()
        .map(|axis| {
            let physical = axis.physical.iter().map(|term| {
                term.factors().iter().fold(f64::from(term.coefficient).abs(), |product, factor| {
                    let Channel::Input(input) = factor.channel else { unreachable!("of inputs only") };
                    product * limit(&model.inputs[usize::from(input)].range, 0.05)
                })
            });
            let remainder = limit(&axis.parameters.range, 0.5);
            let together = limit(&axis.parameters.physical_range, 1.0);
            let scaled = physical.sum::<f64>().min(together) + remainder;
            let roundings = 5.0 + axis.physical.len() as f64 * 4.0;
            (f64::from(axis.parameters.offset).abs() + f64::from(axis.parameters.scale) * scaled)
                * (1.0 + roundings * f64::from(f32::EPSILON))
        })
        .collect()
}

/// Any value that a sensor, a driver or a broken pointer could give.
fn any(noise: &mut Noise) -> f32 {
    match noise.bits() % 8 {
        0 => f32::from_bits(noise.bits() as u32),
        1 => pick(noise, &[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX, 0.0, 1e-45]),
        2 => (1e4 * noise.uniform()) as f32,
        _ => noise.uniform() as f32 - 0.5,
    }
}

/// Coasts, and returns the largest share of its bound that an axis reaches.
fn coast(model: &OwnedModel<f32>, predictor: &mut Roomy<f32>, samples: u64, noise: &mut Noise) -> f64 {
    let bounds = bounds(model);
    let mut measured = [0.0; 6];
    let measured = &mut measured[..model.axes.len()];
    for _ in 0..30 {
        for (value, axis) in measured.iter_mut().zip(&model.axes) {
            let AxisParameters { reference, offset, scale, range, .. } = axis.parameters;
            *value = reference + offset + scale * pick(noise, &[range.low, range.high]);
        }
        let _ = predictor.track(&Sample { measured, quantities: &[25.0, 3.3, 50.0] });
    }
    let mut quantities = [25.0, 3.3, 50.0];
    let mut worst = 0.0;
    for n in 0..samples {
        // a draw costs more than a step, so most samples change one value
        let value = any(noise);
        let place = n as usize % (measured.len() + quantities.len());
        match measured.get_mut(place) {
            // non-finite values are gaps: only occasionally, so that the recursion continues
            Some(slot) => *slot = if value.is_finite() || n % 4096 < 64 { value } else { 0.0 },
            None => quantities[place - measured.len()] = value,
        }
        let found = predictor.coast(&Sample { measured, quantities: &quantities });
        for (axis, (correction, bound)) in found.iter().zip(&bounds).enumerate() {
            let share = f64::from(correction.predicted).abs() / bound;
            assert!(
                share <= 1.0 && correction.corrected.is_finite(),
                "sample {n}, axis {axis}: {share} of {bound}, {correction:?}\n{model:?}"
            );
            worst = share.max(worst);
        }
    }
    worst
}

/// Feeds the stochastic terms back without a limit, with inputs anywhere in their ranges. Returns true if an axis leaves
/// its bound within 1000 samples.
fn leaves_the_bound_without_limits(model: &OwnedModel<f32>, noise: &mut Noise) -> bool {
    let bounds = bounds(model);
    model.axes.iter().zip(bounds).any(|(axis, bound)| {
        let mut history = [axis.parameters.range.high; 13];
        (0..1000).any(|_| {
            let mut sum = axis.parameters.constant;
            for term in &axis.stochastic {
                sum += term.factors().iter().fold(term.coefficient, |product, factor| {
                    product
                        * match factor.channel {
                            Channel::Output => history[usize::from(factor.lag) - 1],
                            Channel::Input(input) => {
                                let range = &model.inputs[usize::from(input)].range;
                                range.low + (range.high - range.low) * noise.uniform() as f32
                            }
                        }
                });
            }
            history.rotate_right(1);
            history[0] = sum;
            let predicted = f64::from(axis.parameters.offset + axis.parameters.scale * sum);
            // NaN counts as beyond the bound
            predicted.is_nan() || predicted.abs() > bound
        })
    })
}

fn coast_many(models: u32, samples: u64) -> Findings {
    let mut noise = Noise::new(0xf05);
    let mut findings = Findings { models, samples, ..Findings::default() };
    let (mut coasted, mut number) = (0, 0);
    while coasted < models {
        let model = model(&mut noise, number);
        number += 1;
        let mut predictor = match model.predictor() {
            Ok(predictor) => predictor,
            Err(ModelError::Unbounded { .. }) => {
                findings.refused += 1;
                continue;
            }
            // rejected for another reason: f32 cannot hold a number or its reciprocal
            Err(
                ModelError::InputParameter { .. }
                | ModelError::AxisParameter { .. }
                | ModelError::CoefficientNotFinite { .. },
            ) => continue,
            Err(error) => panic!("{error}: {model:?}"),
        };
        coasted += 1;
        findings.worst = coast(&model, &mut predictor, samples, &mut noise).max(findings.worst);
        findings.naive_beyond += u32::from(leaves_the_bound_without_limits(&model, &mut noise));
    }
    println!("any model: {findings}");
    findings
}

fn check(findings: &Findings) {
    assert!(findings.worst > 0.99, "nothing came near the bound: {findings}");
    assert!(findings.refused > 0, "nothing could overflow: {findings}");
    assert!(findings.naive_beyond > 0, "the limit was never needed: {findings}");
}

#[test]
fn adversarial_models_stay_bounded_for_a_million_samples() {
    check(&coast_many(6, 1_000_000));
}

#[test]
#[ignore = "minutes in release: .ci/trust bounded runs it"]
fn adversarial_models_stay_bounded_for_ten_million_samples() {
    check(&coast_many(40, 10_000_000));
}
