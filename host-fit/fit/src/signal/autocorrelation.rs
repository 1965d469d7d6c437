//! Normalised autocorrelation: the memory of a residual.

use super::transforms;

/// Standard normal deviate that leaves 2.5 % on either side.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Autocorrelation of a series about its mean.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Autocorrelation {
    /// Value at lag 0, 1, 2 … samples; the first is 1.
    pub values: Vec<f64>,
    /// Number of samples behind the values.
    pub samples: usize,
}

impl Autocorrelation {
    /// Value at a lag of one sample; 0 if no two neighbouring samples are known.
    pub fn lag_1(&self) -> f64 {
        self.values.get(1).copied().unwrap_or(0.0)
    }

    /// Half-width of the band that holds 95 % of the values at lags ≥ 1 if the series is white: 1.96/√N.
    ///
    /// (Bartlett 1946.) The values are already divided by the variance, so it does not appear.
    pub fn white_noise_bound(&self) -> f64 {
        NORMAL_95 / (self.samples as f64).sqrt()
    }

    /// Fraction of the lags ≥ 1 outside `white_noise_bound`; 0.05 is expected for white noise.
    pub fn fraction_outside(&self) -> f64 {
        let lags = &self.values[1..];
        let outside = lags.iter().filter(|value| value.abs() > self.white_noise_bound()).count();
        outside as f64 / lags.len().max(1) as f64
    }
}

/// Largest lag up to which products are summed one by one; an FFT needs more time and many times the memory of the series.
const LARGEST_DIRECT_LAG: usize = 8;

/// Autocorrelation at lags 0 ..= `max_lag`, beyond a few by FFT:
///
/// ρ(k) = Σ (x(n) − x̄)(x(n−k) − x̄) / Σ (x(n) − x̄)²
///
/// with both samples in the same stretch, x̄ the mean of all samples. This is the biased estimator (Box & Jenkins, eq.
/// 2.1.11): both sums run over the available terms, so that |ρ| ≤ 1 and the sequence is positive semidefinite. With
/// stretches not much longer than the lags the values shrink, and the bound is conservative. Lags end below the longest
/// stretch, which gives the last product.
///
/// `None` if the series is empty or constant.
pub fn autocorrelation(stretches: &[&[f64]], max_lag: usize) -> Option<Autocorrelation> {
    if super::is_constant(stretches) {
        return None;
    }
    let mean = super::mean(stretches);
    let longest = stretches.iter().map(|stretch| stretch.len()).max()?;
    let max_lag = max_lag.min(longest.saturating_sub(1));
    let mut products = vec![0.0; max_lag + 1];
    let add = if max_lag <= LARGEST_DIRECT_LAG { add_directly } else { add_by_fft };
    stretches
        .iter()
        .filter(|stretch| !stretch.is_empty())
        .for_each(|stretch| add(&mut products, stretch, mean));
    let mut values: Vec<f64> = products.iter().map(|product| product / products[0]).collect();
    values[0] = 1.0;
    Some(Autocorrelation { values, samples: super::sample_count(stretches) })
}

/// Adds the sums of products of a stretch at lags 0, 1, 2 …, one by one.
fn add_directly(products: &mut [f64], stretch: &[f64], mean: f64) {
    for (lag, sum) in products.iter_mut().enumerate() {
        let pairs = stretch.iter().skip(lag).zip(stretch);
        *sum += pairs.map(|(x, past)| (x - mean) * (past - mean)).sum::<f64>();
    }
}

/// Adds the same by FFT.
fn add_by_fft(products: &mut [f64], stretch: &[f64], mean: f64) {
    // zeros behind the stretch keep the circular products of the transform from wrapping around
    let padded = (stretch.len() + products.len() - 1).next_power_of_two();
    let forward = transforms::forward(padded);
    let inverse = transforms::inverse(padded);
    let mut samples = forward.make_input_vec();
    let mut bins = forward.make_output_vec();
    for (target, x) in samples.iter_mut().zip(stretch) {
        *target = x - mean;
    }
    forward.process(&mut samples, &mut bins).expect("buffers made by this transform fit it");
    for bin in &mut bins {
        *bin = (bin.norm_sqr() / padded as f64).into();
    }
    inverse.process(&mut bins, &mut samples).expect("a squared modulus is real at 0 and Nyquist");
    for (sum, product) in products.iter_mut().zip(&samples) {
        *sum += product;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;
    use fos_testkit::reference::{self, assert_all_close, numbers};

    /// The definition, product by product.
    fn direct(stretches: &[&[f64]], lag: usize) -> f64 {
        let mean = super::super::mean(stretches);
        let product = |lag: usize| -> f64 {
            stretches
                .iter()
                .flat_map(|s| s.iter().skip(lag).zip(s.iter()))
                .map(|(x, past)| (x - mean) * (past - mean))
                .sum()
        };
        product(lag) / product(0)
    }

    #[test]
    fn matches_direct_sums_over_uneven_stretches() {
        let series: Vec<f64> = white_noise(2, 400).iter().map(|x| 9.81 + 0.01 * x).collect();
        for cuts in [[0, 0], [1, 3], [37, 38], [200, 399]] {
            let stretches = [&series[..cuts[0]], &series[cuts[0]..cuts[1]], &series[cuts[1]..]];
            let [few, many] = [LARGEST_DIRECT_LAG, 60].map(|lags| autocorrelation(&stretches, lags).unwrap());
            for (lag, value) in few.values.iter().enumerate().chain(many.values.iter().enumerate()) {
                // rounding of 9.81 in a signal of 0.01: 1e-13 relative, times the root of the sample count
                assert!((value - direct(&stretches, lag)).abs() < 1e-11, "lag {lag}, cuts {cuts:?}");
            }
        }
    }

    #[test]
    fn agrees_with_statsmodels() {
        for reference in reference::each("residuals", "residual_tests_shared") {
            let series = reference.series().to_vec();
            let squares: Vec<f64> = series.iter().map(|x| x * x).collect();
            for (key, series) in [("acf_0_20", series), ("acf_of_squares_0_10", squares)] {
                let expected = numbers(&reference.answers[key]);
                let found = autocorrelation(&[&series], expected.len() - 1).unwrap();
                // of 1, which comes first: as the reference file states
                assert_all_close(key, &found.values, &expected, 1e-8);
            }
        }
    }

    #[test]
    fn white_noise_exceeds_the_bound_in_five_percent_of_lags() {
        // 200 series × 50 lags, nearly independent: standard deviation √(0.05·0.95/10⁴) = 0.22 %; four of them
        let series: Vec<Vec<f64>> = (0..200).map(|seed| white_noise(seed, 4000)).collect();
        let outside: f64 = series
            .iter()
            .map(|x| autocorrelation(&[&x[..1500], &x[1500..]], 50).unwrap().fraction_outside())
            .sum::<f64>()
            / 200.0;
        assert!((outside - 0.05).abs() < 0.009, "{outside}");
    }

    #[test]
    fn bound_is_independent_of_unit() {
        let noise = white_noise(9, 2000);
        let scaled: Vec<f64> = noise.iter().map(|x| 1e-4 * x).collect();
        let (left, right) =
            (autocorrelation(&[&noise], 40).unwrap(), autocorrelation(&[&scaled], 40).unwrap());
        assert_eq!(left.white_noise_bound(), right.white_noise_bound());
        assert_eq!(left.fraction_outside(), right.fraction_outside());
    }

    #[test]
    fn constant_and_empty_series_have_no_autocorrelation() {
        assert_eq!(autocorrelation(&[&[9.81; 1000]], 10), None);
        assert_eq!(autocorrelation(&[&[]], 10), None);
        assert_eq!(autocorrelation(&[], 10), None);
    }

    #[test]
    fn lags_end_below_the_longest_stretch() {
        assert_eq!(autocorrelation(&[&[1.0, 2.0, 4.0], &[1.0]], 10).unwrap().values.len(), 3);
    }
}
