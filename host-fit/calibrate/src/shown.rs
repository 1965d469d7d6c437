//! Numbers of a calibration as a data sheet writes them.

use serde::Serialize;

use crate::parameter::{Determined, Parameter};
use crate::rests::Exclusion;
use fos_data::unit::{MG_MPS2, STANDARD_GRAVITY_MPS2};

/// A parameter formatted for people.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// Spelled for people: `accelerometer x bias`.
    pub label: String,
    /// The value, without its unit.
    pub value: String,
    /// Half the width of the 95 % interval.
    pub half_width: String,
    /// The unit of both numbers.
    pub unit: String,
    /// A note where the log does not determine it well; else empty.
    pub note: &'static str,
}

impl Shown {
    /// Formatted as `12.3 ± 0.4`.
    pub fn both(&self) -> String {
        format!("{} ± {}", self.value, self.half_width)
    }
}

/// Formats a parameter in field units (mg, %, °/s) or in SI.
pub fn shown(parameter: &Parameter, field: bool) -> Shown {
    let degree = 1_f64.to_radians();
    let is_ratio = parameter.unit.is_empty();
    let (offset, size, unit) = match parameter.unit.as_str() {
        _ if !field => (0.0, 1.0, parameter.unit.as_str()),
        "m/s²" => (0.0, MG_MPS2, "mg"),
        "m/s²/K" => (0.0, MG_MPS2, "mg/K"),
        "rad/s" => (0.0, degree, "°/s"),
        "rad/s/K" => (0.0, degree, "(°/s)/K"),
        "(rad/s)/(m/s²)" => (0.0, degree / STANDARD_GRAVITY_MPS2, "(°/s)/g"),
        "counts/(m/s²)" if parameter.id.contains("g_sensitivity") => {
            (0.0, 1.0 / STANDARD_GRAVITY_MPS2, "counts/g")
        }
        "1/K" => (0.0, 0.01, "%/K"),
        "" => (1.0, 0.01, "%"),
        other => (0.0, 1.0, other),
    };
    let (value, half_width) = ((parameter.value - offset) / size, parameter.half_width / size);
    let (mut value, half_width) = with_interval(value, half_width);
    if is_ratio && field && !value.starts_with('−') {
        value.insert(0, '+');
    }
    let note = match parameter.determined {
        Determined::Well => "",
        Determined::Weakly => "weakly determined",
        Determined::NotByThisLog => "not determined by this log",
    };
    Shown { label: parameter.label.clone(), value, half_width, unit: unit.to_owned(), note }
}

/// A value and half the width of its interval, the latter with two significant digits, the former with as many decimals.
fn with_interval(value: f64, half_width: f64) -> (String, String) {
    let decimals = match half_width {
        half if half.is_finite() && half > 0.0 => (1 - half.log10().floor() as i32).clamp(0, 9) as usize,
        _ => 4,
    };
    // a small negative number is 0, not −0
    let shown = |x: f64| {
        let text = format!("{x:.decimals$}");
        match text.strip_prefix('-') {
            Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
            Some(digits) => format!("−{digits}"),
            None => text,
        }
    };
    (shown(value), shown(half_width))
}

impl std::fmt::Display for Exclusion {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Moves { share } => write!(out, "moves by {:.0} mg", 1000.0 * share),
            Self::Clips { axis } => write!(out, "{} clips", ["x", "y", "z"][*axis]),
            Self::Outlier { deviations } => write!(out, "|a| is {deviations:.0} σ off"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: f64, half_width: f64, unit: &str) -> Parameter {
        Parameter {
            id: "accelerometer.bias.x".to_owned(),
            label: "accelerometer x bias".to_owned(),
            value,
            half_width,
            unit: unit.to_owned(),
            determined: Determined::Well,
        }
    }

    #[test]
    fn digits_follow_the_interval() {
        for (value, half, unit, text, shown_unit) in [
            (0.123_456, 0.004_9, "m/s²", "12.59 ± 0.50", "mg"),
            (-0.001_2, 0.000_3, "rad/s", "−0.069 ± 0.017", "°/s"),
            (1.013_6, 0.000_8, "", "+1.360 ± 0.080", "%"),
            (0.998_7, 0.000_7, "", "−0.130 ± 0.070", "%"),
            (33_123.861, 0.508, "counts", "33123.86 ± 0.51", "counts"),
            (-1e-9, 0.01, "°", "0.000 ± 0.010", "°"),
        ] {
            let one = shown(&parameter(value, half, unit), true);
            assert_eq!((one.both().as_str(), one.unit.as_str()), (text, shown_unit));
        }
        assert_eq!(shown(&parameter(0.123_456, 0.004_9, "m/s²"), false).both(), "0.1235 ± 0.0049");
    }
}
