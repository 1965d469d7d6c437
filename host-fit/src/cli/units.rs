//! Numbers and units for people, and the options of the printed text.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use fos_figures::units::ShownUnit;
pub(super) use fos_figures::units::{ErrorUnit, Units, three};

/// Option for the units of a printed text of fixed extent.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(super) struct UnitsOption {
    /// Units of the printed text; JSON and files are always in SI
    #[arg(long, value_parser = unit_systems(), default_value = "field")]
    pub(super) units: Units,
}

fn unit_systems() -> impl TypedValueParser<Value = Units> {
    let field = PossibleValue::new("field").help("°/s, °/h and mg");
    let si = PossibleValue::new("si").help("rad/s and m/s²");
    PossibleValuesParser::new([field, si]).map(|name| if name == "si" { Units::Si } else { Units::Field })
}

/// Extent and units of the printed text.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(super) struct Printed {
    /// Print everything: all terms, errors, stretches and tests
    #[arg(long)]
    pub(super) details: bool,
    /// Units of the printed text; JSON and files are always in SI
    #[arg(long, value_parser = unit_systems(), default_value = "field")]
    pub(super) units: Units,
}

impl Printed {
    /// The number of lines of one kind: all of them with `--details`.
    pub(super) fn at_most(self, lines: usize) -> usize {
        if self.details { usize::MAX } else { lines }
    }

    /// A coefficient in the unit of a data sheet, as `0.0205 (°/s)/K`.
    pub(super) fn coefficient(self, value: f64, unit: &str) -> (String, String) {
        let shown = ShownUnit::of_size(unit, self.units);
        (three(value / shown.divisor), shown.label)
    }
}

/// A share in per cent, as `78.5 %`.
pub(super) fn percent(share: f64) -> String {
    // A small negative share is 0.0, not -0.0.
    format!("{:.1} %", (1000.0 * share).round() / 10.0 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_shown_in_readable_units() {
        let degree = std::f64::consts::PI / 180.0;
        for (column, value, units, shown) in [
            ("gx_rads", 0.1006 * degree, Units::Field, "0.101 °/s"),
            ("gx_rads", 0.00679 * degree, Units::Field, "24.4 °/h"),
            ("gx_rads", 0.001781, Units::Si, "0.00178 rad/s"),
            ("az_mps2", 0.006938, Units::Field, "0.707 mg"),
            ("az_mps2", 0.0, Units::Si, "0 m/s²"),
            ("temp_c", 0.25, Units::Field, "0.250 °C"),
        ] {
            let unit = ErrorUnit::of(column, value, units);
            assert_eq!(format!("{} {}", unit.show(value), unit.label), shown);
        }
    }

    #[test]
    fn coefficients_keep_their_size_in_both_units() {
        let (field, si) = (Printed::default(), Printed { units: Units::Si, ..Printed::default() });
        let shown = |printed: Printed, value, unit| {
            let (value, unit) = printed.coefficient(value, unit);
            format!("{value} {unit}")
        };
        assert_eq!(shown(field, 0.02045, "dps/K"), "0.0204 (°/s)/K");
        assert_eq!(shown(si, 0.02045, "dps/K"), "0.000357 (rad/s)/K");
        assert_eq!(shown(field, 1.5, "mg/K"), "1.50 mg/K");
        assert_eq!(shown(si, 1.5, "mg/K"), "0.0147 (m/s²)/K");
    }

    #[test]
    fn count_of_one_is_singular() {
        let counted = |count| fos_data::text::counted(count, "rest");
        assert_eq!([0, 1, 2].map(counted), ["0 rests", "1 rest", "2 rests"]);
    }
}
