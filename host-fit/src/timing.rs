//! Wall-clock time of a repeated computation: the minimum for measurements of the machine, the median for comparisons of methods.

use std::hint::black_box;
use std::time::Instant;

/// Returns the shortest wall-clock time of `repeats` runs (at least one), s, and the result of the last run.
pub(crate) fn least_time<T>(repeats: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let (times, result) = times(repeats, &mut run);
    (times[0], result)
}

/// Returns the median wall-clock time of `repeats` runs (at least one), s, and the result of the last run.
pub(crate) fn median_time<T>(repeats: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let (times, result) = times(repeats, &mut run);
    (times[times.len() / 2], result)
}

/// Returns the times of `repeats` runs (at least one), ascending, and the result of the last run.
fn times<T>(repeats: usize, run: &mut impl FnMut() -> T) -> (Vec<f64>, T) {
    let mut timed = || {
        let start = Instant::now();
        let result = black_box(run());
        (start.elapsed().as_secs_f64(), result)
    };
    let (first, mut result) = timed();
    let mut times = vec![first];
    for _ in 1..repeats {
        let (time, again) = timed();
        times.push(time);
        result = again;
    }
    times.sort_unstable_by(f64::total_cmp);
    (times, result)
}
