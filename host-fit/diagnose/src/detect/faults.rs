//! Faults of the data rather than of the sensor's bias: clipping, missing samples, coarse steps. They are found first,
//! since faulty data invalidate every later test.

use super::dead_zone::DeadZone;
use fos_data::recording::Recording;
use fos_fit::signal::quantisation::quantisation;

/// Least share of samples at one extreme value for clipping, and the number of standard errors by which they must
/// exceed the share that a tail of noise would leave there.
const CLIPPED_SHARE: f64 = 2e-4;
const PILE_UP_ERRORS: f64 = 4.0;

/// Ratio of changes by several steps to changes by one step below which the steps form separate peaks, as steps of more
/// than 1.3 standard deviations of the noise do.
const PEAK_RATIO: f64 = 0.3;

/// Least share of missing samples, in excess of that of the reference log.
const DROPPED_SHARE: f64 = 5e-4;

/// Least ratio of the observed step to the known step; one lost bit gives 2.
const COARSE: f64 = 1.5;

/// Fault of the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    /// Values are clipped.
    Saturation {
        /// Share of the samples at a limit.
        share: f64,
        /// Lower and upper limit, unit of the axis, if reached.
        limits: (Option<f64>, Option<f64>),
    },
    Dropped {
        /// Share of missing samples.
        share: f64,
    },
    /// Steps are coarser than specified.
    Coarse {
        /// Ratio to the specified step; NaN if that is unknown.
        multiple: f64,
        /// Step, unit of the axis.
        step: f64,
    },
    /// Slow rates read as one value.
    DeadZone(DeadZone),
}

/// Known properties of the converter of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Converter {
    /// Full scale, unit of the axis.
    pub(super) full_scale: Option<f64>,
    /// Least significant bit, unit of the axis.
    pub(super) lsb: Option<f64>,
}

/// Finds the faults of the column `target` of `log`; `reference` is a log without faults to compare with.
pub(super) fn find(
    log: &Recording,
    reference: Option<&Recording>,
    target: &str,
    converter: &Converter,
) -> Vec<Fault> {
    let values = |recording: &Recording| -> Vec<f64> {
        let channel = recording.channel(target);
        channel.map_or_else(|_| Vec::new(), |c| c.values.iter().copied().filter(|v| v.is_finite()).collect())
    };
    let own = values(log);
    let mut faults = Vec::new();
    let step = |values: &[f64]| quantisation(&[values]).map(|found| found.step);
    // a constant column shows no step: use that of the other axes
    let own_step = step(&own).or_else(|| hidden_step(log, target));
    faults.extend(clipped(&own, converter, own_step));
    let missing = |recording: &Recording| {
        let missing = recording.samples_missing();
        missing as f64 / (recording.n_rows() as f64 + missing as f64)
    };
    let share = missing(log);
    if share > DROPPED_SHARE + 2.0 * reference.map_or(0.0, missing) {
        faults.push(Fault::Dropped { share });
    }
    let known = reference.and_then(|reference| step(&values(reference))).or(converter.lsb);
    if let (Some(step), Some(known)) = (own_step, known)
        && step > COARSE * known
    {
        faults.push(Fault::Coarse { multiple: (step / known).round(), step });
    } else if reference.is_none()
        && let Some(step) = hidden_step(log, target)
    {
        // a step that hides the noise is too coarse, whatever the data sheet states
        faults.push(Fault::Coarse { multiple: known.map_or(f64::NAN, |known| (step / known).round()), step });
    }
    faults
}

/// Returns the value of a column that never changes.
pub(super) fn only_value(log: &Recording, target: &str) -> Option<f64> {
    let mut values = log.channel(target).ok()?.values.iter().copied().filter(|value| value.is_finite());
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// Returns the step of a column if it hides the noise.
pub(super) fn hidden_step(log: &Recording, target: &str) -> Option<f64> {
    match &log.still {
        Some(still) => log.hidden_step(target, still),
        None => log.hidden_step(target, &vec![true; log.n_rows()]),
    }
}

/// Returns true if the steps are so coarse that adjacent samples rarely differ by more than one.
fn forms_separate_peaks(values: &[f64], step: f64) -> bool {
    let changes =
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step).filter(|change| *change > 0.5);
    let (one, more) = changes.fold((0_u32, 0_u32), |(one, more), change| match change < 1.5 {
        true => (one + 1, more),
        false => (one, more + 1),
    });
    f64::from(more) < PEAK_RATIO * f64::from(one)
}

/// Returns true if more samples lie at the outermost value than a tail of noise would leave there, given the counts of
/// the next two values. The logarithm of a normal density is concave, so the tail leaves at most next²/second, and it
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
    let separate_peaks = step.is_some_and(|step| forms_separate_peaks(values, step));
    let n = sorted.len() as f64;
    let stop = |sorted: &mut dyn Iterator<Item = f64>| -> Option<(f64, f64)> {
        // counts of samples at the outermost value and at the next two
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
        let piled = !separate_peaks
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
