//! Step of the converter, estimated from the values.

/// Quantisation of a series.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quantisation {
    /// Smallest step that occurs often between neighbouring values (one LSB), unit of the series.
    pub step: f64,
    /// Variance of rounding to that step, LSB²/12, unit² (Bennett 1948; valid if the noise spans at least half a step).
    pub variance: f64,
}

/// Fraction of the gaps between neighbouring values that must be whole multiples of the step. The rest allows for the
/// rounding of converted units to few digits.
const WHOLE_MULTIPLES: f64 = 0.9;

/// Tolerance of a whole multiple, in steps: truncated decimals in a log change a gap by up to half of the last digit at
/// both ends.
const MULTIPLE_TOLERANCE: f64 = 0.2;

/// Finds the step between neighbouring values, if there is one.
///
/// `None` if fewer than half of the values repeat (the step is then far below the noise, or absent), if the values do
/// not lie on one grid, and for constant series.
///
/// ```
/// use fos_fit::signal::quantisation::quantisation;
/// let codes = [0.25, 0.5, 0.25, 0.75, 0.5, 0.5, 0.25, 1.25].map(|x| x + 9.81);
/// let found = quantisation(&[&codes]).unwrap();
/// assert!((found.step - 0.25).abs() < 1e-12 && (found.variance - 0.0625 / 12.0).abs() < 1e-12);
/// ```
pub fn quantisation(stretches: &[&[f64]]) -> Option<Quantisation> {
    let mut values: Vec<f64> = stretches.iter().copied().flatten().copied().collect();
    values.sort_unstable_by(f64::total_cmp);
    let (smallest, largest) = (*values.first()?, *values.last()?);
    // gaps this small are rounding of scale factors, not codes (f32 has 24 bits)
    let rounding = 2f64.powi(-23) * smallest.abs().max(largest.abs());
    let mut gaps: Vec<f64> =
        values.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > rounding).collect();
    if gaps.is_empty() || 2 * (gaps.len() + 1) > values.len() {
        return None;
    }

    // Some codes in the tails may be absent, so some gaps are multiples of the step. The lowest tenth is not, and the
    // median around it is robust to truncated digits.
    gaps.sort_unstable_by(f64::total_cmp);
    let low = gaps[gaps.len() / 10];
    let around: Vec<f64> = gaps.iter().copied().filter(|gap| (low / 1.5..low * 1.5).contains(gap)).collect();
    let step = around[around.len() / 2];
    let whole = gaps.iter().filter(|gap| {
        let multiple = *gap / step;
        multiple.round() >= 1.0 && (multiple - multiple.round()).abs() <= MULTIPLE_TOLERANCE
    });
    let on_grid = whole.count() as f64 >= WHOLE_MULTIPLES * gaps.len() as f64;
    on_grid.then(|| Quantisation { step, variance: step * step / 12.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    fn quantised(seed: u64, steps_per_sigma: f64, step: f64) -> Vec<f64> {
        white_noise(seed, 20_000).iter().map(|x| 9.81 + step * (steps_per_sigma * x).round()).collect()
    }

    #[test]
    fn finds_the_step_of_coarse_and_fine_converters() {
        for steps_per_sigma in [0.3, 1.0, 10.0, 300.0] {
            for step in [1.0, 1.2e-3] {
                let series = quantised(1, steps_per_sigma, step);
                let found = quantisation(&[&series[..9000], &series[9000..]]).expect("quantised");
                // 9.81 leaves 2e-15 of rounding in a step
                assert!((found.step / step - 1.0).abs() < 1e-9, "{steps_per_sigma} steps per σ: {found:?}");
            }
        }
    }

    #[test]
    fn survives_a_log_with_few_decimals_and_f32() {
        let decimals: Vec<f64> = quantised(2, 3.0, 1.2e-3).iter().map(|x| (x * 1e4).round() / 1e4).collect();
        assert!((quantisation(&[&decimals]).unwrap().step / 1.2e-3 - 1.0).abs() < 0.05);
        let single: Vec<f64> = quantised(2, 3.0, 1.2e-3).iter().map(|x| f64::from(*x as f32)).collect();
        // f32 holds 9.81 to 1e-6
        assert!((quantisation(&[&single]).unwrap().step / 1.2e-3 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn continuous_and_constant_series_have_no_step() {
        assert_eq!(quantisation(&[&white_noise(3, 10_000)]), None);
        assert_eq!(quantisation(&[&[9.81; 100]]), None);
        assert_eq!(quantisation(&[]), None);
    }

    #[test]
    fn held_values_are_not_mistaken_for_codes() {
        let held: Vec<f64> = white_noise(4, 1000).iter().flat_map(|x| [*x; 4]).collect();
        assert_eq!(quantisation(&[&held]), None);
    }
}
