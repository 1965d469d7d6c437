//! What a population says, as plain data; [`html`] only renders it.

mod coefficient;
mod odd;
mod read;
mod render;
mod shipped;
mod unit;

use std::path::Path;

use serde::Serialize;

pub use coefficient::{CoefficientReport, LeftBy};
pub use odd::OddReport;
pub use read::{NotRead, UnitsRead};
pub use render::html;
pub use shipped::EffectReport;
pub use unit::{UnitAxis, UnitCoefficient, UnitReport};

use crate::figures::Figure;
use crate::figures::population::{OfVariance, of_variance};
use fos_data::column::Column;
use fos_diagnose::study::Tool;
use fos_fleet::{AxisSummary, BIAS, Fleet, PartSummary, UnitRow};

/// Of units: so large a share that fails, or is odd, is no exception.
const MANY: f64 = 0.1;

/// What a population says.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct FleetReport {
    /// The program that wrote it.
    pub tool: Tool,
    /// Where the population was read.
    pub path: String,
    /// What the error may depend on, as it was asked.
    pub regressors: Vec<String>,
    /// Units were diagnosed too.
    pub diagnosed: bool,
    /// Each part.
    pub parts: Vec<PartReport>,
}

/// A part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PartReport {
    /// Its name; empty if the fleet names none.
    pub part: String,
    /// What was read, and what was not.
    pub read: UnitsRead,
    /// When its numbers are not to be trusted, a sentence each.
    pub cautions: Vec<String>,
    /// Of what the differences of units are made; none where no axis has a population.
    pub variance: Option<Figure>,
    /// Its axes.
    pub axes: Vec<AxisReport>,
    /// Units that do not belong, the furthest first.
    pub odd: Vec<OddReport>,
    /// Why that there is no other odd unit is not conclusive; none where it is.
    pub not_conclusive: Option<String>,
}

/// An axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AxisReport {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// As in `gyro x`.
    pub label: String,
    /// Why there is no population.
    pub without: Option<String>,
    /// Its coefficients.
    pub coefficients: Vec<CoefficientReport>,
    /// The effects that units were found to have.
    pub effects: Vec<EffectReport>,
}

impl FleetReport {
    /// Of a fleet that was read from `path`, and its rows.
    pub fn of(fleet: &Fleet, rows: &[UnitRow], path: &Path) -> Self {
        let mut parts: Vec<PartReport> = fleet
            .parts
            .iter()
            .map(|part| {
                let duplicates = fleet.duplicates.iter().filter(|duplicate| duplicate.part == part.part);
                let rows = rows.iter().filter(|row| row.part == part.part);
                PartReport::of(part, rows.collect(), duplicates.map(ToString::to_string).collect())
            })
            .collect();
        parts.sort_by(|a, b| a.part.cmp(&b.part));
        Self {
            tool: Tool::this(),
            path: path.display().to_string(),
            regressors: fleet.asked.regressors.clone(),
            diagnosed: fleet.asked.diagnosed,
            parts,
        }
    }
}

impl PartReport {
    fn of(part: &PartSummary, rows: Vec<&UnitRow>, duplicates: Vec<String>) -> Self {
        let axes: Vec<AxisReport> = part.axes.iter().map(|axis| AxisReport::of(axis, &rows, part)).collect();
        let read = UnitsRead::of(&rows);
        Self {
            part: part.part.clone(),
            cautions: duplicates.into_iter().chain(cautions(&read, &axes, part.odd.len())).collect(),
            not_conclusive: part.not_conclusive(),
            variance: variance(&axes),
            odd: part.odd.iter().map(|odd| OddReport::of(odd, part, &rows)).collect(),
            axes,
            read,
        }
    }
}

impl AxisReport {
    fn of(axis: &AxisSummary, rows: &[&UnitRow], part: &PartSummary) -> Self {
        let coefficients = axis.population.iter().flat_map(|population| {
            (0..population.names.len())
                .map(|place| CoefficientReport::of(&axis.column, population, place, rows, part))
        });
        Self {
            column: axis.column.clone(),
            label: Column::named(&axis.column).label().to_owned(),
            without: axis.without.clone(),
            coefficients: coefficients.collect(),
            effects: axis.effects.iter().map(EffectReport::of).collect(),
        }
    }
}

/// A panel for each coefficient, with all axes that have it.
fn variance(axes: &[AxisReport]) -> Option<Figure> {
    let mut coefficients: Vec<(String, Vec<OfVariance>)> = Vec::new();
    for axis in axes {
        for coefficient in &axis.coefficients {
            let of_axis = OfVariance { name: axis.label.clone(), shares: coefficient.shares };
            match coefficients.iter_mut().find(|(name, _)| *name == coefficient.name) {
                Some((_, axes)) => axes.push(of_axis),
                None => coefficients.push((coefficient.name.clone(), vec![of_axis])),
            }
        }
    }
    coefficients.sort_by_key(|(name, _)| name != BIAS);
    (!coefficients.is_empty())
        .then(|| of_variance("Of what the differences of devices are made", &coefficients))
}

/// When the numbers of a part are not to be trusted.
fn cautions(read: &UnitsRead, axes: &[AxisReport], odd: usize) -> Vec<String> {
    let mut found = Vec::new();
    let share = |units: usize| units as f64 / read.units.max(1) as f64;
    let silent = read.partly + read.nothing;
    if share(silent) > MANY {
        found.push(format!(
            "{silent} of {} devices have incomplete data: if they differ from the others, these results do not describe the part.",
            read.units
        ));
    }
    if share(odd) > MANY {
        found.push(format!(
            "{odd} of {} devices are odd: so many are no exceptions, but a second population that one mean and one scatter do not describe.",
            read.units
        ));
    }
    let without: Vec<&str> =
        axes.iter().filter(|axis| axis.coefficients.is_empty()).map(|axis| axis.label.as_str()).collect();
    if !without.is_empty() {
        found.push(format!(
            "No population of {}: too few devices determine a coefficient.",
            without.join(", ")
        ));
    }
    found
}
