//! Units for people: °/s or °/h for a gyro, mg for an accelerometer. The command line and the page share this rule.

use serde::{Deserialize, Serialize};

use fos_data::column::Column;
use fos_data::text::rounded;
use fos_diagnose::effects::SizeUnit;
use fos_fit::evaluate::ModelErrors;

/// Largest error of a gyro that is shown in °/h, °/s.
const IN_DEGREES_PER_HOUR: f64 = 0.1;

/// The units of printed text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    /// °/s, °/h and mg
    #[default]
    Field,
    /// rad/s and m/s²
    Si,
}

/// Unit in which the errors of one axis are shown.
#[derive(Debug, Clone, Copy)]
pub struct ErrorUnit {
    /// Label for people; empty if the column does not state a unit.
    pub label: &'static str,
    /// Size of this unit in SI.
    pub si: f64,
}

impl ErrorUnit {
    /// Unit for errors of up to `largest`, in SI, that gives readable numbers.
    pub fn of(column: &str, largest: f64, units: Units) -> Self {
        let column = Column::named(column);
        let size = SizeUnit::of_axis(column).si;
        let (label, si) = match units {
            Units::Field if column.is_angular_rate() && largest < IN_DEGREES_PER_HOUR * size => {
                ("°/h", size / 3600.0)
            }
            Units::Field if column.is_angular_rate() => ("°/s", size),
            Units::Field if column.is_specific_force() => ("mg", size),
            _ => (column.unit().label(), 1.0),
        };
        Self { label, si }
    }

    /// Unit in which the errors of these models are shown.
    pub fn of_models<'a>(
        column: &str,
        models: impl IntoIterator<Item = &'a ModelErrors>,
        units: Units,
    ) -> Self {
        let slow = models.into_iter().filter_map(|model| model.slow_error_coast);
        Self::of(column, slow.fold(0.0, f64::max).sqrt(), units)
    }

    /// A value in SI, without the unit.
    pub fn show(self, value: f64) -> String {
        three(value / self.si)
    }

    /// Root of a variance in SI, without the unit; a dash for none.
    pub fn root(self, variance: Option<f64>) -> String {
        variance.map_or_else(|| "–".to_owned(), |variance| self.show(variance.max(0.0).sqrt()))
    }
}

/// A unit with its label for people; a stored value is divided by `divisor`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ShownUnit {
    pub label: String,
    pub divisor: f64,
}

impl ShownUnit {
    fn new(label: impl Into<String>, divisor: f64) -> Self {
        Self { label: label.into(), divisor }
    }

    /// Unit of a coefficient stored in `unit`, as `dps/K`.
    pub fn of_size(unit: &str, units: Units) -> Self {
        match (units, unit.parse::<SizeUnit>()) {
            (Units::Si, Ok(unit)) => Self::new(unit.in_si(), 1.0 / unit.si),
            (Units::Field, Ok(unit)) => Self::new(unit.spelled(), 1.0),
            (_, Err(_)) => Self::new(unit, 1.0),
        }
    }

    /// The unit of heading or position errors of an axis.
    pub fn of_unaided(column: &str, units: Units) -> Self {
        match (Column::named(column).is_angular_rate(), units) {
            (true, Units::Field) => Self::new("°", std::f64::consts::PI / 180.0),
            (true, Units::Si) => Self::new("rad", 1.0),
            (false, _) => Self::new("m", 1.0),
        }
    }

    /// Units of N, B and K of an axis.
    pub fn of_noise(column: &str, units: Units) -> [Self; 3] {
        let column = Column::named(column);
        let size = SizeUnit::of_axis(column).si;
        let si = column.unit().label();
        match units {
            Units::Field if column.is_angular_rate() => [
                Self::new("°/√h", size / 60.0),
                Self::new("°/h", size / 3600.0),
                Self::new("(°/h)/√h", size / 3600.0 / 60.0),
            ],
            Units::Field if column.is_specific_force() => [
                Self::new("µg/√Hz", 1e-3 * size),
                Self::new("µg", 1e-3 * size),
                Self::new("µg/√h", 1e-3 * size / 60.0),
            ],
            _ => {
                let walk = match si {
                    "rad/s" => "(rad/s²)/√Hz".to_owned(),
                    "m/s²" => "(m/s³)/√Hz".to_owned(),
                    other => format!("({other})/√s"),
                };
                [Self::new(format!("({si})/√Hz"), 1.0), Self::new(si, 1.0), Self::new(walk, 1.0)]
            }
        }
    }
}

impl From<ErrorUnit> for ShownUnit {
    fn from(unit: ErrorUnit) -> Self {
        Self::new(unit.label, unit.si)
    }
}

/// Three significant digits, in plain notation from 0.00001 on.
pub fn three(value: f64) -> String {
    match value.abs() {
        small if (1e-5..1e-3).contains(&small) => {
            let decimals = (2 - small.log10().floor() as i32) as usize;
            format!("{value:.decimals$}")
        }
        _ => rounded(value, 3),
    }
}

/// [`three`] digits of a value among values of the size `scale`: one too small to matter beside them is 0, so that one
/// notation is enough for all.
pub fn three_beside(value: f64, scale: f64) -> String {
    if value.abs() < 0.01 * scale { "0".to_owned() } else { three(value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_far_below_its_own_uncertainty_is_zero() {
        assert_eq!(three_beside(-1.52e-7, 1e-4), "0");
        assert_eq!(three_beside(-1.52e-5, 1e-4), "-0.0000152");
    }

    #[test]
    fn noise_of_a_data_sheet_keeps_its_size() {
        // 0.15 °/√h is 0.0025 (°/s)/√Hz; 100 µg/√Hz is 9.81e-4 (m/s²)/√Hz.
        let [white, flicker, walk] = ShownUnit::of_noise("gx_rads", Units::Field);
        assert!((0.0025_f64.to_radians() / white.divisor - 0.15).abs() < 1e-12);
        assert!((10.0_f64.to_radians() / 3600.0 / flicker.divisor - 10.0).abs() < 1e-12);
        // √h is 60 √s.
        assert!((1.0_f64.to_radians() / 3600.0 / walk.divisor - 60.0).abs() < 1e-12);
        let [white, ..] = ShownUnit::of_noise("ax_mps2", Units::Field);
        assert!((9.80665e-4 / white.divisor - 100.0).abs() < 1e-9);
    }
}
