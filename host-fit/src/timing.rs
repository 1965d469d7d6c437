//! Wall-clock time of a computation that is repeated: the least where the machine is measured, the median where methods
//! are compared.

use std::hint::black_box;
use std::time::Instant;

/// The least wall-clock time of `repeats` runs (at least one), in seconds, and what the last returned.
pub(crate) fn least_time<T>(repeats: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let (times, result) = times(repeats, &mut run);
    (times[0], result)
}

/// The same with the median of the times.
pub(crate) fn median_time<T>(repeats: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let (times, result) = times(repeats, &mut run);
    (times[times.len() / 2], result)
}

/// The times of `repeats` runs (at least one), ascending, and what the last returned.
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
