//! Parsers of numbers that accept only a meaningful range.

use std::ops::RangeInclusive;

use clap::builder::RangedU64ValueParser;

/// Parses a number within this range; refuses infinities and NaN.
pub(super) fn within(
    range: RangeInclusive<f64>,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| {
        let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is no number"))?;
        if range.contains(&number) {
            return Ok(number);
        }
        Err(format!("it must lie from {:?} to {:?}", range.start(), range.end()))
    }
}

/// Parses a count within this range.
pub(super) fn count(range: RangeInclusive<u64>) -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(range)
}

/// Largest value in an axis' unit: any that a model can hold, and any code of a sensor.
pub(super) const IN_UNIT: f64 = 1e12;
