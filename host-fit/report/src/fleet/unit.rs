//! Unit compared with its population: the estimate from its log, the interval of its lot, and both combined.

use serde::Serialize;

use super::coefficient::{NINETY, unit_of};
use fos_data::column::Column;
use fos_fleet::{AxisSummary, PartSummary, UnitRow, known_of};

/// Report on one unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct UnitReport {
    /// Name of the unit.
    pub unit: String,
    /// Part of the unit.
    pub part: String,
    /// Lot of the unit.
    pub lot: Option<String>,
    /// True if the unit deviates significantly from its population.
    pub is_odd: bool,
    /// Length of the log, s.
    pub seconds: Option<f64>,
    /// Lowest and highest temperature in the log, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Reasons why the log or an axis has no results.
    pub failed: Vec<String>,
    /// Axes that have a population.
    pub axes: Vec<UnitAxis>,
}

/// An axis of a unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct UnitAxis {
    /// Name for people, such as `gyro x`.
    pub label: String,
    /// Coefficients of the population of the axis.
    pub coefficients: Vec<UnitCoefficient>,
    /// Effects that the diagnosis found.
    pub effects: Vec<String>,
}

/// Coefficient of a unit: values in `unit`, each with half of its 90 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct UnitCoefficient {
    /// Name: `bias`, or the regressor.
    pub name: String,
    /// Unit of the values, such as `(°/s)/K`.
    pub unit: String,
    /// Estimate from the unit's own log; none where the log does not determine it.
    pub own: Option<[f64; 2]>,
    /// Middle and half of the 90 % interval of the units of its lot.
    pub expected: [f64; 2],
    /// Own estimate combined with the population, as shipped; for an odd unit its own estimate alone.
    pub together: [f64; 2],
    /// Deviation of the own estimate from the expected value, in standard deviations.
    pub by: Option<f64>,
}

impl UnitReport {
    /// Builds the report on the unit of `row`, which is one of `part`.
    pub fn of(row: &UnitRow, part: &PartSummary) -> Self {
        let log = row.log.as_ref();
        let is_odd = part.odd.iter().any(|odd| odd.unit == row.unit);
        Self {
            unit: row.unit.clone(),
            part: row.part.clone(),
            lot: row.lot.clone(),
            is_odd,
            seconds: log.map(|log| log.seconds),
            temperature_c: log.and_then(|log| log.temperature_c),
            failed: row.failed.clone(),
            axes: part.axes.iter().filter_map(|axis| UnitAxis::of(row, axis, is_odd)).collect(),
        }
    }
}

fn middle_and_half([low, high]: [f64; 2]) -> [f64; 2] {
    [0.5 * (low + high), 0.5 * (high - low)]
}

impl UnitAxis {
    fn of(row: &UnitRow, axis: &AxisSummary, is_odd: bool) -> Option<Self> {
        let population = axis.population.as_ref()?;
        let own = row.axis(&axis.column)?;
        let estimate = &own.estimate.coefficients;
        let lot = row.lot.as_deref();
        let ((mean, prior), together) =
            (population.prior(lot), known_of(row, &axis.column, population, is_odd));
        let coefficient = |(place, name): (usize, &String)| {
            let (unit, si) = unit_of(&axis.column, name);
            let with_half = |value: f64, variance: f64| [value / si, NINETY * variance.max(0.0).sqrt() / si];
            let estimated =
                estimate.place(name).map(|own| (estimate.values[own], estimate.covariance[own][own]));
            UnitCoefficient {
                name: name.clone(),
                unit,
                own: estimated.map(|(value, variance)| with_half(value, variance)),
                expected: middle_and_half(population.unit_interval(lot, place).map(|end| end / si)),
                together: with_half(together.values[place], together.covariance[place][place]),
                by: estimated
                    .map(|(value, variance)| (value - mean[place]) / (variance + prior[place][place]).sqrt())
                    .filter(|by| by.is_finite()),
            }
        };
        let effects = own.diagnosis.iter().flat_map(|diagnosis| &diagnosis.effects);
        Some(Self {
            label: Column::named(&axis.column).label().to_owned(),
            coefficients: population.names.iter().enumerate().map(coefficient).collect(),
            effects: effects.map(|found| found.effect.clone()).collect(),
        })
    }
}
