//! The units of a part as draws of one distribution: θ = μ + a(lot) + b(unit), a and b normal, each θ known as well as its
//! log tells.
//!
//! A hierarchical normal model, its covariances by restricted maximum likelihood (REML; Patterson and Thompson 1971; Harville 1977), the greatest
//! of which expectation and maximisation find (Laird and Ware 1982), sped up by squared extrapolation (Varadhan and Roland
//! 2008). All of it in the order of the members: the same members give the same bits.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::estimate::{Estimate, Measured};
use crate::known::{Known, Seen, is_square, matrix_of, symmetric};

/// Ends after so many rounds, of three steps each, or when a round gains less than this in −2 ln L.
const MOST_ROUNDS: usize = 400;
const GAIN: f64 = 1e-7;

/// Rise of −2 ln L at the ends of an interval: the 90 % quantile of χ² with one degree of freedom.
const RISE: f64 = 2.705_543;

/// An end is found to 10⁻⁶ of the interval, and looked for up to a million times the scatter.
const HALVINGS: usize = 20;
const DOUBLINGS: usize = 40;

/// A unit of a population.
#[derive(Debug, Clone, Copy)]
pub struct Member<'a> {
    /// Units of one lot have a part of their deviation in common; none: its lot is not known, and it is one of its own.
    pub lot: Option<&'a str>,
    /// What its log tells.
    pub estimate: &'a Estimate,
}

/// A population of one axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Population {
    /// The coefficients, in the order of everything below.
    pub names: Vec<String>,
    /// Members.
    pub units: usize,
    /// The mean of the part, μ, in the coefficients' SI units.
    pub mean: Vec<f64>,
    /// Covariance of the mean.
    pub mean_covariance: Vec<Vec<f64>>,
    /// Covariance of a between lots; 0 if there are fewer than two.
    pub between_lots: Vec<Vec<f64>>,
    /// Covariance of b between units of a lot.
    pub between_units: Vec<Vec<f64>>,
    /// Of each coefficient, its scatter.
    pub scatter: Vec<Scatter>,
    /// What is known of each lot.
    pub lots: Vec<Lot>,
}

/// Standard deviations of a coefficient, in its SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Between units of a lot.
    pub units: f64,
    /// Its 90 % interval.
    pub units_interval: [f64; 2],
    /// Between lots.
    pub lots: f64,
    /// Its 90 % interval.
    pub lots_interval: [f64; 2],
    /// How often lots that do not differ in it would look so different; none of fewer than two lots.
    pub lots_alike: Option<f64>,
    /// Of an estimate about its unit: the error of measurement, root mean square.
    pub measurement: f64,
}

/// What is known of a lot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lot {
    /// As the rows name it; empty for units whose lot is not known.
    pub name: String,
    /// Members.
    pub units: usize,
    /// Mean of the lot: μ + a.
    pub mean: Vec<f64>,
    /// Its covariance, that of μ included.
    pub covariance: Vec<Vec<f64>>,
}

/// Why there is no population.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PopulationError {
    /// There is no coefficient that enough units tell.
    #[error(
        "no coefficient is told by three units or more\nhelp: logs of more units at rest; with one temperature alone there is no coefficient of it"
    )]
    NoCoefficient,
    /// A coefficient is known of fewer than two units.
    #[error(
        "{known} units tell this coefficient; a population needs three\nhelp: logs of more units, in which what it depends on changes"
    )]
    TooFew {
        /// Its place among the names.
        coefficient: usize,
        /// Units that tell it.
        known: usize,
    },
}

/// What one value of the covariances comes to.
struct Step {
    /// −2 ln L, restricted, up to a constant.
    deviance: f64,
    mean: DVector<f64>,
    mean_covariance: DMatrix<f64>,
    lots: Vec<LotMean>,
    /// The covariances that follow.
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
    /// A lot's deviation is told apart from its units'.
    has_lots: bool,
}

impl Population {
    /// Of `members`, for the coefficients `names`, which not every unit has to know.
    ///
    /// # Errors
    ///
    /// There are none, or fewer than three units know one of them.
    pub fn of(members: &[Member<'_>], names: &[String]) -> Result<Self, PopulationError> {
        Ok(Likeliest::of(members, names)?.with_scatter())
    }

    /// Every coefficient has its numbers: of what was read that is not said by its type.
    pub(crate) fn is_whole(&self) -> bool {
        let n = self.names.len();
        let matrices = [&self.mean_covariance, &self.between_lots, &self.between_units];
        n > 0
            && self.mean.len() == n
            && self.scatter.len() == n
            && matrices.iter().all(|matrix| is_square(matrix, n))
            && self.lots.iter().all(|lot| lot.mean.len() == n && is_square(&lot.covariance, n))
    }

    /// What is known of a unit before it was measured: mean and covariance of its coefficients. Of a lot that the
    /// population does not know, or none, that of any lot.
    pub fn prior(&self, lot: Option<&str>) -> (Vec<f64>, Vec<Vec<f64>>) {
        self.prior_in(self.lot_named(lot))
    }

    /// A lot that the population knows.
    pub(crate) fn lot_named(&self, name: Option<&str>) -> Option<&Lot> {
        name.and_then(|name| self.lots.iter().find(|lot| lot.name == name))
    }

    /// The same in a lot of the population, or any.
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

    /// What is known of a unit that is a member of the population, all coefficients of it: its log counts once, in the mean of its lot and beside
    /// it, as it does in the steps that found the population. Of a lot that is not among the population's, as [`shrunk`](Self::shrunk).
    pub fn of_member(&self, estimate: &Estimate, lot: Option<&str>) -> Estimate {
        let name = lot.unwrap_or_default();
        let Some(lot) = self.lots.iter().find(|lot| lot.name == name) else {
            return self.shrunk(estimate, None);
        };
        let (mean, of_lot) = (DVector::from_column_slice(&lot.mean), matrix_of(&lot.covariance));
        let scatter = matrix_of(&self.between_units);
        let ones = vec![1.0; self.names.len()];
        let seen = estimate.measured(&self.names, &ones).known.through(&scatter);
        let values = &mean + &scatter * (&seen.weighted - &seen.information * &mean);
        let gain = &scatter * &seen.information;
        let rest = DMatrix::identity(mean.len(), mean.len()) - &gain;
        let covariance = symmetric(&(&scatter - &gain * &scatter + &rest * of_lot * rest.transpose()));
        Estimate {
            names: self.names.clone(),
            values: values.iter().copied().collect(),
            covariance: nested(&covariance),
        }
    }

    /// A unit's own estimate beside what its population says of it (empirical Bayes; Robbins 1956, Efron and Morris 1973): all coefficients of the
    /// population, those that the estimate does not tell too. For a unit that is not among the members; for one
    /// that is, [`of_member`](Self::of_member).
    pub fn shrunk(&self, estimate: &Estimate, lot: Option<&str>) -> Estimate {
        let (mean, covariance) = self.prior(lot);
        let (mean, prior) = (DVector::from_vec(mean), matrix_of(&covariance));
        let ones = vec![1.0; self.names.len()];
        let seen = estimate.measured(&self.names, &ones).known.through(&prior);
        let values = &mean + &prior * (&seen.weighted - &seen.information * &mean);
        let covariance = symmetric(&(&prior - &prior * &seen.information * &prior));
        Estimate {
            names: self.names.clone(),
            values: values.iter().copied().collect(),
            covariance: nested(&covariance),
        }
    }
}

/// A population without its scatter, whose intervals cost more than all else.
pub(crate) struct Likeliest {
    pub(crate) population: Population,
    grouped: Grouped,
    covariances: Covariances,
    scale: Vec<f64>,
}

impl Likeliest {
    /// As [`Population::of`].
    pub(crate) fn of(members: &[Member<'_>], names: &[String]) -> Result<Self, PopulationError> {
        if names.is_empty() {
            return Err(PopulationError::NoCoefficient);
        }
        for (coefficient, name) in names.iter().enumerate() {
            let known = members.iter().filter(|member| member.estimate.place(name).is_some()).count();
            if known < 3 {
                return Err(PopulationError::TooFew { coefficient, known });
            }
        }
        let scale = scales(members, names);
        let grouped = Grouped::of(members, names, &scale);
        let (covariances, last) = grouped.likeliest(true);
        let unscaled = |matrix: &DMatrix<f64>| rows_of(matrix, &scale);
        let lots = grouped.names.iter().zip(&last.lots).map(|((name, units), lot)| Lot {
            name: name.clone(),
            units: *units,
            mean: lot.mean.iter().zip(&scale).map(|(mean, scale)| mean * scale).collect(),
            covariance: unscaled(&lot.covariance),
        });
        let population = Population {
            names: names.to_vec(),
            units: members.len(),
            mean: last.mean.iter().zip(&scale).map(|(mean, scale)| mean * scale).collect(),
            mean_covariance: unscaled(&last.mean_covariance),
            between_lots: unscaled(&covariances.lots),
            between_units: unscaled(&covariances.units),
            scatter: Vec::new(),
            lots: lots.collect(),
        };
        Ok(Self { population, grouped, covariances, scale })
    }

    /// With it.
    pub(crate) fn with_scatter(self) -> Population {
        Population { scatter: self.grouped.scatter(&self.covariances, &self.scale), ..self.population }
    }
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

    /// One coefficient as if there were no others.
    fn alone(&self, place: usize) -> Self {
        let lots = self.lots.iter().map(|lot| lot.iter().map(|unit| unit.alone(place)).collect()).collect();
        Self { names: self.names.clone(), lots, has_lots: self.has_lots }
    }

    /// How often lots that do not differ would look so different, of one coefficient: twice the logarithm of the likelihood ratio is
    /// then 0 in half of all cases, and else a χ² of one degree of freedom (Self and Liang 1987).
    fn lots_alike(&self) -> f64 {
        let [(_, with), (_, without)] = [true, false].map(|with_lots| self.likeliest(with_lots));
        match without.deviance - with.deviance {
            ratio if ratio > GAIN => 0.5 * tail(1, ratio),
            _ => 1.0,
        }
    }

    fn units(&self) -> impl Iterator<Item = &Measured> {
        self.lots.iter().flatten()
    }

    /// The covariances of the greatest restricted likelihood, and what they come to.
    fn likeliest(&self, with_lots: bool) -> (Covariances, Step) {
        let n = self.lots[0][0].values.len();
        let start =
            if with_lots && self.has_lots { DMatrix::identity(n, n) * 0.3 } else { DMatrix::zeros(n, n) };
        let mut now = Covariances { lots: start, units: DMatrix::identity(n, n) };
        let mut step = self.step(&now);
        for _ in 0..MOST_ROUNDS {
            let first = step.next.clone();
            let second = self.step(&first);
            let leap = now.extrapolated(&first, &second.next);
            let mut best = (first, second);
            // far away it may be less likely than what it leapt from
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
        let seen: Vec<Vec<Seen>> = self
            .lots
            .iter()
            .map(|lot| lot.iter().map(|unit| unit.known.through(&covariances.units)).collect())
            .collect();
        let mut deviance = 0.0;
        let mut of_lots = Vec::new();
        let mut all = Known::nothing(n);
        let mut together = Vec::new();
        for (lot, units) in seen.iter().zip(&self.lots) {
            let mut of_lot = Known::nothing(n);
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

    /// Standard deviations, with the intervals of each coefficient as if there were no others: every value at which −2 ln L lies
    /// at most [`RISE`] above its least, the other variance as it is there.
    fn scatter(&self, covariances: &Covariances, scale: &[f64]) -> Vec<Scatter> {
        let of = |place: usize| {
            let alone = self.alone(place);
            let (likeliest, _) = alone.likeliest(true);
            let joint = [covariances.units[(place, place)], covariances.lots[(place, place)]];
            let ends = |variance: usize| {
                let [low, high] = alone.interval(&likeliest, variance);
                [low.min(joint[variance]), high.max(joint[variance])].map(|end| scale[place] * end.sqrt())
            };
            let errors: Vec<f64> = self.units().filter_map(|unit| unit.errors[place]).collect();
            Scatter {
                units: scale[place] * joint[0].sqrt(),
                units_interval: ends(0),
                lots: scale[place] * joint[1].sqrt(),
                lots_interval: if self.has_lots { ends(1) } else { [0.0, 0.0] },
                lots_alike: self.has_lots.then(|| alone.lots_alike()),
                measurement: scale[place] * (errors.iter().sum::<f64>() / errors.len() as f64).sqrt(),
            }
        };
        (0..scale.len()).into_par_iter().map(of).collect()
    }

    /// The 90 % interval of a variance of the only coefficient: that between units (0) or between lots (1).
    fn interval(&self, likeliest: &Covariances, variance: usize) -> [f64; 2] {
        let best = self.step(likeliest).deviance;
        let rise = |value: f64| {
            let mut there = likeliest.clone();
            let place = if variance == 0 { &mut there.units } else { &mut there.lots };
            place[(0, 0)] = value;
            self.step(&there).deviance - best - RISE
        };
        let at = if variance == 0 { likeliest.units[(0, 0)] } else { likeliest.lots[(0, 0)] };
        let crossing = |mut inside: f64, mut outside: f64| {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                *(if rise(middle) > 0.0 { &mut outside } else { &mut inside }) = middle;
            }
            inside
        };
        let low = if rise(0.0) > 0.0 { crossing(at, 0.0) } else { 0.0 };
        // scaled coefficients vary by about 1
        let mut far = at.max(1e-3);
        for _ in 0..DOUBLINGS {
            if rise(far) > 0.0 {
                break;
            }
            far *= 2.0;
        }
        [low, crossing(at, far)]
    }
}

/// How often a χ² of so many degrees of freedom is larger.
pub(crate) fn tail(freedom: usize, value: f64) -> f64 {
    ChiSquared::new(freedom as f64).map_or(1.0, |distribution| distribution.sf(value))
}

impl Covariances {
    /// Where the last two steps lead, if those are covariances.
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
        let sound = |matrix: &DMatrix<f64>| matrix.clone().cholesky().is_some();
        (sound(&there.units) && (there.lots.norm_squared() == 0.0 || sound(&there.lots))).then_some(there)
    }
}

/// The size of each coefficient: about what its values scatter by, so that all are near 1.
fn scales(members: &[Member<'_>], names: &[String]) -> Vec<f64> {
    let scale = |name: &String| {
        let values: Vec<f64> = members
            .iter()
            .filter_map(|member| Some(member.estimate.values[member.estimate.place(name)?]))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        if variance > 0.0 { variance.sqrt() } else { mean.abs().max(f64::MIN_POSITIVE) }
    };
    names.iter().map(scale).collect()
}

fn nested(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn rows_of(matrix: &DMatrix<f64>, scale: &[f64]) -> Vec<Vec<f64>> {
    let at = |row: usize, column: usize| matrix[(row, column)] * scale[row] * scale[column];
    (0..scale.len()).map(|row| (0..scale.len()).map(|column| at(row, column)).collect()).collect()
}
