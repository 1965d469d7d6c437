//! A coefficient of an axis over the units of a part, in data-sheet units.

use serde::Serialize;

use fos_data::column::Column;
use fos_diagnose::effects::SizeUnit;
use fos_figures::Figure;
use fos_figures::population::{LotMean, OfCoefficient, UnitDot, of_coefficient};
use fos_figures::units::three;
use fos_fleet::{BIAS, PartSummary, Population, REFERENCE_C, UnitRow};

/// Ratio of the bounds of a standard deviation's interval above which a caution is given.
const WIDE: f64 = 2.0;

/// Column of the temperature.
const TEMPERATURE: &str = "temp_c";

/// Number of lots below which the scatter between them is given with a caution.
const FEW_LOTS: usize = 6;

/// Half of a 90 % interval of a normal distribution, in standard deviations.
pub(super) const NINETY: f64 = 1.645;

/// Coefficient over the units of a part; every number is in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct CoefficientReport {
    /// Name: `bias`, or the regressor.
    pub name: String,
    /// Unit of all numbers, such as `(°/s)/K`.
    pub unit: String,
    /// Number of units in the population.
    pub units: usize,
    /// Number of named lots.
    pub lots: usize,
    /// Mean of the part.
    pub mean: f64,
    /// 90 % interval of `mean`.
    pub mean_interval: [f64; 2],
    /// Standard deviation between units of a lot.
    pub between_units: f64,
    /// 90 % interval of `between_units`.
    pub between_units_interval: [f64; 2],
    /// Standard deviation between lots; none with fewer than two lots.
    pub between_lots: Option<f64>,
    /// 90 % interval of `between_lots`.
    pub between_lots_interval: [f64; 2],
    /// p-value of the observed difference between lots if lots do not differ; none with fewer than two lots.
    pub lots_alike: Option<f64>,
    /// Standard deviation of an estimate about the value of its unit: the error of a log.
    pub error_of_log: f64,
    /// Shares of the variance of estimates: lots, units, error of a log.
    pub shares: [f64; 3],
    /// Remaining error for each way of calibrating.
    pub left: LeftBy,
    /// Reasons not to trust the numbers, a sentence each.
    pub cautions: Vec<String>,
    /// Figure of the units about the population, and lot by lot.
    pub figure: Figure,
}

/// Standard deviation of the remaining error of a unit's coefficient, by the value in its model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LeftBy {
    /// The mean of the part.
    pub part_mean: f64,
    /// Mean of the unit's lot, for known lots; none with fewer than two lots.
    pub lot_mean: Option<f64>,
    /// Estimate from one log like these.
    pub own_log: f64,
    /// Estimate from one log combined with the population, for a unit of an unknown lot.
    pub with_population: f64,
}

/// Returns the unit of a coefficient, and its size in SI.
pub(super) fn unit_of(column: &str, name: &str) -> (String, f64) {
    let unit = SizeUnit::of_axis(Column::named(column));
    (unit_in_words(&unit.spelled(), name), unit.si)
}

/// Returns the unit of a coefficient of an axis whose unit is `axis`: `(°/s)/K` of a coefficient of `temp_c`.
pub fn unit_in_words(axis: &str, name: &str) -> String {
    let kelvins = || name.split(" * ").map(str::trim);
    let is_temperature = |factor: &str| factor == TEMPERATURE || factor.starts_with("temp_c:lowpass(");
    let bracketed = if axis.contains('/') { format!("({axis})") } else { axis.to_owned() };
    match kelvins().count() {
        _ if name == BIAS => axis.to_owned(),
        power @ 1..=3 if kelvins().all(is_temperature) => {
            format!("{bracketed}/K{}", ["", "²", "³"][power - 1])
        }
        _ => format!("{bracketed} per unit of {name}"),
    }
}

impl CoefficientReport {
    pub(super) fn of(
        column: &str,
        population: &Population,
        place: usize,
        rows: &[&UnitRow],
        part: &PartSummary,
    ) -> Self {
        let name = &population.names[place];
        let (unit, si) = unit_of(column, name);
        let scatter = &population.scatter[place];
        let in_unit = |value: f64| value / si;
        let mean = in_unit(population.mean[place]);
        let mean_interval = population.mean_interval(place).map(in_unit);
        let (units, lots, error) =
            (in_unit(scatter.units), in_unit(scatter.lots), in_unit(scatter.measurement));
        let variances = [lots, units, error].map(|deviation| deviation * deviation);
        let whole: f64 = variances.iter().sum();

        let mut named: Vec<_> = population.lots.iter().filter(|lot| !lot.name.is_empty()).collect();
        named.sort_by_cached_key(|lot| in_order(&lot.name));
        let has_lots = scatter.lots_alike.is_some();
        let lot_means = named.iter().map(|lot| {
            let mean = in_unit(lot.mean[place]);
            LotMean { name: lot.name.clone(), mean, interval: lot.mean_interval(place).map(in_unit) }
        });
        let lot_means: Vec<LotMean> = if has_lots { lot_means.collect() } else { Vec::new() };

        let mut rows: Vec<&&UnitRow> = rows.iter().collect();
        rows.sort_by_cached_key(|row| (row.lot.as_deref().map(in_order), in_order(&row.unit)));
        let estimates: Vec<_> = rows
            .iter()
            .filter_map(|row| {
                let axis = row.axes.iter().find(|axis| axis.estimate.column == column)?;
                Some((row, &axis.estimate.coefficients))
            })
            .collect();
        let units_drawn = estimates.iter().filter_map(|(row, estimate)| {
            Some(UnitDot {
                value: in_unit(estimate.values[estimate.place(name)?]),
                lot: row.lot.as_ref().and_then(|lot| lot_means.iter().position(|mean| mean.name == *lot)),
                is_odd: part.odd.iter().any(|odd| odd.unit == row.unit && odd.column == column),
            })
        });
        let units_drawn: Vec<UnitDot> = units_drawn.collect();

        let root_mean = |variances: &mut dyn Iterator<Item = f64>| {
            let variances: Vec<f64> = variances.collect();
            in_unit((variances.iter().sum::<f64>() / variances.len().max(1) as f64).max(0.0).sqrt())
        };
        let own = population.between_units[place][place];
        let left = LeftBy {
            part_mean: in_unit(population.prior(None).1[place][place].max(0.0).sqrt()),
            lot_mean: has_lots
                .then(|| root_mean(&mut named.iter().map(|lot| own + lot.covariance[place][place]))),
            own_log: error,
            with_population: root_mean(
                &mut estimates
                    .iter()
                    .filter(|(_, estimate)| estimate.place(name).is_some())
                    .map(|(_, estimate)| population.shrunk(estimate, None).covariance[place][place]),
            ),
        };
        let quantity = match name.as_str() {
            BIAS => format!("Bias at {REFERENCE_C} °C ({unit})"),
            _ => format!("Coefficient of {name} ({unit})"),
        };
        let mut report = Self {
            name: name.clone(),
            units: population.units,
            lots: named.len(),
            mean,
            mean_interval,
            between_units: units,
            between_units_interval: scatter.units_interval.map(in_unit),
            between_lots: has_lots.then_some(lots),
            between_lots_interval: scatter.lots_interval.map(in_unit),
            lots_alike: scatter.lots_alike,
            error_of_log: error,
            shares: variances.map(|variance| if whole > 0.0 { variance / whole } else { 0.0 }),
            left,
            cautions: Vec::new(),
            figure: of_coefficient(&OfCoefficient {
                title: format!("{}: {name}", Column::named(column).label()),
                quantity,
                units: units_drawn,
                lots: lot_means,
                mean,
                scatter: units.hypot(lots),
                error,
            }),
            unit,
        };
        report.cautions = report.doubts();
        report
    }

    /// Returns the reasons not to trust the numbers, a sentence each.
    fn doubts(&self) -> Vec<String> {
        let mut found = Vec::new();
        let [low, high] = self.between_units_interval;
        let unit = &self.unit;
        if low <= 0.0 {
            found.push(format!(
                "The scatter between devices is indistinguishable from the error of the logs, {} {unit}: it may be zero, and is at most {} {unit}. Longer logs separate the two.",
                three(self.error_of_log),
                three(high)
            ));
        } else if high > WIDE * low {
            found.push(format!(
                "The scatter between devices is only known to lie between {} and {} {unit}. More devices or longer logs narrow this interval.",
                three(low),
                three(high)
            ));
        }
        if low > 0.0 && self.error_of_log > self.between_units {
            found.push("The error of one log exceeds the scatter of devices, so the mean of the part is more accurate than a device's own estimate.".to_owned());
        }
        if self.between_lots.is_some() && self.lots < FEW_LOTS {
            found.push(format!(
                "The scatter between lots rests on {} lots: it may be anything up to {} {unit}.",
                self.lots,
                three(self.between_lots_interval[1])
            ));
        }
        found
    }
}

/// Sort key in natural order: numbers in a name by their value, `W9` before `W10`.
fn in_order(name: &str) -> Vec<(String, u64)> {
    let mut pieces = vec![(String::new(), 0_u64)];
    let mut was_digit = false;
    for letter in name.chars() {
        let digit = letter.to_digit(10);
        if was_digit && digit.is_none() {
            pieces.push((String::new(), 0));
        }
        if let Some((text, number)) = pieces.last_mut() {
            match digit {
                Some(digit) => *number = number.saturating_mul(10).saturating_add(u64::from(digit)),
                None => text.push(letter),
            }
        }
        was_digit = digit.is_some();
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    fn coefficients_have_the_units_of_data_sheets() {
        for (axis, name, unit) in [
            ("°/s", "bias", "°/s"),
            ("°/s", "temp_c", "(°/s)/K"),
            ("mg", "temp_c * temp_c", "mg/K²"),
            ("mg", "temp_c:lowpass(60)", "mg/K"),
            ("°/s", "supply_v", "(°/s) per unit of supply_v"),
        ] {
            assert_eq!(super::unit_in_words(axis, name), unit);
        }
    }

    #[test]
    fn numbers_in_names_go_by_their_size() {
        let mut names = ["2026-W10", "2026-W9", "2025-W51", "w", "", "99999999999999999999999"];
        names.sort_by_key(|name| in_order(name));
        assert_eq!(names, ["", "2025-W51", "2026-W9", "2026-W10", "99999999999999999999999", "w"]);
    }
}
