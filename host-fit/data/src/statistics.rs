//! Mean, variance and median of a sampled series in `stretches`: the gap-free pieces of one recording. Values must be
//! finite.

/// Number of samples in all stretches together.
pub fn sample_count(stretches: &[&[f64]]) -> usize {
    stretches.iter().map(|stretch| stretch.len()).sum()
}

/// Mean of all samples; 0 where there are none.
pub fn mean(stretches: &[&[f64]]) -> f64 {
    let count = sample_count(stretches).max(1);
    stretches.iter().copied().flatten().sum::<f64>() / count as f64
}

/// Samples minus their mean: products of large numbers (°C squared) keep their digits.
pub fn centred(mut samples: Vec<f64>) -> Vec<f64> {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    samples.iter_mut().for_each(|sample| *sample -= mean);
    samples
}

/// Mean square about the mean of all samples (divided by N, not N − 1); 0 where there are none.
///
/// ```
/// use fos_data::statistics::variance;
/// assert_eq!(variance(&[&[1.0, 3.0], &[5.0, 7.0]]), 5.0);
/// ```
pub fn variance(stretches: &[&[f64]]) -> f64 {
    let mean = mean(stretches);
    let count = sample_count(stretches).max(1);
    stretches.iter().copied().flatten().map(|x| (x - mean).powi(2)).sum::<f64>() / count as f64
}

/// Median (the upper one of an even number), selected in linear time; reorders `values`. Zero if empty.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Standard deviation of a normal distribution divided by its median absolute deviation.
pub const MAD_TO_SD: f64 = 1.4826;

/// Median of the finite values, robust to a few outliers; `None` if there are none.
pub fn finite_median(values: &[f64]) -> Option<f64> {
    median_of(values.iter().copied().filter(|value| value.is_finite()))
}

/// Median of an iterator; `None` if empty.
pub fn median_of(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let given = values.into_iter();
    // the upper bound of a filter's size hint avoids reallocation
    let mut values = Vec::with_capacity(given.size_hint().1.unwrap_or(0));
    values.extend(given);
    (!values.is_empty()).then(|| median(&mut values))
}

/// Median with the mean of the two middle values for an even number, unlike [`median`], so it need not be a value that
/// occurs. Sorts `values`; zero if empty.
pub fn midpoint_median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

/// Returns true if all samples are equal, also for no samples.
pub fn is_constant(stretches: &[&[f64]]) -> bool {
    let mut samples = stretches.iter().copied().flatten();
    let first = samples.next();
    samples.all(|x| Some(x) == first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_do_not_depend_on_where_the_gaps_are() {
        let series = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        for cut in 0..=series.len() {
            let (left, right) = series.split_at(cut);
            assert_eq!(mean(&[left, right]), 5.0);
            assert_eq!(variance(&[left, right]), 4.0);
        }
    }

    #[test]
    fn mean_and_variance_of_no_samples_are_zero() {
        assert_eq!((mean(&[]), variance(&[])), (0.0, 0.0));
    }

    #[test]
    fn medians_of_odd_numbers_agree_and_of_even_ones_are_the_upper_or_between() {
        for (values, upper, between) in
            [(vec![7.0], 7.0, 7.0), (vec![9.0, 1.0, 4.0], 4.0, 4.0), (vec![8.0, 2.0, 1.0, 4.0], 4.0, 3.0)]
        {
            assert_eq!(median(&mut values.clone()), upper);
            assert_eq!(median_of(values.clone()), Some(upper));
            assert_eq!(midpoint_median(&mut values.clone()), between);
        }
        assert_eq!((median(&mut []), median_of([]), midpoint_median(&mut [])), (0.0, None, 0.0));
    }

    /// Selection and sorting give the same bits for the middle value of the total order.
    #[test]
    fn selection_and_sorting_give_the_same_median() {
        let values: Vec<f64> =
            (0..257_i32).map(|k| f64::from(k * 7919 % 101) * 0.1 - 5.0).chain([-0.0, 0.0]).collect();
        for count in 1..=values.len() {
            let mut sorted = values[..count].to_vec();
            sorted.sort_unstable_by(f64::total_cmp);
            let selected = median(&mut values[..count].to_vec());
            assert_eq!(selected.to_bits(), sorted[count / 2].to_bits());
        }
    }

    #[test]
    fn detects_a_constant_across_gaps() {
        assert!(is_constant(&[]) && is_constant(&[&[]]) && is_constant(&[&[1.0], &[1.0, 1.0]]));
        assert!(!is_constant(&[&[1.0], &[1.0, 2.0]]) && !is_constant(&[&[1.0], &[2.0]]));
    }
}
