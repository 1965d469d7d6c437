//! Noise of a log as a table: the numbers of its figure.

use std::fmt::Write as _;

use super::noise_unit::NoiseUnits;
use crate::noise::{AxisNoise, Level};

/// Confidence level of the intervals in a noise table.
pub const SHARE: f64 = 0.9;

/// Formats one row per number: `column,quantity,tau_s,value,low,high,unit`, with 90 % intervals. N, B and K have no
/// averaging time; without a detected value they have an upper limit only. σ and τ of a Gauss-Markov process, `sigma` and
/// `tau`, are present if it describes the axis better than B and K.
pub fn allan_csv(axes: &[AxisNoise]) -> String {
    let mut text = String::from("column,quantity,tau_s,value,low,high,unit\n");
    for axis in axes {
        let units = NoiseUnits::of(&axis.unit);
        let levels = &axis.levels;
        let mut shown = vec![
            ("N", levels.white, units.white.as_str()),
            ("B", levels.flicker, &units.flicker),
            ("K", levels.walk, &units.walk),
        ];
        if let Some(process) = levels.gauss_markov {
            shown.extend([("sigma", process.deviation, units.flicker.as_str()), ("tau", process.tau_s, "s")]);
        }
        for (name, level, unit) in shown {
            let Level { value, low, high } = level;
            let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
            // writing to a string cannot fail
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
