//! Faults of the data, not of the sensor's bias: clipping, missing samples, coarse steps. They are looked for first,
//! since wrong data beat every later test.

use super::dead_zone::DeadZone;
use fos_data::recording::Recording;
use fos_fit::signal::quantisation::quantisation;

/// Share of samples at one extreme value above which they count as clipped, and by how many standard errors they must
/// outnumber what the tail of noise would leave there.
const CLIPPED_SHARE: f64 = 2e-4;
const PILE_UP_ERRORS: f64 = 4.0;

/// Changes of more than one step for each change of one below which steps make heaps of their own: those of more than
/// 1.3 standard deviations of the noise do.
const HEAPS: f64 = 0.3;

/// Share of missing samples that counts, beyond that of the quiet log.
const DROPPED_SHARE: f64 = 5e-4;

/// Steps so many times those that are known count as coarse: one bit is 2.
const COARSE: f64 = 1.5;

/// What is wrong with the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    /// Values end at a stop.
    Saturation {
        /// Share of the samples at it.
        share: f64,
        /// The lower and upper stop, unit of the axis, as far as either was hit.
        limits: (Option<f64>, Option<f64>),
    },
    Dropped {
        /// Share of the samples.
        share: f64,
    },
    /// Steps are coarser than they should be.
    Coarse {
        /// How many times; NaN where it is not known how fine they should be.
        multiple: f64,
        /// The step, unit of the axis.
        step: f64,
    },
    /// Slow rates read as one value.
    DeadZone(DeadZone),
}

/// What is known of the axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Converter {
    /// Full scale, unit of the axis.
    pub(super) full_scale: Option<f64>,
    /// Least significant bit, unit of the axis.
    pub(super) lsb: Option<f64>,
}

/// The faults of the column `target` of `field`; `quiet` is a log without faults to compare with.
pub(super) fn find(
    field: &Recording,
    quiet: Option<&Recording>,
    target: &str,
    converter: &Converter,
) -> Vec<Fault> {
    let values = |recording: &Recording| -> Vec<f64> {
        let channel = recording.channel(target);
        channel.map_or_else(|_| Vec::new(), |c| c.values.iter().copied().filter(|v| v.is_finite()).collect())
    };
    let own = values(field);
    let mut faults = Vec::new();
    let step = |values: &[f64]| quantisation(&[values]).map(|found| found.step);
    // one value shows no step: that of the axes beside it
    let own_step = step(&own).or_else(|| hidden_step(field, target));
    faults.extend(clipped(&own, converter, own_step));
    let missing = |recording: &Recording| {
        let missing = recording.samples_missing();
        missing as f64 / (recording.n_rows() as f64 + missing as f64)
    };
    let share = missing(field);
    if share > DROPPED_SHARE + 2.0 * quiet.map_or(0.0, missing) {
        faults.push(Fault::Dropped { share });
    }
    let known = quiet.and_then(|quiet| step(&values(quiet))).or(converter.lsb);
    if let (Some(step), Some(known)) = (own_step, known)
        && step > COARSE * known
    {
        faults.push(Fault::Coarse { multiple: (step / known).round(), step });
    } else if quiet.is_none()
        && let Some(step) = hidden_step(field, target)
    {
        // a step that hides the noise is too coarse, however fine it should be
        faults.push(Fault::Coarse { multiple: known.map_or(f64::NAN, |known| (step / known).round()), step });
    }
    faults
}

/// The value of a column that never changes.
pub(super) fn only_value(field: &Recording, target: &str) -> Option<f64> {
    let mut values = field.channel(target).ok()?.values.iter().copied().filter(|value| value.is_finite());
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// The step of a column where it hides the noise.
pub(super) fn hidden_step(field: &Recording, target: &str) -> Option<f64> {
    match &field.still {
        Some(still) => field.hidden_step(target, still),
        None => field.hidden_step(target, &vec![true; field.n_rows()]),
    }
}

/// Whether steps are so coarse that a sample hardly ever lies more than one from its neighbour.
fn in_heaps(values: &[f64], step: f64) -> bool {
    let changes =
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step).filter(|change| *change > 0.5);
    let (one, more) = changes.fold((0_u32, 0_u32), |(one, more), change| match change < 1.5 {
        true => (one + 1, more),
        false => (one, more + 1),
    });
    f64::from(more) < HEAPS * f64::from(one)
}

/// Whether more samples lie on the outermost value than the tail of noise would leave there, given those on the two
/// values next to it. The logarithm of a normal density is concave, so that it would leave at most next²/second, and it
/// falls off outwards.
fn is_pile(count: f64, next: f64, second: f64) -> bool {
    let (most, variance) = match next < second {
        true => (next * next / second, (next * next / second).powi(2) * (4.0 / next + 1.0 / second)),
        false => (next, next),
    };
    count > most + PILE_UP_ERRORS * (count + variance).sqrt()
}

fn clipped(values: &[f64], converter: &Converter, step: Option<f64>) -> Option<Fault> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let heaps = step.is_some_and(|step| in_heaps(values, step));
    let n = sorted.len() as f64;
    let stop = |sorted: &mut dyn Iterator<Item = f64>| -> Option<(f64, f64)> {
        // samples on the outermost value and on the two next to it
        let mut counts: Vec<(f64, usize)> = Vec::new();
        for value in sorted {
            let distinct = counts.len();
            match counts.last_mut() {
                Some((last, count)) if *last == value => *count += 1,
                _ if distinct == 3 => break,
                _ => counts.push((value, 1)),
            }
        }
        let (extreme, count) = *counts.first()?;
        let at_full_scale = converter.full_scale.is_some_and(|full| extreme.abs() >= 0.999 * full);
        let count = count as f64;
        let piled = !heaps
            && match counts[..] {
                [_, (_, next), (_, second)] => is_pile(count, next as f64, second as f64),
                _ => false,
            };
        (count >= CLIPPED_SHARE * n && (piled || at_full_scale)).then_some((extreme, count))
    };
    let low = stop(&mut sorted.iter().copied());
    let high = stop(&mut sorted.iter().rev().copied());
    let share = (low.map_or(0.0, |(_, count)| count) + high.map_or(0.0, |(_, count)| count)) / n;
    (share > 0.0).then_some(Fault::Saturation { share, limits: (low.map(|(v, _)| v), high.map(|(v, _)| v)) })
}
