//! A unit beside its population: what its log says of each coefficient, what its lot lets expect, and both together.

use serde::Serialize;

use super::coefficient::{NINETY, unit_of};
use fos_data::column::Column;
use fos_fleet::{AxisSummary, PartSummary, UnitRow, known_of};

/// A unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct UnitReport {
    /// Its name.
    pub unit: String,
    /// Its part.
    pub part: String,
    /// Its lot.
    pub lot: Option<String>,
    /// It does not belong.
    pub is_odd: bool,
    /// Length of its log, s.
    pub seconds: Option<f64>,
    /// Lowest and highest temperature of its log, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Why it, or an axis of it, tells nothing.
    pub failed: Vec<String>,
    /// The axes of its part.
    pub axes: Vec<UnitAxis>,
}

/// An axis of a unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct UnitAxis {
    /// As in `gyro x`.
    pub label: String,
    /// The coefficients of its population.
    pub coefficients: Vec<UnitCoefficient>,
    /// The effects that a diagnosis found.
    pub effects: Vec<String>,
}

/// A coefficient of a unit: values in `unit`, each with half of its 90 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct UnitCoefficient {
    /// `bias`, or the regressor.
    pub name: String,
    /// As in `dps/K`.
    pub unit: String,
    /// What its log says; none where it does not tell.
    pub own: Option<[f64; 2]>,
    /// What its lot lets expect: nine of ten units lie there.
    pub expected: [f64; 2],
    /// Both together, as it ships; of a unit that does not belong its own log alone.
    pub together: [f64; 2],
    /// By how many standard deviations its log is off what is expected.
    pub by: Option<f64>,
}

impl UnitReport {
    /// Of the unit behind `row`, one of the part.
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
            let told = estimate.place(name).map(|own| (estimate.values[own], estimate.covariance[own][own]));
            UnitCoefficient {
                name: name.clone(),
                unit,
                own: told.map(|(value, variance)| with_half(value, variance)),
                expected: middle_and_half(population.unit_interval(lot, place).map(|end| end / si)),
                together: with_half(together.values[place], together.covariance[place][place]),
                by: told
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
