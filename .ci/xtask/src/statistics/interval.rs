//! Interval of a share by Clopper and Pearson: at each end, the probability of a count as extreme as the observed one
//! is 2.5 %.

use std::error::Error;

/// Probability of at least `at_least` hits in n trials, each with probability p.
fn tail(at_least: usize, n: usize, p: f64) -> f64 {
    if p <= 0.0 || p >= 1.0 {
        return if p >= 1.0 || at_least == 0 { 1.0 } else { 0.0 };
    }
    let mut logarithm = n as f64 * (1.0 - p).ln();
    let mut sum = 0.0;
    for k in 0..=n {
        if k >= at_least {
            sum += logarithm.exp();
        }
        logarithm += ((n - k) as f64 / (k + 1) as f64).ln() + (p / (1.0 - p)).ln();
    }
    sum
}

/// Upper end of the interval for `hits` hits.
pub(crate) fn upper_end(hits: usize, n: usize) -> f64 {
    let (mut low, mut high) = (hits as f64 / n as f64, 1.0);
    while high - low > 1e-6 {
        let middle = (low + high) / 2.0;
        (low, high) = if 1.0 - tail(hits + 1, n, middle) > 0.025 { (middle, high) } else { (low, middle) };
    }
    high
}

/// Half a unit of the fourth digit, with a small margin.
fn half(number: f64) -> f64 {
    0.51 * 10_f64.powf(number.log10().floor() - 3.0)
}

/// A share and its interval, of four digits each, are those of a count of n cases.
pub(crate) fn check(value: f64, (low, high): (f64, f64), n: usize) -> Result<(), Box<dyn Error>> {
    let hits = (value * n as f64).round() as usize;
    if (value - hits as f64 / n as f64).abs() > if hits == 0 { 0.0 } else { half(value) } {
        return Err(format!("{value} is no share of {n} cases").into());
    }
    let between = |least: f64, most: f64| least <= 0.025 && 0.025 <= most;
    let beyond = |p| 1.0 - tail(hits + 1, n, p);
    let below = if hits == 0 {
        low == 0.0
    } else {
        between(tail(hits, n, low - half(low)), tail(hits, n, low + half(low)))
    };
    let above =
        if hits == n { high == 1.0 } else { between(beyond(high + half(high)), beyond(high - half(high))) };
    if below && above {
        Ok(())
    } else {
        Err(format!("{low} … {high} is not the interval of {hits} of {n}").into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tail_matches_counting() {
        // At least 0, 1, 2, 3 heads with three coins: 1, 7/8, 4/8, 1/8.
        for (at_least, wanted) in [1.0, 0.875, 0.5, 0.125].into_iter().enumerate() {
            assert!((tail(at_least, 3, 0.5) - wanted).abs() < 1e-12);
        }
        assert_eq!([tail(0, 3, 0.0), tail(1, 3, 0.0), tail(3, 3, 1.0)], [1.0, 0.0, 1.0]);
    }

    /// Clopper and Pearson (1934), and R's binom.test(0, 150), (176, 178) to four digits.
    #[test]
    fn interval_matches_textbook() {
        assert!((upper_end(0, 150) - 0.02429).abs() < 5e-6);
        assert!(check(0.0, (0.0, 0.02429), 150).is_ok());
        assert!(check(0.9888, (0.96, 0.9986), 178).is_ok());
    }

    #[test]
    fn rejects_wrong_digit() {
        for (value, interval) in
            [(0.9887, (0.96, 0.9986)), (0.9888, (0.961, 0.9986)), (0.9888, (0.96, 0.9985))]
        {
            assert!(check(value, interval, 178).is_err());
        }
    }
}
