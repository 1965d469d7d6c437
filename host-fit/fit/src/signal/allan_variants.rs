//! Plain and modified Allan deviation, for comparison with published figures; evaluations here use the overlapping one
//! (`allan`), which uses the data better than the plain one.

use super::blocks::{block_means, cumulative_sums};

/// Allan deviation without overlap (NIST SP 1065, eq. 9): of the means of consecutive blocks of `samples`, with
/// neighbours in one stretch. `None` if no stretch holds two blocks, or for 0 samples.
pub fn plain_allan_deviation(stretches: &[&[f64]], samples: usize) -> Option<f64> {
    if samples == 0 {
        return None;
    }
    let means = stretches.iter().map(|stretch| block_means(&[stretch], samples));
    let squares: Vec<f64> = means
        .flat_map(|means| means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).collect::<Vec<_>>())
        .collect();
    deviation(&squares)
}

/// Modified Allan deviation (NIST SP 1065, eq. 16): the differences of neighbouring means over `samples`, averaged over
/// as many starts. It distinguishes white from flicker noise of the angle. `None` if no stretch holds 3 m − 1 samples,
/// or for 0 samples.
pub fn modified_allan_deviation(stretches: &[&[f64]], samples: usize) -> Option<f64> {
    if samples == 0 {
        return None;
    }
    let m = samples;
    let squares: Vec<f64> = stretches
        .iter()
        .flat_map(|stretch| {
            let integral = cumulative_sums(stretch);
            let differences: Vec<f64> = (2 * m..integral.len())
                .map(|i| integral[i] - 2.0 * integral[i - m] + integral[i - 2 * m])
                .collect();
            let windows = differences.windows(m);
            windows.map(|w| (w.iter().sum::<f64>() / (m * m) as f64).powi(2)).collect::<Vec<_>>()
        })
        .collect();
    deviation(&squares)
}

/// √(½⟨d²⟩).
fn deviation(squares: &[f64]) -> Option<f64> {
    (!squares.is_empty()).then(|| (0.5 * squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::allan::allan_deviation;
    use super::*;
    use fos_testkit::noise::white_noise;
    use fos_testkit::reference::{self, Reference, number};

    #[test]
    fn agree_with_independent_computation_and_nist_sp_1065() {
        for reference in reference::each("allan", "allan_nbs1000") {
            assert_as_published(&reference);
        }
    }

    fn assert_as_published(reference: &Reference) {
        let (answers, series) = (&reference.answers, reference.series());
        let tolerance = number(&answers["tolerance_relative"]);
        for (key, kind) in [
            ("adev", plain_allan_deviation as fn(&[&[f64]], usize) -> Option<f64>),
            ("mdev", modified_allan_deviation),
        ] {
            let published = answers["published"][key].as_object().unwrap();
            assert_eq!(published.len(), 3);
            for (samples, expected) in published {
                let found = kind(&[series], samples.parse().unwrap()).unwrap();
                assert!((found / number(expected) - 1.0).abs() < tolerance, "{key} {samples}: {found}");
            }
        }
    }

    #[test]
    fn all_three_kinds_agree_at_one_sample() {
        let noise = white_noise(3, 400);
        let stretches: &[&[f64]] = &[&noise[..150], &noise[150..]];
        let overlapping = allan_deviation(stretches, 1.0, &[1.0])[0].deviation;
        for found in [plain_allan_deviation(stretches, 1), modified_allan_deviation(stretches, 1)] {
            // rounding of sums of 400 numbers
            assert!((found.unwrap() / overlapping - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn differences_never_span_gaps() {
        assert_eq!(plain_allan_deviation(&[&[1.0; 4], &[9.0; 4]], 2), Some(0.0));
        assert_eq!(modified_allan_deviation(&[&[1.0; 5], &[9.0; 5]], 2), Some(0.0));
        assert_eq!(plain_allan_deviation(&[&[1.0; 3], &[9.0; 3]], 2), None);
        assert_eq!(modified_allan_deviation(&[&[1.0; 4], &[9.0; 4]], 2), None);
        assert_eq!(plain_allan_deviation(&[&[1.0; 3]], 0), None);
    }
}
