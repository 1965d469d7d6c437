//! The units of a part as draws from one distribution: θ = μ + a(lot) + b(unit), with normal a and b. Each θ is known with the uncertainty
//! of its log.
//!
//! The model is a hierarchical normal one. Its covariances are estimated by restricted maximum likelihood (REML; Patterson and Thompson
//! 1971; Harville 1977), by expectation and maximisation (Laird and Ware 1982) with squared extrapolation (Varadhan and Roland 2008). Sums
//! run in the order of the members, so the same members give the same bits.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::coefficient::{Coefficient, Value, Variances};
use crate::estimate::{Estimate, Measured};
use crate::information::{Information, MeanInformation, is_square, matrix_of, symmetric};
use crate::tails::half_interval;

/// Maximum number of rounds of three steps, and the decrease of −2 ln L per round below which the search ends.
const MOST_ROUNDS: usize = 400;
const GAIN: f64 = 1e-7;

/// Smallest scaled variance at the start of the search.
const LEAST_START: f64 = 1e-2;

/// Half of a 90 % interval of a normal distribution, in standard deviations.
const NORMAL: f64 = 1.644_854;

/// A unit of a population.
#[derive(Debug, Clone, Copy)]
pub struct Member<'a> {
    /// Units of one lot share a part of their deviation. Units without a lot are treated as one more lot.
    pub lot: Option<&'a str>,
    pub estimate: &'a Estimate,
}

/// Distribution of the coefficients of one axis over the units of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Population {
    /// Names of the coefficients; the order applies to all fields below.
    pub names: Vec<String>,
    pub units: usize,
    /// Mean of the part, μ, in the SI units of the coefficients.
    pub mean: Vec<f64>,
    /// Covariance of the mean.
    pub mean_covariance: Vec<Vec<f64>>,
    /// 90 % interval of each mean, by Student's t, because the variances are estimated from a finite number of units.
    #[serde(default)]
    pub mean_interval: Vec<[f64; 2]>,
    /// 90 % interval of each coefficient of a unit of unknown lot, by Student's t.
    #[serde(default)]
    pub unit_interval: Vec<[f64; 2]>,
    /// Covariance of a, between lots; 0 with fewer than two lots.
    pub between_lots: Vec<Vec<f64>>,
    /// Covariance of b, between units of a lot.
    pub between_units: Vec<Vec<f64>>,
    /// Scatter of each coefficient.
    pub scatter: Vec<Scatter>,
    /// Mean and covariance of each lot.
    pub lots: Vec<Lot>,
}

/// Standard deviations of a coefficient, in its SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Standard deviation between units of a lot.
    pub units: f64,
    /// 90 % interval of `units`.
    pub units_interval: [f64; 2],
    pub lots: f64,
    /// 90 % interval of `lots`.
    pub lots_interval: [f64; 2],
    /// p-value of the observed difference between lots if lots do not differ; none with fewer than two lots.
    pub lots_alike: Option<f64>,
    /// RMS error of measurement: an estimate about the true value of its unit.
    pub measurement: f64,
}

/// Mean and covariance of a lot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lot {
    /// Name of the lot in the rows; empty for units without a lot.
    pub name: String,
    pub units: usize,
    /// Mean of the lot: μ + a.
    pub mean: Vec<f64>,
    /// Covariance of the mean, that of μ included.
    pub covariance: Vec<Vec<f64>>,
    /// 90 % interval of each mean, by Student's t.
    #[serde(default)]
    pub mean_interval: Vec<[f64; 2]>,
    /// 90 % interval of each coefficient of a unit of this lot, by Student's t.
    #[serde(default)]
    pub unit_interval: Vec<[f64; 2]>,
}

impl Lot {
    /// 90 % interval of the mean of coefficient `place`, as [`Population::mean_interval`].
    pub fn mean_interval(&self, place: usize) -> [f64; 2] {
        let normal = || about(self.mean[place], NORMAL, self.covariance[place][place]);
        self.mean_interval.get(place).copied().unwrap_or_else(normal)
    }
}

/// Too little data for a population.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PopulationError {
    #[error(
        "no coefficient is identifiable from the logs of three devices or more\nhelp: record more devices at rest for some minutes, while the temperature changes"
    )]
    NoCoefficient,
    #[error(
        "this coefficient is identifiable from the logs of {known} devices; a population needs three\nhelp: record more devices at rest, while what the coefficient depends on changes"
    )]
    TooFew {
        /// Index among the names.
        coefficient: usize,
        known: usize,
    },
}

/// Result of one step at given covariances.
struct Step {
    /// −2 ln L, restricted, up to a constant.
    deviance: f64,
    mean: DVector<f64>,
    mean_covariance: DMatrix<f64>,
    lots: Vec<LotMean>,
    /// Covariances after the step.
    next: Covariances,
}

/// μ + a of a lot, in scaled coefficients.
struct LotMean {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

#[derive(Debug, Clone, PartialEq)]
struct Covariances {
    lots: DMatrix<f64>,
    units: DMatrix<f64>,
}

/// The members by lot, in scaled coefficients.
struct Grouped {
    names: Vec<(String, usize)>,
    lots: Vec<Vec<Measured>>,
    /// The variance between lots is distinguishable from that between units.
    has_lots: bool,
}

impl Population {
    /// Estimates the population of `members` for the coefficients `names`; not every unit needs to have each of them.
    pub fn of(members: &[Member<'_>], names: &[String]) -> Result<Self, PopulationError> {
        check(members, names)?;
        let scale = scales(members, names);
        let grouped = Grouped::of(members, names, &scale);
        let alone: Vec<Coefficient> = values_of(members, names)
            .into_iter()
            .map(|known| {
                Coefficient::of(known.into_iter().map(|(_, value)| value).collect(), grouped.lots.len())
            })
            .collect();
        let by_itself: Vec<Variances> = alone.par_iter().map(Coefficient::variances).collect();
        let (covariances, last) = grouped.likeliest(&by_itself, &scale);
        let unscaled = |matrix: &DMatrix<f64>| rows_of(matrix, &scale);
        let lots = grouped.names.iter().zip(&last.lots).map(|((name, units), lot)| Lot {
            name: name.clone(),
            units: *units,
            mean: lot.mean.iter().zip(&scale).map(|(mean, scale)| mean * scale).collect(),
            covariance: unscaled(&lot.covariance),
            mean_interval: Vec::new(),
            unit_interval: Vec::new(),
        });
        let mut population = Self {
            names: names.to_vec(),
            units: members.len(),
            mean: last.mean.iter().zip(&scale).map(|(mean, scale)| mean * scale).collect(),
            mean_covariance: unscaled(&last.mean_covariance),
            mean_interval: Vec::new(),
            unit_interval: Vec::new(),
            between_lots: unscaled(&covariances.lots),
            between_units: unscaled(&covariances.units),
            scatter: Vec::new(),
            lots: lots.collect(),
        };
        population.scatter = alone
            .par_iter()
            .enumerate()
            .map(|(place, alone)| population.scatter_of(place, alone, members))
            .collect();
        for (place, alone) in alone.iter().enumerate() {
            population.add_intervals(place, alone);
        }
        Ok(population)
    }

    /// Every coefficient has all its numbers, and all are finite: types do not ensure this for a file that was read.
    pub(crate) fn is_complete(&self) -> bool {
        let n = self.names.len();
        let matrices = [&self.mean_covariance, &self.between_lots, &self.between_units];
        let finite = |values: &[f64]| values.len() == n && values.iter().all(|value| value.is_finite());
        let square = |matrix: &[Vec<f64>]| is_square(matrix, n) && matrix.iter().all(|row| finite(row));
        // Populations of earlier versions have no intervals of means and units.
        let intervals = |ends: &[[f64; 2]]| {
            ends.is_empty() || ends.len() == n && ends.iter().flatten().all(|end| end.is_finite())
        };
        let scatter = |scatter: &Scatter| {
            let [units, lots] = [scatter.units_interval, scatter.lots_interval];
            let values =
                [scatter.units, scatter.lots, scatter.measurement, scatter.lots_alike.unwrap_or(0.0)];
            values.iter().chain(&units).chain(&lots).all(|value| value.is_finite())
        };
        n > 0
            && finite(&self.mean)
            && self.scatter.len() == n
            && self.scatter.iter().all(scatter)
            && matrices.iter().all(|matrix| square(matrix))
            && intervals(&self.mean_interval)
            && intervals(&self.unit_interval)
            && self.lots.iter().all(|lot| {
                finite(&lot.mean)
                    && square(&lot.covariance)
                    && intervals(&lot.mean_interval)
                    && intervals(&lot.unit_interval)
            })
    }

    /// 90 % interval of the mean of coefficient `place`. For a population of an earlier version, which has none, that of a normal
    /// distribution.
    pub fn mean_interval(&self, place: usize) -> [f64; 2] {
        let normal = || about(self.mean[place], NORMAL, self.mean_covariance[place][place]);
        self.mean_interval.get(place).copied().unwrap_or_else(normal)
    }

    /// 90 % interval of coefficient `place` of a unit of `lot`, or of any lot. For a population of an earlier version as
    /// [`mean_interval`](Self::mean_interval).
    pub fn unit_interval(&self, lot: Option<&str>, place: usize) -> [f64; 2] {
        let lot = self.lot_named(lot);
        let normal = || {
            let (mean, covariance) = self.prior_in(lot);
            about(mean[place], NORMAL, covariance[place][place])
        };
        let intervals = lot.map_or(&self.unit_interval, |lot| &lot.unit_interval);
        intervals.get(place).copied().unwrap_or_else(normal)
    }

    /// Mean and covariance of the coefficients of a unit before its measurement. For a lot that is unknown or none, those of a unit of
    /// any lot.
    pub fn prior(&self, lot: Option<&str>) -> (Vec<f64>, Vec<Vec<f64>>) {
        self.prior_in(self.lot_named(lot))
    }

    /// Lot of this name, if the population has it.
    pub(crate) fn lot_named(&self, name: Option<&str>) -> Option<&Lot> {
        name.and_then(|name| self.lots.iter().find(|lot| lot.name == name))
    }

    /// Mean and covariance of [`prior`](Self::prior) for a lot of the population, or for any lot.
    pub(crate) fn prior_in(&self, lot: Option<&Lot>) -> (Vec<f64>, Vec<Vec<f64>>) {
        let units = matrix_of(&self.between_units);
        match lot {
            Some(lot) => (lot.mean.clone(), nested(&(units + matrix_of(&lot.covariance)))),
            None => {
                let total = units + matrix_of(&self.between_lots) + matrix_of(&self.mean_covariance);
                (self.mean.clone(), nested(&total))
            }
        }
    }

    /// Posterior of all coefficients of a unit that is a member of the population. Its log enters once, both in the mean of its lot and
    /// in its own estimate, as in the last step of the search. For a lot that is not in the population, as [`shrunk`](Self::shrunk).
    pub fn of_member(&self, estimate: &Estimate, lot: Option<&str>) -> Estimate {
        let name = lot.unwrap_or_default();
        let Some(lot) = self.lots.iter().find(|lot| lot.name == name) else {
            return self.shrunk(estimate, None);
        };
        let size = self.sizes(&self.prior_in(Some(lot)).1);
        let (mean, of_lot) = (scaled(&lot.mean, &size), scaled_matrix(&lot.covariance, &size));
        let scatter = scaled_matrix(&self.between_units, &size);
        let seen = estimate.measured(&self.names, &size).information.through(&scatter);
        let values = &mean + &scatter * (&seen.weighted - &seen.information * &mean);
        let gain = &scatter * &seen.information;
        let rest = DMatrix::identity(mean.len(), mean.len()) - &gain;
        let covariance = symmetric(&(&scatter - &gain * &scatter + &rest * of_lot * rest.transpose()));
        self.estimate_of(&values, &covariance, &size)
    }

    /// Posterior of all coefficients of a unit outside the population: its own estimate combined with the population as prior
    /// (empirical Bayes; Robbins 1956, Efron and Morris 1973), including coefficients missing from the estimate. For a member of the
    /// population use [`of_member`](Self::of_member).
    pub fn shrunk(&self, estimate: &Estimate, lot: Option<&str>) -> Estimate {
        let (mean, prior) = self.prior(lot);
        let size = self.sizes(&prior);
        let (mean, prior) = (scaled(&mean, &size), scaled_matrix(&prior, &size));
        let seen = estimate.measured(&self.names, &size).information.through(&prior);
        let values = &mean + &prior * (&seen.weighted - &seen.information * &mean);
        let covariance = symmetric(&(&prior - &prior * &seen.information * &prior));
        self.estimate_of(&values, &covariance, &size)
    }

    /// Scale of each coefficient during the computation, so that all are near 1.
    fn sizes(&self, prior: &[Vec<f64>]) -> Vec<f64> {
        let size = |place: usize| match prior[place][place].sqrt() {
            deviation if deviation > 0.0 => deviation,
            _ => 1.0,
        };
        (0..self.names.len()).map(size).collect()
    }

    fn estimate_of(&self, values: &DVector<f64>, covariance: &DMatrix<f64>, size: &[f64]) -> Estimate {
        Estimate {
            names: self.names.clone(),
            values: values.iter().zip(size).map(|(value, size)| value * size).collect(),
            covariance: rows_of(covariance, size),
        }
    }
}

/// `names` is not empty, and at least three units have each coefficient.
pub(crate) fn check(members: &[Member<'_>], names: &[String]) -> Result<(), PopulationError> {
    if names.is_empty() {
        return Err(PopulationError::NoCoefficient);
    }
    for (coefficient, name) in names.iter().enumerate() {
        let known = members.iter().filter(|member| member.estimate.place(name).is_some()).count();
        if known < 3 {
            return Err(PopulationError::TooFew { coefficient, known });
        }
    }
    Ok(())
}

/// For each coefficient, the values of the members that have it, with their indices. Lots are numbered in the order of their first
/// appearance.
pub(crate) fn values_of(members: &[Member<'_>], names: &[String]) -> Vec<Vec<(usize, Value)>> {
    let mut places = HashMap::new();
    let lots: Vec<usize> = members
        .iter()
        .map(|member| {
            let next = places.len();
            *places.entry(member.lot.unwrap_or_default()).or_insert(next)
        })
        .collect();
    let known = |name: &String| {
        let value = |(index, member): (usize, &Member<'_>)| {
            let place = member.estimate.place(name)?;
            let (value, error) = (member.estimate.values[place], member.estimate.covariance[place][place]);
            Some((index, Value { lot: lots[index], value, error }))
        };
        members.iter().enumerate().filter_map(value).collect()
    };
    names.iter().map(known).collect()
}

impl Population {
    /// Scatter of a coefficient, with the intervals from `alone`, the fit of this coefficient only.
    fn scatter_of(&self, place: usize, alone: &Coefficient, members: &[Member<'_>]) -> Scatter {
        let joint = [self.between_units[place][place], self.between_lots[place][place]].map(|v| v.max(0.0));
        // The interval is widened to contain the joint estimate.
        let ends = |[low, high]: [f64; 2], joint: f64| [low.min(joint), high.max(joint)].map(f64::sqrt);
        let errors: Vec<f64> = members
            .iter()
            .filter_map(|member| {
                let own = member.estimate.place(&self.names[place])?;
                Some(member.estimate.covariance[own][own])
            })
            .collect();
        Scatter {
            units: joint[0].sqrt(),
            units_interval: ends(alone.units_interval(), joint[0]),
            lots: joint[1].sqrt(),
            lots_interval: if alone.has_lots() { ends(alone.lots_interval(), joint[1]) } else { [0.0; 2] },
            lots_alike: alone.lots_alike(),
            measurement: (errors.iter().sum::<f64>() / errors.len().max(1) as f64).sqrt(),
        }
    }

    /// Adds the intervals of means and units for one coefficient.
    fn add_intervals(&mut self, place: usize, alone: &Coefficient) {
        let of_units = self.between_units[place][place];
        let of_lots = self.between_lots[place][place];
        let freedom = alone.freedom(of_units, of_lots);
        let of_mean = self.mean_covariance[place][place];
        self.mean_interval.push(about(self.mean[place], half_interval(freedom.mean), of_mean));
        let of_unit = of_units + of_lots + of_mean;
        self.unit_interval.push(about(self.mean[place], half_interval(freedom.unit), of_unit));
        for (index, lot) in self.lots.iter_mut().enumerate() {
            // Lots that are indistinguishable from their units are one lot.
            let freedom = freedom.lots.get(index).unwrap_or(&freedom.lots[0]);
            let [of_mean, of_unit] = freedom.map(half_interval);
            let variance = lot.covariance[place][place];
            lot.mean_interval.push(about(lot.mean[place], of_mean, variance));
            lot.unit_interval.push(about(lot.mean[place], of_unit, variance + of_units));
        }
    }
}

fn about(middle: f64, half: f64, variance: f64) -> [f64; 2] {
    let half = half * variance.max(0.0).sqrt();
    [middle - half, middle + half]
}

impl Grouped {
    fn of(members: &[Member<'_>], names: &[String], scale: &[f64]) -> Self {
        let mut grouped = Self { names: Vec::new(), lots: Vec::new(), has_lots: false };
        let mut places = HashMap::new();
        for member in members {
            let measured = member.estimate.measured(names, scale);
            let name = member.lot.unwrap_or_default();
            let place = *places.entry(name).or_insert_with(|| {
                grouped.names.push((name.to_owned(), 0));
                grouped.lots.push(Vec::new());
                grouped.lots.len() - 1
            });
            grouped.names[place].1 += 1;
            grouped.lots[place].push(measured);
        }
        grouped.has_lots = grouped.lots.len() > 1 && grouped.lots.iter().any(|units| units.len() > 1);
        grouped
    }

    fn units(&self) -> impl Iterator<Item = &Measured> {
        self.lots.iter().flatten()
    }

    /// Covariances with the greatest restricted likelihood, and the last step. The search begins at `by_itself`, the variances from
    /// separate fits of each coefficient, which are the result for a single coefficient.
    fn likeliest(&self, by_itself: &[Variances], scale: &[f64]) -> (Covariances, Step) {
        let n = scale.len();
        // Expectation and maximisation never leave a variance of 0.
        let least = if n == 1 { 0.0 } else { LEAST_START };
        let diagonal = |of: &dyn Fn(&Variances) -> f64| {
            let start =
                by_itself.iter().zip(scale).map(|(own, scale)| (of(own) / (scale * scale)).max(least));
            DMatrix::from_diagonal(&DVector::from_iterator(n, start))
        };
        let lots = if self.has_lots { diagonal(&|own| own.lots) } else { DMatrix::zeros(n, n) };
        let mut now = Covariances { lots, units: diagonal(&|own| own.units) };
        let mut step = self.step(&now);
        if n == 1 {
            return (now, step);
        }
        for _ in 0..MOST_ROUNDS {
            let first = step.next.clone();
            let second = self.step(&first);
            let leap = now.extrapolated(&first, &second.next);
            let mut best = (first, second);
            // A far extrapolation may be less likely than its start.
            if let Some(leap) = leap {
                let there = self.step(&leap);
                if there.deviance < best.1.deviance {
                    best = (leap, there);
                }
            }
            let gained = step.deviance - best.1.deviance;
            (now, step) = best;
            if gained.abs() < GAIN {
                break;
            }
        }
        (now, step)
    }

    /// One step of expectation and maximisation.
    fn step(&self, covariances: &Covariances) -> Step {
        let n = covariances.units.nrows();
        let seen: Vec<Vec<MeanInformation>> = self
            .lots
            .iter()
            .map(|lot| lot.iter().map(|unit| unit.information.through(&covariances.units)).collect())
            .collect();
        let mut deviance = 0.0;
        let mut of_lots = Vec::new();
        let mut all = Information::nothing(n);
        let mut together = Vec::new();
        for (lot, units) in seen.iter().zip(&self.lots) {
            let mut of_lot = Information::nothing(n);
            for (seen, unit) in lot.iter().zip(units) {
                deviance += seen.log_determinant + unit.values.dot(&seen.weighted);
                of_lot.add(seen);
            }
            let through = of_lot.through(&covariances.lots);
            deviance += through.log_determinant;
            // −mᵀ(M + A⁻¹)⁻¹m = −mᵀA(I + MA)⁻¹m
            deviance -= (of_lot.weighted.transpose() * &covariances.lots * &through.weighted)[0];
            all.add(&through);
            of_lots.push(through);
            together.push(of_lot);
        }
        let mean_covariance = all
            .information
            .clone()
            .pseudo_inverse(f64::MIN_POSITIVE)
            .unwrap_or_else(|_| DMatrix::zeros(n, n));
        let mean_covariance = symmetric(&mean_covariance);
        let mean = &mean_covariance * &all.weighted;
        deviance += all.information.determinant().abs().ln() - (mean.transpose() * &all.weighted)[0];

        let (mut lots_next, mut units_next) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let mut lots = Vec::new();
        for (through, units) in of_lots.iter().zip(&seen) {
            let a = &covariances.lots;
            let moved = a * (&through.weighted - &through.information * &mean);
            let gain = a * &through.information;
            let own = a - &gain * a;
            lots_next += &moved * moved.transpose() + &own + &gain * &mean_covariance * gain.transpose();
            let rest = DMatrix::identity(n, n) - &gain;
            let covariance = symmetric(&(own + &rest * &mean_covariance * rest.transpose()));
            let lot = LotMean { mean: &mean + moved, covariance };
            for unit in units {
                let b = &covariances.units;
                let gain = b * &unit.information;
                let moved = b * (&unit.weighted - &unit.information * &lot.mean);
                units_next +=
                    &moved * moved.transpose() + b - &gain * b + &gain * &lot.covariance * gain.transpose();
            }
            lots.push(lot);
        }
        let n_units = self.units().count() as f64;
        let next = Covariances {
            lots: symmetric(&(lots_next / self.lots.len() as f64)),
            units: symmetric(&(units_next / n_units)),
        };
        Step { deviance, mean, mean_covariance, lots, next }
    }
}

impl Covariances {
    /// Squared extrapolation of the last two steps; none if the result is not positive definite.
    fn extrapolated(&self, first: &Self, second: &Self) -> Option<Self> {
        let of = |a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>| (b - a, c - b - (b - a));
        let (lots, units) =
            (of(&self.lots, &first.lots, &second.lots), of(&self.units, &first.units, &second.units));
        let (moved, turned) =
            (lots.0.norm_squared() + units.0.norm_squared(), lots.1.norm_squared() + units.1.norm_squared());
        if turned <= 0.0 || turned.is_nan() {
            return None;
        }
        let reach = (moved / turned).sqrt().max(1.0);
        let leap = |from: &DMatrix<f64>, (moved, turned): &(DMatrix<f64>, DMatrix<f64>)| {
            symmetric(&(from + moved * (2.0 * reach) + turned * (reach * reach)))
        };
        let there = Self { lots: leap(&self.lots, &lots), units: leap(&self.units, &units) };
        let is_positive_definite = |matrix: &DMatrix<f64>| matrix.clone().cholesky().is_some();
        (is_positive_definite(&there.units)
            && (there.lots.norm_squared() == 0.0 || is_positive_definite(&there.lots)))
        .then_some(there)
    }
}

/// Scale of each coefficient: the scatter of its values, and at least their RMS error, so that scaled values are near 1 even if all values
/// are equal.
fn scales(members: &[Member<'_>], names: &[String]) -> Vec<f64> {
    let scale = |known: Vec<(usize, Value)>| {
        let n = known.len() as f64;
        let mean = known.iter().map(|(_, value)| value.value).sum::<f64>() / n;
        let square =
            known.iter().map(|(_, value)| (value.value - mean).powi(2) + value.error).sum::<f64>() / n;
        if square > 0.0 { square.sqrt() } else { 1.0 }
    };
    values_of(members, names).into_iter().map(scale).collect()
}

fn scaled(values: &[f64], scale: &[f64]) -> DVector<f64> {
    DVector::from_iterator(scale.len(), values.iter().zip(scale).map(|(value, scale)| value / scale))
}

fn scaled_matrix(rows: &[Vec<f64>], scale: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(scale.len(), scale.len(), |row, column| rows[row][column] / (scale[row] * scale[column]))
}

fn nested(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn rows_of(matrix: &DMatrix<f64>, scale: &[f64]) -> Vec<Vec<f64>> {
    let at = |row: usize, column: usize| matrix[(row, column)] * scale[row] * scale[column];
    (0..scale.len()).map(|row| (0..scale.len()).map(|column| at(row, column)).collect()).collect()
}
