//! Data-sheet units of coefficients: mg/K, dps/g, µg/V, ppm/dps², ….

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use fos_data::column::Column;

/// Unit of a coefficient and its size in SI (m/s² or rad/s per unit of the logged quantity).
#[derive(Debug, Clone, PartialEq)]
pub struct SizeUnit {
    text: String,
    /// Size of one of this unit in SI.
    pub si: f64,
}

/// Standard gravity, m/s².
const G: f64 = 9.80665;

/// Size of a unit in SI; logged quantities keep the unit of their column (°C, V, %, µT).
fn si(unit: &str) -> Option<f64> {
    Some(match unit {
        "dps" => PI / 180.0,
        "mdps" => PI / 180e3,
        "dph" => PI / 180.0 / 3600.0,
        "rad/s" | "m/s²" | "K" | "V" | "pct" | "µT" | "s" | "m" | "1" => 1.0,
        "g" => G,
        "mg" => G * 1e-3,
        "µg" => G * 1e-6,
        "%" | "cm" => 1e-2,
        "ppm" => 1e-6,
        "mV" => 1e-3,
        "h" => 3600.0,
        _ => return None,
    })
}

impl SizeUnit {
    /// Returns the unit of sizes on an axis: °/s for a gyro, mg for an accelerometer.
    pub fn of_axis(column: Column<'_>) -> Self {
        let (text, si) = if column.is_angular_rate() { ("dps", PI / 180.0) } else { ("mg", G * 1e-3) };
        Self { text: text.to_owned(), si }
    }

    /// Returns the unit in readable form: `(°/s)/K` for `dps/K`.
    pub fn spelled(&self) -> String {
        self.with_names(|name| match name {
            "dps" => "°/s",
            "mdps" => "m°/s",
            "dph" => "°/h",
            "pct" => "%",
            other => other,
        })
    }

    /// Returns the SI unit of a value multiplied by [`si`](Self::si): `(rad/s)/K` for `dps/K`.
    pub fn in_si(&self) -> String {
        self.with_names(|name| match name {
            "dps" | "mdps" | "dph" => "rad/s",
            "g" | "mg" | "µg" => "m/s²",
            "%" | "ppm" => "1",
            "pct" => "%",
            "cm" => "m",
            "mV" => "V",
            "h" => "s",
            other => other,
        })
    }

    /// Replaces the names of the parts; a part that is itself a ratio is put in brackets.
    fn with_names<'a>(&'a self, name: impl Fn(&'a str) -> &'a str) -> String {
        let is_sign = |letter: char| matches!(letter, '/' | '(' | ')' | '²' | '³');
        let mut text = String::new();
        for part in self.text.split_inclusive(is_sign) {
            let old = part.trim_end_matches(is_sign);
            let new = if old.is_empty() { "" } else { name(old) };
            let is_alone = old.len() == self.text.len();
            text += &if new.contains('/') && !is_alone { format!("({new})") } else { new.to_owned() };
            text += &part[old.len()..];
        }
        text
    }
}

impl FromStr for SizeUnit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "unit {text:?}: write NUMERATOR or NUMERATOR/DENOMINATOR out of dps, mdps, dph, g, mg, µg, %, ppm, cm, m, K, V, mV, pct, µT, s, h, with ² or ³, as mg/K²"
            )
        };
        let plain: String = text.chars().filter(|c| !matches!(c, '(' | ')')).collect();
        let mut total = 1.0;
        for (place, part) in plain.split('/').enumerate() {
            let (name, power) = match part.strip_suffix('²') {
                Some(name) => (name, 2),
                None => part.strip_suffix('³').map_or((part, 1), |name| (name, 3)),
            };
            let one = si(name).ok_or_else(unknown)?.powi(power);
            // in a/(b/c) the last part is back in the numerator
            let is_below = place == 1 || (place == 2 && !text.contains('('));
            total *= if is_below { 1.0 / one } else { one };
        }
        Ok(Self { text: text.to_owned(), si: total })
    }
}

impl fmt::Display for SizeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_as_on_data_sheets() {
        for (text, si) in [
            ("mg/K", 9.80665e-3),
            ("dps/g", PI / 180.0 / 9.80665),
            ("µg/g²", 1e-6 / 9.80665),
            ("%", 0.01),
            ("dps/(K/s)", PI / 180.0),
            ("mg/mV", 9.80665),
            ("dph/h", PI / 180.0 / 3600.0 / 3600.0),
            ("ppm/dps²", 1e-6 / (PI / 180.0).powi(2)),
        ] {
            let unit: SizeUnit = text.parse().unwrap();
            assert!((unit.si / si - 1.0).abs() < 1e-12, "{text}: {}", unit.si);
            assert_eq!(unit.to_string(), text);
        }
        for (text, spelled, si) in [
            ("dps", "°/s", "rad/s"),
            ("dps/K", "(°/s)/K", "(rad/s)/K"),
            ("dps/(K/s)", "(°/s)/(K/s)", "(rad/s)/(K/s)"),
            ("ppm/dps²", "ppm/(°/s)²", "1/(rad/s)²"),
            ("mg/K²", "mg/K²", "(m/s²)/K²"),
            ("dph/h", "(°/h)/h", "(rad/s)/s"),
        ] {
            let unit: SizeUnit = text.parse().unwrap();
            assert_eq!([unit.spelled(), unit.in_si()], [spelled, si], "{text}");
        }
        assert!("dps/furlong".parse::<SizeUnit>().is_err());
    }
}
