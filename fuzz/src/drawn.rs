//! Models and events derived from the bytes of an input. A changed byte changes one thing, so that coverage can guide
//! the fuzzer. At the end of the bytes everything is small and ends.

use fos_core::{AxisParameters, Transform};
use libfuzzer_sys::arbitrary::{Result, Unstructured};

use fos_testkit::models::{Draw, OwnedModel, Picks, axis_of, drawn_axis, model_of, shifted_input, source_of};
use crate::twin::Event;

/// Maximum number of events in one run: the twin stores everything and is slow.
const MOST_EVENTS: usize = 250;

/// One of 256 values from `low` to `high`.
pub fn between(bytes: &mut Unstructured<'_>, low: f64, high: f64) -> Result<f64> {
    Ok(low + (high - low) * f64::from(bytes.arbitrary::<u8>()?) / 255.0)
}

/// Reads a list; the next byte gives its length, at most `most`.
pub fn several<'a, T>(
    bytes: &mut Unstructured<'a>,
    most: usize,
    mut one: impl FnMut(&mut Unstructured<'a>) -> Result<T>,
) -> Result<Vec<T>> {
    let count = usize::from(bytes.arbitrary::<u8>()?) % (most + 1);
    (0..count).map(|_| one(bytes)).collect()
}

/// Reads a model of 1 to 6 axes and up to 8 inputs.
pub fn model(bytes: &mut Unstructured<'_>, draw: Draw) -> Result<OwnedModel<f64>> {
    let n_axes = bytes.int_in_range(1..=6_u8)?;
    let inputs = several(bytes, 8, |bytes| {
        let transform = transform(bytes, draw)?;
        let (of_a_remainder, quantity) = (bytes.arbitrary()?, bytes.int_in_range(0..=2)?);
        let source = source_of(&transform, of_a_remainder, quantity, bytes.int_in_range(0..=n_axes - 1)?);
        let (centre, scale) = (between(bytes, -0.5, 0.5)?, between(bytes, 0.5, 2.0)?);
        Ok(shifted_input(source, transform, centre, scale, between(bytes, 0.4, 3.0)?))
    })?;
    let axes = (0..n_axes).map(|_| {
        let parameters = AxisParameters {
            reference: between(bytes, -10.0, 10.0)?,
            offset: between(bytes, -0.1, 0.1)?,
            scale: between(bytes, 0.5, 2.0)?,
            constant: between(bytes, -0.3, 0.3)?,
            stuck_after_repeats: *bytes.choose(&[0, 2, 3, 4, 5])?,
            gap_limit_samples: bytes.int_in_range(0..=11)?,
            coast_limit_s: *bytes.choose(&[0.0, 0.004, 0.05, 0.3, 1e9])?,
            ..drawn_axis(between(bytes, 0.5, 1.0)?)
        };
        let (physical, stochastic) = (picks(bytes)?, picks(bytes)?);
        Ok(axis_of(parameters, physical, stochastic, draw, &inputs))
    });
    let axes = axes.collect::<Result<_>>()?;
    Ok(model_of(inputs, axes))
}

fn transform(bytes: &mut Unstructured<'_>, draw: Draw) -> Result<Transform<f64>> {
    let kinds = if draw == Draw::Exact { 4 } else { 10 };
    Ok(match bytes.int_in_range(0..=kinds - 1_u8)? {
        0 => Transform::Identity,
        1 => Transform::Absolute,
        2 => Transform::Backlash { half_width: between(bytes, 0.0, 0.8)? },
        3 => Transform::Time,
        4 => Transform::LowPass { tau_s: between(bytes, 0.01, 5.0)? },
        5 => Transform::Rate { tau_s: between(bytes, 0.01, 5.0)? },
        6 => Transform::Variance { tau_s: between(bytes, 0.01, 5.0)? },
        7 => Transform::Decay { tau_s: between(bytes, 0.01, 5.0)? },
        8 => Transform::Sine { frequency_hz: between(bytes, 0.1, 90.0)? },
        _ => Transform::Cosine { frequency_hz: between(bytes, 0.1, 90.0)? },
    })
}

fn picks(bytes: &mut Unstructured<'_>) -> Result<Picks> {
    several(bytes, 8, |bytes| {
        let coefficient = between(bytes, -1.0, 1.0)?;
        let mut factors = several(bytes, 2, factor)?;
        factors.push(factor(bytes)?);
        Ok((coefficient, factors))
    })
}

fn factor(bytes: &mut Unstructured<'_>) -> Result<(u8, u16)> {
    Ok((bytes.arbitrary()?, bytes.int_in_range(0..=12)?))
}

/// Reads events until the bytes end.
pub fn events<'a, T>(
    bytes: &mut Unstructured<'a>,
    event: impl Fn(&mut Unstructured<'a>) -> Result<T>,
) -> Vec<T> {
    let next = || if bytes.is_empty() { None } else { event(bytes).ok() };
    std::iter::from_fn(next).take(MOST_EVENTS).collect()
}

/// Reads an event for a predictor.
pub fn event(bytes: &mut Unstructured<'_>) -> Result<Event> {
    let values = |bytes: &mut Unstructured<'_>, count: usize, reach: f64| -> Result<Vec<f64>> {
        (0..count).map(|_| between(bytes, -reach, reach)).collect()
    };
    let faulty = |bytes: &mut Unstructured<'_>, most: usize, reach: f64| {
        several(bytes, most, |bytes| match bytes.arbitrary::<u8>()? {
            0 => Ok(f64::NAN),
            1 => Ok(50.0),
            2 => Ok(f64::INFINITY),
            _ => between(bytes, -reach, reach),
        })
    };
    // Mostly valid samples at rest: otherwise a history is hardly ever full.
    Ok(match bytes.int_in_range(0..=31_u8)? {
        0..20 => Event::Track { measured: values(bytes, 6, 1.5)?, quantities: values(bytes, 3, 2.5)? },
        20..23 => Event::Track { measured: faulty(bytes, 6, 1.5)?, quantities: faulty(bytes, 3, 2.5)? },
        23..25 => Event::TrackAgainst {
            measured: values(bytes, 6, 1.5)?,
            quantities: faulty(bytes, 3, 2.5)?,
            reference: faulty(bytes, 6, 1.0)?,
        },
        25..28 => Event::Coast { measured: faulty(bytes, 6, 1.5)?, quantities: faulty(bytes, 3, 2.5)? },
        28 => Event::Skip(bytes.int_in_range(1..=29)?),
        // More than a byte can count; rare, because the twin executes every step.
        29 if bytes.ratio(1, 4)? => Event::Skip(bytes.int_in_range(257..=320)?),
        29 => Event::Skip(bytes.int_in_range(30..=60)?),
        30 => Event::Repeat { measured: values(bytes, 6, 1.5)?, times: bytes.int_in_range(2..=8)? },
        _ => Event::Reset,
    })
}
