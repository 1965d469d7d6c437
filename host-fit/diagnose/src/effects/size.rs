//! Data-sheet units of coefficients: mg/K, dps/g, µg/V, ppm/dps², ….

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use fos_data::column::Column;
use fos_data::unit::{MG_MPS2, STANDARD_GRAVITY_MPS2};

/// Unit of a coefficient and its size in SI (m/s² or rad/s per unit of the logged quantity).
#[derive(Debug, Clone, PartialEq)]
pub struct SizeUnit {
    text: String,
    /// Size of one of this unit in SI.
    pub si: f64,
}

/// Size of a unit in SI; logged quantities keep the unit of their column (°C, V, %, µT).
fn si(unit: &str) -> Option<f64> {
    Some(match unit {
        "dps" => PI / 180.0,
        "mdps" => PI / 180e3,
        "dph" => PI / 180.0 / 3600.0,
        "K" | "V" | "pct" | "µT" | "s" | "m" | "1" => 1.0,
        "g" => STANDARD_GRAVITY_MPS2,
        "mg" => MG_MPS2,
        "µg" => STANDARD_GRAVITY_MPS2 * 1e-6,
        "%" | "cm" => 1e-2,
        "ppm" => 1e-6,
        "mV" => 1e-3,
        "h" => 3600.0,
        _ => return None,
    })
}

/// Longest text of a unit, bytes.
const MAX_BYTES: usize = 64;

/// Characters that end a name.
fn is_sign(letter: char) -> bool {
    matches!(letter, '/' | '(' | ')' | '²' | '³')
}

/// Reads `a/b/c` as `(a/b)/c`: returns its size in SI and the text after it.
fn ratio(text: &str) -> Option<(f64, &str)> {
    let (mut size, mut rest) = power(text)?;
    // terminates: each iteration shortens the rest
    while let Some(denominator) = rest.strip_prefix('/') {
        let (one, after) = power(denominator)?;
        size *= 1.0 / one;
        rest = after;
    }
    Some((size, rest))
}

/// Reads a name, or a ratio in brackets, with its power.
fn power(text: &str) -> Option<(f64, &str)> {
    let (one, rest) = match text.strip_prefix('(') {
        Some(inside) => {
            let (one, rest) = ratio(inside)?;
            (one, rest.strip_prefix(')')?)
        }
        None => {
            let (name, rest) = text.split_at(text.find(is_sign).unwrap_or(text.len()));
            (si(name)?, rest)
        }
    };
    Some(match (rest.strip_prefix('²'), rest.strip_prefix('³')) {
        (Some(after), _) => (one.powi(2), after),
        (_, Some(after)) => (one.powi(3), after),
        _ => (one, rest),
    })
}

impl SizeUnit {
    /// Returns the unit of sizes on an axis: °/s for a gyro, mg for an accelerometer.
    pub fn of_axis(column: Column<'_>) -> Self {
        let (text, si) = if column.is_angular_rate() { ("dps", PI / 180.0) } else { ("mg", MG_MPS2) };
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
        // the length limits the depth of the brackets
        match Some(text).filter(|text| text.len() <= MAX_BYTES).and_then(ratio) {
            Some((si, "")) => Ok(Self { text: text.to_owned(), si }),
            _ => Err(format!(
                "unit {text:?}: write NUMERATOR or NUMERATOR/DENOMINATOR out of dps, mdps, dph, g, mg, µg, %, ppm, cm, m, K, V, mV, pct, µT, s, h, with ² or ³, as mg/K², or with a ratio in brackets, as mg/(K/s)"
            )),
        }
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
            ("(mg/K)/V", 9.80665e-3),
            ("(mg/mV)/h", 9.80665 / 3600.0),
            ("mg/mV/h", 9.80665 / 3600.0),
            ("mg/mV/h/h", 9.80665 / 3600.0 / 3600.0),
            ("mg/(K/h)²", 9.80665e-3 * 3600.0 * 3600.0),
            ("dps/(g/(mV/h))", PI / 180.0 / 9.80665 * (1e-3 / 3600.0)),
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
        let nested = format!("{}mg{}", "(".repeat(100_000), ")".repeat(100_000));
        for text in [
            "dps/furlong",
            "",
            "mg/",
            "/K",
            "mg//K",
            "(mg/K",
            "mg/K)",
            "mg()",
            "mg(K)",
            "(mg)K",
            "mg²²",
            &nested,
        ] {
            assert!(text.parse::<SizeUnit>().is_err(), "{text}");
        }
    }
}
