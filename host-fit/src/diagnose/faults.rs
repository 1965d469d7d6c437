//! Faults of the data, not of the sensor's bias: clipping, missing samples, coarse steps. They are looked for first, since
//! wrong data beat every later test.

use crate::recording::Recording;
use crate::signal::quantisation::quantisation;

/// Share of samples at one extreme value above which they count as clipped, and by how many standard errors they must
/// outnumber those on the value next to it: the tail of noise falls off, a stop piles up.
const CLIPPED_SHARE: f64 = 2e-4;
const PILE_UP_ERRORS: f64 = 4.0;

/// Steps above this many standard deviations of the noise make heaps of their own at the extremes.
const HEAPS: f64 = 2.0;

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
    /// Samples are missing.
    Dropped {
        /// Share of the samples.
        share: f64,
    },
    /// Steps are coarser than they should be.
    Coarse {
        /// How many times.
        multiple: f64,
        /// The step, unit of the axis.
        step: f64,
    },
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
    let own_step = step(&own);
    faults.extend(clipped(&own, converter, own_step));
    let missing = |recording: &Recording| {
        let missing: u64 = recording.segments.iter().map(|segment| segment.missing_before).sum();
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
    }
    faults
}

/// Standard deviation of the noise, from the changes between neighbours.
fn fast_deviation(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    (squares / 2.0 / values.len().max(1) as f64).sqrt()
}

fn clipped(values: &[f64], converter: &Converter, step: Option<f64>) -> Option<Fault> {
    let heaps = step.is_some_and(|step| step > HEAPS * fast_deviation(values));
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
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
        let next = counts.get(1).map_or(0, |(_, count)| *count);
        let at_full_scale = converter.full_scale.is_some_and(|full| extreme.abs() >= 0.999 * full);
        let (count, next) = (count as f64, next as f64);
        let piled = !heaps && count > next + PILE_UP_ERRORS * (count + next).sqrt() && counts.len() == 3;
        (count >= CLIPPED_SHARE * n && (piled || at_full_scale)).then_some((extreme, count))
    };
    let low = stop(&mut sorted.iter().copied());
    let high = stop(&mut sorted.iter().rev().copied());
    let share = (low.map_or(0.0, |(_, count)| count) + high.map_or(0.0, |(_, count)| count)) / n;
    (share > 0.0).then_some(Fault::Saturation { share, limits: (low.map(|(v, _)| v), high.map(|(v, _)| v)) })
}
