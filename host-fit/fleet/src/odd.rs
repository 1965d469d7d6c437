//! Devices that do not belong to their population, and by what.
//!
//! Each coefficient of each device is compared with the population without that device, by Student's t: the population is estimated from few
//! devices, and its mean and scatter are as uncertain as that makes them. No device is left out of the population by chance more often than
//! [`LEFT_OUT`] says, however few there are.

use fos_data::statistics::median_of;
use serde::{Deserialize, Serialize};

use crate::coefficient::{Coefficient, Deviation, Value};
use crate::population::{Member, Population, PopulationError, check, values_of};
use crate::tails::{t_quantile, t_tail};

/// Devices are left out where the population is estimated, so that an odd one does not widen what it is compared with, if they are significant
/// at this rate of false discoveries: without an odd device, in one axis of a hundred.
const LEFT_OUT: f64 = 0.01;

/// A median deviation of a normal distribution over its standard deviation, inverse.
const PER_MEDIAN_DEVIATION: f64 = 1.4826;

/// The median deviation of n values is as uncertain as the standard deviation of this share of them (Hampel 1974).
const EFFICIENCY: f64 = 0.37;

/// Most rounds of estimating and leaving out.
const MOST_ROUNDS: usize = 10;

/// A device this many standard deviations off is to be found; where it would not be, there are too few devices.
pub const FAR: f64 = 8.0;

/// How far a device is from its population, in the coefficient that is least probable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Coefficients that were compared.
    pub coefficients: usize,
    /// Probability that a device that belongs is further away in any of them (Bonferroni).
    pub p_value: f64,
    /// The coefficient that is least probable by itself.
    pub most: String,
    /// Its deviation from the population without this device, in standard deviations of a device, its log and the estimated mean: Student's t.
    pub by: f64,
    /// Degrees of freedom of that t.
    #[serde(default)]
    pub freedom: f64,
}

/// A population, and how far each of its members is from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Of those that were not left out.
    pub population: Population,
    /// In the order of the members.
    pub distances: Vec<Distance>,
    /// The members that it is not of.
    pub left_out: Vec<bool>,
    /// Of each member, the p-values that it would have if it were [`FAR`] standard deviations off in a coefficient: one for each that was
    /// compared, times their number.
    pub p_values_if_far: Vec<Vec<f64>>,
}

/// The population of `members` without those that do not belong, and how far each is from it.
///
/// # Errors
///
/// Fewer than three devices know a coefficient.
pub fn judge(members: &[Member<'_>], names: &[String]) -> Result<Judged, PopulationError> {
    check(members, names)?;
    let values = values_of(members, names);
    let lots = values.iter().flatten().map(|(_, value)| value.lot + 1).max().unwrap_or(0);
    let mut left_out = far_at_first(&values, members.len());
    let mut round = 0;
    // ends after MOST_ROUNDS: two sets may follow each other for ever
    let of_members = loop {
        let of_members = deviations(&values, lots, &left_out);
        let distances: Vec<Distance> = of_members.iter().map(|found| distance(found, names)).collect();
        let now = significant(&distances, LEFT_OUT);
        round += 1;
        if now == left_out || round == MOST_ROUNDS {
            break of_members;
        }
        left_out = now;
    };
    let inside: Vec<Member<'_>> = members
        .iter()
        .zip(&left_out)
        .filter(|(_, left_out)| !**left_out)
        .map(|(member, _)| *member)
        .collect();
    let if_far = |found: &Vec<(usize, Deviation)>| -> Vec<f64> {
        let coefficients = found.len() as f64;
        let p_value = |deviation: &Deviation| t_tail(deviation.freedom, FAR * deviation.share) * coefficients;
        found.iter().map(|(_, deviation)| p_value(deviation)).collect()
    };
    // of a coefficient that few devices know none can be spared
    let population = match Population::of(&inside, names) {
        Err(_) => {
            left_out = vec![false; members.len()];
            Population::of(members, names)?
        }
        population => population?,
    };
    Ok(Judged {
        population,
        distances: of_members.iter().map(|found| distance(found, names)).collect(),
        left_out,
        p_values_if_far: of_members.iter().map(if_far).collect(),
    })
}

/// Which of `p_values` are significant, so that of all that are the share that is not so is at most `rate` in the mean (Benjamini and
/// Hochberg 1995).
pub fn discoveries(p_values: &[f64], rate: f64) -> Vec<bool> {
    let mut sorted = p_values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let least = sorted.iter().enumerate().rev().find(|(place, p)| **p <= rate * (*place + 1) as f64 / n);
    p_values.iter().map(|p| least.is_some_and(|(_, limit)| p <= limit)).collect()
}

/// Fewest devices of which one that is [`FAR`] off is found as often as not, where each is compared in `tests` coefficients of all its axes and
/// `rate` of those found may be false. Devices of one lot, whose logs err by less than they differ.
pub fn devices_needed(tests: usize, rate: f64) -> usize {
    let is_found = |devices: &usize| {
        let n = *devices as f64;
        FAR * ((n - 1.0) / n).sqrt() >= t_quantile(n - 2.0, rate / (n * tests.max(1) as f64))
    };
    // with any number of tests that a fleet may have it is found in the end: the quantile grows as the root of a logarithm
    (3..1000).find(is_found).unwrap_or(1000)
}

/// Those that were compared and are significant.
fn significant(distances: &[Distance], rate: f64) -> Vec<bool> {
    let tested = || distances.iter().filter(|distance| distance.coefficients > 0);
    let mut found =
        discoveries(&tested().map(|distance| distance.p_value).collect::<Vec<_>>(), rate).into_iter();
    distances.iter().map(|distance| distance.coefficients > 0 && found.next().unwrap_or(false)).collect()
}

/// Of each member its deviations, with the places of the coefficients, from the population of those that are not left out and are not itself.
fn deviations(
    values: &[Vec<(usize, Value)>],
    lots: usize,
    left_out: &[bool],
) -> Vec<Vec<(usize, Deviation)>> {
    let mut found = vec![Vec::new(); left_out.len()];
    for (place, known) in values.iter().enumerate() {
        let (outside, inside): (Vec<_>, Vec<_>) = known.iter().partition(|(member, _)| left_out[*member]);
        let only_values =
            |known: &[(usize, Value)]| known.iter().map(|(_, value)| *value).collect::<Vec<_>>();
        let [of_members, of_others] =
            Coefficient::of(only_values(&inside), lots).deviations(&only_values(&outside));
        for ((member, _), deviation) in inside.iter().chain(&outside).zip(of_members.iter().chain(&of_others))
        {
            found[*member].extend(deviation.map(|deviation| (place, deviation)));
        }
    }
    found
}

fn distance(found: &[(usize, Deviation)], names: &[String]) -> Distance {
    let least = found.iter().min_by(|(_, a), (_, b)| {
        a.p_value.total_cmp(&b.p_value).then_with(|| b.by.abs().total_cmp(&a.by.abs()))
    });
    Distance {
        coefficients: found.len(),
        p_value: least.map_or(1.0, |(_, least)| (least.p_value * found.len() as f64).min(1.0)),
        most: least.map_or_else(String::new, |(place, _)| names[*place].clone()),
        by: least.map_or(0.0, |(_, least)| least.by),
        freedom: least.map_or(0.0, |(_, least)| least.freedom),
    }
}

/// Far from the median in any coefficient, by the median deviation and the error of its own log: the quantile of Student's t for so many
/// devices and coefficients, so that in few devices none is far by chance.
fn far_at_first(values: &[Vec<(usize, Value)>], members: usize) -> Vec<bool> {
    let mut far = vec![false; members];
    for known in values {
        let n = known.len() as f64;
        let limit = t_quantile(EFFICIENCY * n, LEFT_OUT / (n * values.len() as f64));
        let median = median_of(known.iter().map(|(_, value)| value.value)).unwrap_or(0.0);
        let deviation = median_of(known.iter().map(|(_, value)| (value.value - median).abs())).unwrap_or(0.0);
        let scatter = (PER_MEDIAN_DEVIATION * deviation).powi(2);
        for (member, Value { value, error, .. }) in known {
            far[*member] |= (value - median).powi(2) > limit.powi(2) * (scatter + error);
        }
    }
    // where most are far there is no population to be far from
    if far.iter().filter(|far| **far).count() * 2 > far.len() { vec![false; far.len()] } else { far }
}
