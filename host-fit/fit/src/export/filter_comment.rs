//! Discrete noise of a Kalman filter as comment lines of a YAML file.

use std::fmt::Write as _;

use super::comment::in_ascii;
use super::noise_unit::NoiseUnits;
use super::real::real;
use crate::noise::{Absent, AxisNoise, FilterNoise};

/// Returns comment lines, in ASCII: the equations, then one line per axis.
pub(super) fn filter_comment(axes: &[AxisNoise]) -> String {
    let Some(first) = axes.first() else { return String::new() };
    let mut text = format!(
        "\n# For a Kalman filter with one bias b per axis, updated every dt = {} s (one sample):\n\
         #   measured = true + b + white noise of variance r;  next b = phi * b + noise of variance q\n\
         #   r = N^2 / dt;  Gauss-Markov process: phi = exp(-dt / tau), q = sigma^2 * (1 - phi^2);\n\
         #   random walk: phi = 1, q = K^2 * dt\n\
         # N and K are two-sided densities, as above; a one-sided density (PSD of a data sheet) is sqrt(2) times N.\n",
        real(first.filter.interval_s)
    );
    for axis in axes {
        // writing to a string cannot fail
        let _ = writeln!(text, "#   {}: {}", in_ascii(&axis.column), line(axis));
    }
    text
}

fn line(axis: &AxisNoise) -> String {
    let NoiseUnits { white: white_unit, flicker: unit, walk: walk_unit } = NoiseUnits::of(&axis.unit);
    let FilterNoise {
        white, white_variance, deviation, tau_s, walk, transition, bias_variance, absent, ..
    } = axis.filter;
    let mut parts = Vec::new();
    if let Some((white, variance)) = white.zip(white_variance) {
        parts.push(format!("N {white:.4e} {white_unit}, r {variance:.4e} ({unit})^2"));
    }
    if let Some((deviation, tau_s)) = deviation.zip(tau_s) {
        parts.push(format!("sigma {deviation:.4e} {unit}, tau {tau_s:.1} s"));
    }
    if let Some(walk) = walk {
        parts.push(format!(
            "K {walk:.4e} {walk_unit}; no sigma and tau: a random walk describes the bias as well"
        ));
    }
    if let Some((transition, variance)) = transition.zip(bias_variance) {
        parts.push(format!("phi {transition:.10}, q {variance:.4e} ({unit})^2"));
    }
    match absent {
        Some(Absent::HiddenByStep) => {
            parts.push("no values: the step of the sensor hides its noise".to_owned())
        }
        Some(Absent::WalkNotSeen) => parts.push(format!(
            "no q: {:.0} s at rest do not show a random walk; K is at most {:.4e} {walk_unit} (95 %)",
            axis.seconds, axis.levels.walk.high
        )),
        None => {}
    }
    parts.join("; ")
}
