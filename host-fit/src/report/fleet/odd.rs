//! A unit that does not belong, beside what its lot lets expect.

use serde::Serialize;

use super::coefficient::{NINETY, unit_of};
use fos_data::column::Column;
use fos_fleet::{OddUnit, PartSummary, UnitRow};

/// A unit that does not belong.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct OddReport {
    /// Its name.
    pub unit: String,
    /// Its lot.
    pub lot: Option<String>,
    /// The axis that shows it best, as in `gyro x`.
    pub label: String,
    /// The coefficient that is furthest there.
    pub coefficient: String,
    /// Its deviation from the population without it, in standard deviations: Student's t.
    pub by: f64,
    /// Probability that a unit that belongs is so far in any of its axes.
    pub p_value: f64,
    /// The unit of the numbers below.
    pub unit_of_size: String,
    /// Its own estimate, and half of its 90 % interval.
    pub estimate: Option<[f64; 2]>,
    /// Where nine of ten units of its lot lie.
    pub expected: Option<[f64; 2]>,
}

impl OddReport {
    pub(super) fn of(odd: &OddUnit, part: &PartSummary, rows: &[&UnitRow]) -> Self {
        let name = &odd.distance.most;
        let (unit_of_size, si) = unit_of(&odd.column, name);
        let axis = rows
            .iter()
            .filter(|row| row.unit == odd.unit)
            .flat_map(|row| &row.axes)
            .find(|axis| axis.estimate.column == odd.column);
        let estimate = axis.and_then(|axis| {
            let estimate = &axis.estimate.coefficients;
            Some([estimate.values[estimate.place(name)?] / si, NINETY * estimate.standard_error(name)? / si])
        });
        let population = part.axes.iter().find(|axis| axis.column == odd.column);
        let expected = population.and_then(|axis| axis.population.as_ref()).and_then(|population| {
            let place = population.names.iter().position(|other| other == name)?;
            Some(population.unit_interval(odd.lot.as_deref(), place).map(|value| value / si))
        });
        Self {
            unit: odd.unit.clone(),
            lot: odd.lot.clone(),
            label: Column::named(&odd.column).label().to_owned(),
            coefficient: name.clone(),
            by: odd.distance.by,
            p_value: odd.p_value,
            unit_of_size,
            estimate,
            expected,
        }
    }
}
