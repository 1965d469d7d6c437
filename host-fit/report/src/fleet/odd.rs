//! Unit that deviates significantly from its population, compared with the interval of its lot.

use serde::Serialize;

use super::coefficient::{NINETY, unit_of};
use fos_data::column::Column;
use fos_fleet::{OddUnit, PartSummary, UnitRow};

/// Unit that deviates significantly from its population.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct OddReport {
    /// Name of the unit.
    pub unit: String,
    /// Lot of the unit.
    pub lot: Option<String>,
    /// Axis with the smallest p-value, such as `gyro x`.
    pub label: String,
    /// Coefficient that deviates most on that axis.
    pub coefficient: String,
    /// Deviation from the population without the unit, in standard deviations: Student's t.
    pub by: f64,
    /// Probability that a unit of the population deviates this far on any of its axes.
    pub p_value: f64,
    /// Unit of `estimate` and `expected`.
    pub unit_of_size: String,
    /// Estimate from the unit's own log, and half of its 90 % interval.
    pub estimate: Option<[f64; 2]>,
    /// 90 % interval of the units of its lot.
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
