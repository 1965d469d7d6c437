//! Allan deviation of a rate or acceleration at rest, which separates noise, bias instability and drift by averaging
//! time.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::blocks::cumulative_sums;
use fos_data::interrupt::in_parallel;

/// Allan deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct AllanPoint {
    /// Averaging time, s: a whole number of sample periods.
    pub tau_s: f64,
    /// Allan deviation, unit of the series.
    pub deviation: f64,
    /// Lower end of the 95 % confidence interval.
    pub low: f64,
    /// Upper end of the 95 % confidence interval.
    pub high: f64,
    /// Equivalent degrees of freedom behind the interval.
    pub degrees_of_freedom: f64,
}

impl AllanPoint {
    /// Returns the confidence interval at another confidence level, from χ² with the same degrees of freedom.
    pub fn interval(&self, share: f64) -> (f64, f64) {
        interval(self.deviation.powi(2), self.degrees_of_freedom, share)
    }
}

/// Overlapping Allan deviation at the given averaging times (NIST SP 1065, eq. 11, in terms of averages):
///
/// σ²(τ) = ½ ⟨(ȳ(i+m) − ȳ(i))²⟩, ȳ(i) = mean of samples i … i+m−1, m = τ / sample period
///
/// averaged over every i for which both means lie in one stretch, with all stretches pooled. Each τ is rounded to a
/// whole number of samples; times for which no stretch holds 2 m samples are omitted.
///
/// The interval is that of χ² with the equivalent degrees of freedom of NIST SP 1065, table 5, summed over the
/// stretches. They depend on the kind of noise, which changes with τ: the smallest of those for white, flicker and
/// random-walk noise of the rate is used, so the interval is conservative.
///
/// ```
/// use fos_fit::signal::allan::allan_deviation;
/// let alternating: Vec<f64> = (0..100).map(|n| f64::from(n % 2)).collect();
/// let points = allan_deviation(&[&alternating], 0.01, &[0.01, 0.02]);
/// assert!((points[0].deviation - 0.5f64.sqrt()).abs() < 1e-12);
/// assert!(points[1].deviation < 1e-12); // a zero and a one average out
/// ```
pub fn allan_deviation(stretches: &[&[f64]], sample_period_s: f64, taus_s: &[f64]) -> Vec<AllanPoint> {
    let integrals: Vec<Vec<f64>> = stretches.iter().map(|stretch| cumulative_sums(stretch)).collect();
    let mut averaging: Vec<usize> =
        taus_s.iter().map(|tau| ((tau / sample_period_s).round() as usize).max(1)).collect();
    averaging.dedup();
    in_parallel(averaging, |m| point(&integrals, sample_period_s, m)).into_iter().flatten().collect()
}

/// Number of sums that are added up side by side.
const SUMS: usize = 16;

/// Averaging times per decade of every displayed curve.
pub const TAUS_PER_DECADE: usize = 8;

/// Averaging times evenly spaced on a logarithmic axis, s: from one sample to a fifth of the longest stretch,
/// beyond which the upper end of the interval is more than four times the value.
pub fn averaging_times(stretches: &[&[f64]], sample_period_s: f64, per_decade: usize) -> Vec<f64> {
    let longest = stretches.iter().map(|stretch| stretch.len()).max().unwrap_or(0);
    // terminates: it grows, at ten to the power of a step
    let mut averaging: Vec<usize> = (0..)
        .map(|step| 10f64.powf(step as f64 / per_decade.max(1) as f64).round() as usize)
        .take_while(|m| *m <= longest / 5)
        .collect();
    averaging.dedup();
    averaging.into_iter().map(|m| m as f64 * sample_period_s).collect()
}

/// Computes a point from all stretches at an averaging time of `m` samples.
fn point(integrals: &[Vec<f64>], sample_period_s: f64, m: usize) -> Option<AllanPoint> {
    let mut sum = 0.0;
    let mut count = 0;
    let mut degrees_of_freedom = 0.0;
    for integral in integrals.iter().filter(|integral| integral.len() > 2 * m) {
        sum += squared_differences(integral, m) / (m * m) as f64;
        count += integral.len() - 2 * m;
        degrees_of_freedom += equivalent_degrees_of_freedom(integral.len(), m);
    }
    if count == 0 {
        return None;
    }
    let variance = 0.5 * sum / count as f64;
    let (low, high) = interval(variance, degrees_of_freedom, 0.95);
    Some(AllanPoint {
        tau_s: m as f64 * sample_period_s,
        deviation: variance.sqrt(),
        low,
        high,
        degrees_of_freedom,
    })
}

/// Sum of the squared second differences of the integral, m (ȳ(i+m) − ȳ(i)).
fn squared_differences(integral: &[f64], m: usize) -> f64 {
    let [mut first, mut second, mut third] =
        [&integral[..integral.len() - 2 * m], &integral[m..], &integral[2 * m..]];
    // side by side: one sum would wait for each addition
    let mut sums = [0.0; SUMS];
    let of = |a: f64, b: f64, c: f64| (c - 2.0 * b + a).powi(2);
    while let (Some((a, a_left)), Some((b, b_left)), Some((c, c_left))) = (
        first.split_first_chunk::<SUMS>(),
        second.split_first_chunk::<SUMS>(),
        third.split_first_chunk::<SUMS>(),
    ) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += of(a[lane], b[lane], c[lane]);
        }
        (first, second, third) = (a_left, b_left, c_left);
    }
    let rest = first.iter().zip(second).zip(third).map(|((a, b), c)| of(*a, *b, *c));
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

fn interval(variance: f64, degrees_of_freedom: f64, share: f64) -> (f64, f64) {
    let chi_squared = ChiSquared::new(degrees_of_freedom).expect("degrees of freedom are positive");
    let bound = |probability| (variance * degrees_of_freedom / chi_squared.inverse_cdf(probability)).sqrt();
    // 0.025 and 0.975 of 95 %, to the bit
    let outside = 0.5 * (1.0 - share);
    let outside = (outside * 1e9).round() / 1e9;
    (bound(1.0 - outside), bound(outside))
}

/// Smallest of the equivalent degrees of freedom of the overlapping Allan variance for white, flicker and
/// random-walk noise of the rate; NIST SP 1065, table 5, with N = `points` of the integral.
fn equivalent_degrees_of_freedom(points: usize, m: usize) -> f64 {
    let (n, m) = (points as f64, m as f64);
    let white = (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * (4.0 * m * m / (4.0 * m * m + 5.0));
    let flicker = if m == 1.0 {
        2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9)
    } else {
        5.0 * n * n / (4.0 * m * (n + 3.0 * m))
    };
    let squares = (n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m;
    let random_walk = (n - 2.0) / m * squares / (n - 3.0).max(1.0).powi(2);
    // one difference of two means has one degree of freedom; the approximations are below that at the end
    white.min(flicker).min(random_walk).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::{random_walk, white_noise};
    use fos_testkit::reference::{self, number};

    /// The 1000-point test suite of NIST SP 1065, section 12.4.
    fn nist_1000() -> Vec<f64> {
        let mut n: u64 = 1_234_567_890;
        std::iter::repeat_with(|| {
            let value = n as f64 / 2_147_483_647.0;
            n = 16_807 * n % 2_147_483_647;
            value
        })
        .take(1000)
        .collect()
    }

    #[test]
    fn reproduces_the_published_values_of_nist_sp_1065() {
        let points = allan_deviation(&[&nist_1000()], 1.0, &[1.0, 10.0, 100.0]);
        let published = [2.922319e-1, 9.159953e-2, 3.241343e-2]; // table 31, overlapping Allan, as printed
        for (point, published) in points.iter().zip(published) {
            assert!((point.deviation / published - 1.0).abs() < 2e-7, "half of the last printed digit");
        }
        assert_eq!(points.len(), 3);
    }

    #[test]
    fn agrees_with_independent_computation_and_nist_sp_1065() {
        for reference in reference::each("allan", "allan_nbs1000") {
            assert_eq!(reference.series().len(), 1000);
            let tolerance = number(&reference.answers["tolerance_relative"]);
            for (tau, expected) in reference.answers["published"]["oadev"].as_object().unwrap() {
                let taus = [tau.parse().unwrap()];
                let found = allan_deviation(&[reference.series()], 1.0, &taus)[0].deviation;
                assert!((found / number(expected) - 1.0).abs() < tolerance, "τ = {tau} s: {found}");
            }
        }
    }

    #[test]
    fn matches_the_definition_and_never_spans_gaps() {
        let series: Vec<f64> = white_noise(4, 300).iter().map(|x| 9.81 + 1e-3 * x).collect();
        let stretches = [&series[..50], &series[50..51], &series[60..]];
        for m in [1, 2, 7, 25, 30, 120] {
            let mut squares = Vec::new();
            for stretch in stretches {
                let mean = |from: usize| stretch[from..from + m].iter().sum::<f64>() / m as f64;
                for i in 0..(stretch.len() + 1).saturating_sub(2 * m) {
                    squares.push((mean(i + m) - mean(i)).powi(2));
                }
            }
            let expected = (0.5 * squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            let found = allan_deviation(&stretches, 0.01, &[m as f64 * 0.01])[0];
            // rounding of 9.81 in a signal of 1e-3: 1e-12 relative, over up to 120 additions
            assert!((found.deviation / expected - 1.0).abs() < 1e-9, "m = {m}");
        }
    }

    #[test]
    fn interval_has_at_least_its_stated_coverage() {
        // 200 records each of white noise and random walk, one whole and one in two stretches. If the edf are those of
        // the other kind of noise the interval is too wide, so only the lower end is tested: 95 % minus three binomial
        // standard deviations of 1.5 %
        let white = |m: f64| (1.0 / m).sqrt();
        let walk = |m: f64| ((2.0 * m * m + 1.0) / (6.0 * m)).sqrt();
        for m in [1.0, 10.0, 100.0, 300.0] {
            let mut held = [0; 2];
            for seed in 0..200 {
                for (kind, series, truth) in
                    [(0, white_noise(seed, 2000), white(m)), (1, random_walk(seed, 2000), walk(m))]
                {
                    let (left, right) = series.split_at(if seed % 2 == 0 { 0 } else { 800 });
                    let point = allan_deviation(&[left, right], 1.0, &[m])[0];
                    held[kind] += usize::from(point.low <= truth && truth <= point.high);
                }
            }
            println!("m = {m}: interval holds in {held:?} of 200");
            assert!(held.iter().all(|held| *held >= 181), "m = {m}: {held:?} of 200");
        }
    }

    #[test]
    fn ladder_rises_from_one_sample_to_a_fifth_of_the_longest_stretch() {
        let taus = averaging_times(&[&[0.0; 10], &vec![0.0; 3000]], 0.5, 4);
        assert_eq!(taus[..4], [0.5, 1.0, 1.5, 3.0]);
        assert_eq!(taus.last(), Some(&281.0));
        assert!(averaging_times(&[], 0.5, 4).is_empty());
    }

    #[test]
    fn handles_short_and_constant_records() {
        assert!(allan_deviation(&[&[1.0]], 1.0, &[1.0]).is_empty());
        assert!(allan_deviation(&[], 1.0, &[1.0]).is_empty());
        assert_eq!(allan_deviation(&[&[1.0, 3.0]], 1.0, &[1.0])[0].deviation, 2f64.sqrt());
        assert_eq!(allan_deviation(&[&[9.81; 64]], 1.0, &[4.0])[0].deviation, 0.0);
    }
}
