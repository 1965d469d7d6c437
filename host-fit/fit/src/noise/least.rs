//! Least positive number from which on a condition holds.

/// Relative accuracy, as a factor.
const EXACT: f64 = 1.01;

/// Least number from which on `is_enough` holds, searched from `first` over so many doublings and then between the last two
/// within 1 %; none if it holds for none of them. If it holds for `first`, the number lies between `first`/2 and `first`.
pub fn least_where(first: f64, doublings: i32, is_enough: impl Fn(f64) -> bool) -> Option<f64> {
    let mut high = (0..doublings).map(|n| first * 2.0_f64.powi(n)).find(|value| is_enough(*value))?;
    let mut low = high / 2.0;
    // ends: the bracket shrinks to its square root
    while high > EXACT * low {
        let middle = (low * high).sqrt();
        if is_enough(middle) { high = middle } else { low = middle }
    }
    Some(high)
}
