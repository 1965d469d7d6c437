//! Units that do not belong to their population, and by what.

use std::collections::HashMap;

use fos_data::statistics::median_of;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use crate::estimate::Estimate;
use crate::known::matrix_of;
use crate::population::{Likeliest, Lot, Member, Population, PopulationError, tail};

/// A unit that noise alone would set so far apart so rarely is left out where the population is estimated: an odd one would widen what
/// it is judged by.
const LEFT_OUT: f64 = 1e-3;

/// So many scaled median deviations from the median: left out at first, when there is nothing better to judge by.
const FAR_AT_FIRST: f64 = 5.0;

/// A median deviation of a normal distribution over its standard deviation, inverse.
const PER_MEDIAN_DEVIATION: f64 = 1.4826;

/// Most rounds of estimating and leaving out.
const MOST_ROUNDS: usize = 10;

/// How far a unit is from its population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Squared, in standard deviations of what a unit of this lot may be and its log may err (Mahalanobis).
    pub squared: f64,
    /// Coefficients that it is of.
    pub coefficients: usize,
    /// How often a unit that belongs would be further away.
    pub p_value: f64,
    /// The coefficient that is furthest by itself.
    pub most: String,
    /// By so many standard deviations.
    pub by: f64,
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
}

/// The population of `members` without those that do not belong, and how far each is from it.
///
/// # Errors
///
/// Fewer than three units know a coefficient.
pub fn judge(members: &[Member<'_>], names: &[String]) -> Result<Judged, PopulationError> {
    let mut left_out = far_at_first(members, names);
    let mut round = 0;
    // ends after MOST_ROUNDS: two sets may follow each other for ever
    loop {
        let inside: Vec<Member<'_>> = members
            .iter()
            .zip(&left_out)
            .filter(|(_, left_out)| !**left_out)
            .map(|(member, _)| *member)
            .collect();
        let likeliest = Likeliest::of(&inside, names)?;
        let population = &likeliest.population;
        let lots: HashMap<&str, &Lot> = population.lots.iter().map(|lot| (lot.name.as_str(), lot)).collect();
        let distances: Vec<Distance> = members
            .iter()
            .map(|Member { lot, estimate }| {
                population.distance_in(estimate, lot.and_then(|lot| lots.get(lot).copied()))
            })
            .collect();
        let now: Vec<bool> = distances.iter().map(|distance| distance.p_value < LEFT_OUT).collect();
        round += 1;
        if now == left_out || round == MOST_ROUNDS {
            return Ok(Judged { population: likeliest.with_scatter(), distances, left_out });
        }
        left_out = now;
    }
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

impl Population {
    /// How far a unit is from what its lot lets expect.
    pub fn distance(&self, estimate: &Estimate, lot: Option<&str>) -> Distance {
        self.distance_in(estimate, self.lot_named(lot))
    }

    /// The same in a lot of the population, or any.
    fn distance_in(&self, estimate: &Estimate, lot: Option<&Lot>) -> Distance {
        let (mean, covariance) = self.prior_in(lot);
        let ones = vec![1.0; self.names.len()];
        let (mean, prior) = (DVector::from_vec(mean), matrix_of(&covariance));
        let measured = estimate.measured(&self.names, &ones);
        let seen = measured.known.through(&prior);
        let known = |place: usize| measured.errors[place].is_some();
        let off = DVector::from_fn(mean.len(), |place, _| {
            if known(place) { measured.values[place] - mean[place] } else { 0.0 }
        });
        let squared = (off.transpose() * &seen.information * &off)[0].max(0.0);
        let by = |place: usize| {
            measured.errors[place].map(|error| off[place] / (error + prior[(place, place)]).sqrt())
        };
        let most = (0..mean.len())
            .filter_map(|place| Some((place, by(place)?)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let coefficients = (0..mean.len()).filter(|place| known(*place)).count();
        Distance {
            squared,
            coefficients,
            p_value: if coefficients == 0 { 1.0 } else { tail(coefficients, squared) },
            most: most.map_or_else(String::new, |(place, _)| self.names[place].clone()),
            by: most.map_or(0.0, |(_, by)| by),
        }
    }
}

/// Far from the median in any coefficient, by the median deviation and the error of its own log.
fn far_at_first(members: &[Member<'_>], names: &[String]) -> Vec<bool> {
    let mut far = vec![false; members.len()];
    for name in names {
        let known: Vec<(usize, f64, f64)> = members
            .iter()
            .enumerate()
            .filter_map(|(index, member)| {
                let place = member.estimate.place(name)?;
                Some((index, member.estimate.values[place], member.estimate.covariance[place][place]))
            })
            .collect();
        let median = median_of(known.iter().map(|(_, value, _)| *value)).unwrap_or(0.0);
        let deviation = median_of(known.iter().map(|(_, value, _)| (value - median).abs())).unwrap_or(0.0);
        let scatter = (PER_MEDIAN_DEVIATION * deviation).powi(2);
        for (index, value, error) in known {
            far[index] |= (value - median).powi(2) > FAR_AT_FIRST.powi(2) * (scatter + error);
        }
    }
    // where most are far there is no population to be far from
    if far.iter().filter(|far| **far).count() * 2 > far.len() { vec![false; far.len()] } else { far }
}
