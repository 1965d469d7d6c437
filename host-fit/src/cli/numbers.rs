//! Numbers on the command line: those that mean something, and no others.

use std::ops::RangeInclusive;

use clap::builder::RangedU64ValueParser;

/// A number of this range; infinities and NaN are in none.
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

/// So many of something.
pub(super) fn count(range: RangeInclusive<u64>) -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(range)
}

/// In an axis' unit: any that a model can hold, and any code of a sensor.
pub(super) const IN_UNIT: f64 = 1e12;
