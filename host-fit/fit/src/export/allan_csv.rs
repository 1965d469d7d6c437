//! The noise of a log as a table: what its figure shows, number by number.

use std::fmt::Write as _;

use super::noise_unit::NoiseUnits;
use crate::noise::{AxisNoise, Level};

/// The share that the intervals of a noise table hold.
pub const SHARE: f64 = 0.9;

/// One row a number: `column,quantity,tau_s,value,low,high,unit`, the interval of 90 %. N, B and K have no averaging
/// time; one that was not seen has no value and no lower end.
pub fn allan_csv(axes: &[AxisNoise]) -> String {
    let mut text = String::from("column,quantity,tau_s,value,low,high,unit\n");
    for axis in axes {
        let units = NoiseUnits::of(&axis.unit);
        let levels = &axis.levels;
        for (name, level, unit) in [
            ("N", levels.white, &units.white),
            ("B", levels.flicker, &units.flicker),
            ("K", levels.walk, &units.walk),
        ] {
            let Level { value, low, high } = level;
            let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
            // writing to a string does not fail
            let _ = writeln!(text, "{},{name},,{},{},{high:e},{unit}", axis.column, cell(value), cell(low));
        }
        for point in &axis.allan {
            let (low, high) = point.interval(SHARE);
            let _ = writeln!(
                text,
                "{},allan_deviation,{:e},{:e},{low:e},{high:e},{}",
                axis.column, point.tau_s, point.deviation, units.flicker
            );
        }
    }
    text
}
