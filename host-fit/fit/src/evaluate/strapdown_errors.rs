//! Errors of a strapdown over the windows of a trace.

use super::strapdown::StrapdownEnd;
use super::trace::Trace;
use super::unaided::{FEWEST_WINDOWS, RmsInterval, UNAIDED_S, UnaidedError};

/// Computes heading and position errors by length of the windows; empty if the model of the trace lacks one of the six
/// axes. Position is the RMS distance in space.
pub fn strapdown_errors(trace: &Trace) -> Vec<UnaidedError> {
    let Some(ends) = &trace.strapdown else { return Vec::new() };
    let error = |(window_s, ends): (f64, &Vec<StrapdownEnd>)| {
        let is_enough = ends.len() >= FEWEST_WINDOWS;
        let parts = |part: &dyn Fn(&StrapdownEnd) -> f64| -> Vec<f64> { ends.iter().map(part).collect() };
        let position = || -> [Vec<f64>; 3] { std::array::from_fn(|i| parts(&|end| end.position_m[i])) };
        UnaidedError {
            window_s,
            windows: ends.len(),
            heading_rad: is_enough.then(|| RmsInterval::of(&[&parts(&|end| end.heading_rad)])),
            position_m: is_enough.then(|| RmsInterval::of(&position().each_ref().map(Vec::as_slice))),
        }
    };
    UNAIDED_S.into_iter().zip(ends).map(error).collect()
}
