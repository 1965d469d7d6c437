//! Detects devices that do not belong to their population.
//!
//! Each coefficient of each device is compared by Student's t with the population without that device, because mean and scatter estimated
//! from few devices are uncertain. The rate at which devices are excluded from the population by chance is at most [`LEFT_OUT`], for any
//! number of devices.

use fos_data::statistics::median_of;
use serde::{Deserialize, Serialize};

use crate::coefficient::{Coefficient, Deviation, Value};
use crate::population::{Member, Population, PopulationError, check, values_of};
use crate::tails::{t_quantile, t_tail};

/// False discovery rate for the exclusion of devices from the estimate of the population, so that an odd device does not widen its own
/// reference. Without odd devices, one axis of a hundred excludes any.
const LEFT_OUT: f64 = 0.01;

/// Standard deviation of a normal distribution over its median absolute deviation.
const PER_MEDIAN_DEVIATION: f64 = 1.4826;

/// Efficiency of the median absolute deviation: with n values it is as uncertain as a standard deviation from this share of n (Hampel
/// 1974).
const EFFICIENCY: f64 = 0.37;

/// Maximum number of rounds of estimation and exclusion.
const MOST_ROUNDS: usize = 10;

/// Deviation, in standard deviations, that a population of sufficient size detects.
pub const FAR: f64 = 8.0;

/// Deviation of a device from its population, for its least probable coefficient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Number of compared coefficients.
    pub coefficients: usize,
    /// Probability that a device of the population deviates further in any of them (Bonferroni).
    pub p_value: f64,
    /// Least probable coefficient.
    pub most: String,
    /// Student's t: deviation from the population without this device, divided by the standard deviation of device, log error and
    /// estimated mean together.
    pub by: f64,
    /// Degrees of freedom of t.
    #[serde(default)]
    pub freedom: f64,
}

/// A population, and the deviation of each member from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessment {
    /// Population without the excluded members.
    pub population: Population,
    /// Deviations in the order of the members.
    pub distances: Vec<Distance>,
    /// For each member, its p-values at a deviation of [`FAR`] standard deviations: one per compared coefficient, times their number.
    pub p_values_if_far: Vec<Vec<f64>>,
}

/// Estimates the population of `members` without those that do not belong, and the deviation of each member.
pub fn assess(members: &[Member<'_>], names: &[String]) -> Result<Assessment, PopulationError> {
    check(members, names)?;
    let values = values_of(members, names);
    let lots = values.iter().flatten().map(|(_, value)| value.lot + 1).max().unwrap_or(0);
    let mut left_out = far_at_first(&values, members.len());
    let mut round = 0;
    // Limited to MOST_ROUNDS, because two sets may alternate forever.
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
    // No device can be excluded if too few have a coefficient.
    let population = match Population::of(&inside, names) {
        Err(_) => Population::of(members, names)?,
        population => population?,
    };
    Ok(Assessment {
        population,
        distances: of_members.iter().map(|found| distance(found, names)).collect(),
        p_values_if_far: of_members.iter().map(if_far).collect(),
    })
}

/// Marks the significant `p_values`, with an expected share of false positives among them of at most `rate` (Benjamini and Hochberg 1995).
pub fn discoveries(p_values: &[f64], rate: f64) -> Vec<bool> {
    let mut sorted = p_values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let least = sorted.iter().enumerate().rev().find(|(place, p)| **p <= rate * (*place + 1) as f64 / n);
    p_values.iter().map(|p| least.is_some_and(|(_, limit)| p <= limit)).collect()
}

/// Fewest devices of one lot with which a device [`FAR`] standard deviations off is detected in half of all cases, with `tests`
/// coefficients per device over all its axes and a false discovery rate of `rate`. Log errors are assumed smaller than the scatter of the
/// devices.
pub fn devices_needed(tests: usize, rate: f64) -> usize {
    let is_found = |devices: &usize| {
        let n = *devices as f64;
        FAR * ((n - 1.0) / n).sqrt() >= t_quantile(n - 2.0, rate / (n * tests.max(1) as f64))
    };
    // Some number below 1000 suffices for any realistic number of tests: the quantile grows as the root of a logarithm.
    (3..1000).find(is_found).unwrap_or(1000)
}

/// Marks the compared devices that are significant.
fn significant(distances: &[Distance], rate: f64) -> Vec<bool> {
    let tested = || distances.iter().filter(|distance| distance.coefficients > 0);
    let mut found =
        discoveries(&tested().map(|distance| distance.p_value).collect::<Vec<_>>(), rate).into_iter();
    distances.iter().map(|distance| distance.coefficients > 0 && found.next().unwrap_or(false)).collect()
}

/// Deviations of each member with the indices of the coefficients, from the population without excluded members and without itself.
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

/// Marks devices far from the median in any coefficient, by the median absolute deviation and the error of their logs. The threshold is the
/// quantile of Student's t for this number of devices and coefficients, so that few devices are not marked by chance.
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
    // If most are far, there is no population to compare with.
    if far.iter().filter(|far| **far).count() * 2 > far.len() { vec![false; far.len()] } else { far }
}
