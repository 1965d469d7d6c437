//! Report on a population, as plain data; [`html`] only renders it.

mod coefficient;
mod odd;
mod read;
mod render;
mod shipped;
mod unit;

use std::path::Path;

use serde::Serialize;

pub use coefficient::unit_in_words;
pub use coefficient::{CoefficientReport, LeftBy};
pub use odd::OddReport;
pub use read::{NotRead, UnitsRead};
pub use render::html;
pub use shipped::EffectReport;
pub use unit::{UnitAxis, UnitCoefficient, UnitReport};

use fos_data::column::Column;
use fos_diagnose::study::Tool;
use fos_figures::Figure;
use fos_figures::population::{OfVariance, of_variance};
use fos_fleet::{AxisSummary, BIAS, Fleet, PartSummary, UnitRow};

/// Share of units above which failed or odd ones are no longer exceptions.
const MANY: f64 = 0.1;

/// Report on a population.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct FleetReport {
    /// Program that wrote the report.
    pub tool: Tool,
    /// Path of the population.
    pub path: String,
    /// Regressors that the error may depend on, as requested.
    pub regressors: Vec<String>,
    /// True if units were diagnosed as well.
    pub diagnosed: bool,
    /// Reports on the parts, sorted by name.
    pub parts: Vec<PartReport>,
}

/// Report on one part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct PartReport {
    /// Name of the part; empty if the fleet has none.
    pub part: String,
    /// Units that were read, and those that were not.
    pub read: UnitsRead,
    /// Duplicate logs and reasons not to trust the numbers, a sentence each.
    pub cautions: Vec<String>,
    /// Figure of the sources of the differences between units; none where no axis has a population.
    pub variance: Option<Figure>,
    /// Axes of the part.
    pub axes: Vec<AxisReport>,
    /// Units that deviate significantly from the population, the furthest first.
    pub odd: Vec<OddReport>,
    /// Reason why the search for odd units is not conclusive; none if it is conclusive.
    pub not_conclusive: Option<String>,
}

/// An axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AxisReport {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// Name for people, such as `gyro x`.
    pub label: String,
    /// Reason why there is no population.
    pub without: Option<String>,
    /// Coefficients of the population.
    pub coefficients: Vec<CoefficientReport>,
    /// Effects that the diagnoses of units found.
    pub effects: Vec<EffectReport>,
}

impl FleetReport {
    /// Builds the report on a fleet that was read from `path`, and its rows.
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

/// Draws a panel for each coefficient, with all axes that have it.
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
    (!coefficients.is_empty()).then(|| of_variance("Sources of variation", &coefficients))
}

/// Returns the reasons not to trust the numbers of a part, a sentence each.
fn cautions(read: &UnitsRead, axes: &[AxisReport], odd: usize) -> Vec<String> {
    let mut found = Vec::new();
    let share = |units: usize| units as f64 / read.units.max(1) as f64;
    let silent = read.partly + read.nothing;
    if share(silent) > MANY {
        found.push(format!(
            "{silent} of {} devices {} incomplete data: if they differ from the others, these results do not describe the part.",
            read.units,
            if silent == 1 { "has" } else { "have" }
        ));
    }
    if share(odd) > MANY {
        found.push(format!(
            "{odd} of {} devices {} odd. That share suggests two populations; check lots and parts.",
            read.units,
            if odd == 1 { "is" } else { "are" }
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
