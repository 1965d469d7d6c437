//! Textbook tests of a residual: memory, normality, constant variance.
//!
//! With 10⁵ samples each of them is significant long before it matters: they describe a residual, and decide nothing.
//!
//! | function | tests | source |
//! |---|---|---|
//! | `partial_autocorrelation` | the contribution of lag k to the lags before it | Box & Jenkins, section 3.2.5 |
//! | `ljung_box`, `box_pierce` | whiteness up to a lag | Ljung & Box 1978; Box & Pierce 1970 |
//! | `durbin_watson` | correlation of neighbours | Durbin & Watson 1950 |
//! | `jarque_bera` | normality | Jarque & Bera 1980 |
//! | `arch_lm` | memory of the variance | Engle 1982 |

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::autocorrelation::autocorrelation;

/// A statistic that is χ² under the null hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Tested {
    /// Value of the statistic, without a unit.
    pub statistic: f64,
    /// Degrees of freedom of its distribution.
    pub degrees_of_freedom: usize,
    /// Probability of a larger one by chance.
    pub p_value: f64,
}

impl Tested {
    fn of(statistic: f64, degrees_of_freedom: usize) -> Option<Self> {
        let p_value = ChiSquared::new(degrees_of_freedom as f64).ok()?.sf(statistic);
        Some(Self { statistic, degrees_of_freedom, p_value })
    }
}

/// Partial autocorrelation at lags 1 ..= `max_lag`: the last coefficient of the Yule-Walker autoregression of each
/// order, from the biased autocorrelation. `None` if the series is constant or the lags do not fit into a stretch.
pub fn partial_autocorrelation(stretches: &[&[f64]], max_lag: usize) -> Option<Vec<f64>> {
    let rho = autocorrelation(stretches, max_lag)?.values;
    if rho.len() <= max_lag {
        return None;
    }
    (1..=max_lag)
        .map(|order| {
            let matrix = DMatrix::from_fn(order, order, |i, j| rho[i.abs_diff(j)]);
            let right = DVector::from_column_slice(&rho[1..=order]);
            Some(matrix.cholesky()?.solve(&right)[order - 1])
        })
        .collect()
}

/// Ljung-Box: N(N+2) Σ ρ²(k)/(N−k), k = 1 ..= `lags`. The degrees of freedom are `lags`: the caller subtracts the
/// number of coefficients fitted to the series. `None` as for the partial autocorrelation, or without lags.
pub fn ljung_box(stretches: &[&[f64]], lags: usize) -> Option<Tested> {
    let n = super::sample_count(stretches) as f64;
    portmanteau(stretches, lags, |lag| n * (n + 2.0) / (n - lag as f64))
}

/// Box-Pierce: N Σ ρ²(k), k = 1 ..= `lags`; otherwise as Ljung-Box.
pub fn box_pierce(stretches: &[&[f64]], lags: usize) -> Option<Tested> {
    let n = super::sample_count(stretches) as f64;
    portmanteau(stretches, lags, |_| n)
}

fn portmanteau(stretches: &[&[f64]], lags: usize, weight: impl Fn(usize) -> f64) -> Option<Tested> {
    let rho = autocorrelation(stretches, lags)?.values;
    if rho.len() <= lags {
        return None;
    }
    Tested::of((1..=lags).map(|lag| weight(lag) * rho[lag] * rho[lag]).sum(), lags)
}

/// Durbin-Watson: Σ(e(n) − e(n−1))² / Σ e²(n), about 0 and not about the mean of the residual. It is 2 if neighbours
/// are uncorrelated. `None` if the series is 0.
pub fn durbin_watson(stretches: &[&[f64]]) -> Option<f64> {
    let squares: f64 = stretches.iter().copied().flatten().map(|e| e * e).sum();
    let steps: f64 =
        stretches.iter().flat_map(|stretch| stretch.windows(2)).map(|e| (e[1] - e[0]).powi(2)).sum();
    (squares > 0.0).then(|| steps / squares)
}

/// Jarque-Bera: N/6·(S² + (K − 3)²/4), skewness S and kurtosis K from moments divided by N. `None` if the series is
/// constant.
pub fn jarque_bera(stretches: &[&[f64]]) -> Option<Tested> {
    if super::is_constant(stretches) {
        return None;
    }
    let n = super::sample_count(stretches) as f64;
    let mean = super::mean(stretches);
    let moment = |power| stretches.iter().copied().flatten().map(|e| (e - mean).powi(power)).sum::<f64>() / n;
    let variance = moment(2);
    let skewness = moment(3) / variance.powf(1.5);
    let kurtosis = moment(4) / (variance * variance);
    Tested::of(n / 6.0 * (skewness.powi(2) + 0.25 * (kurtosis - 3.0).powi(2)), 2)
}

/// Engle's Lagrange-multiplier test: n·R² of e²(n) on a constant and e²(n−1) … e²(n−`lags`), over the n rows that have
/// all of them in one stretch. `None` with fewer rows than coefficients, or if e² is constant.
pub fn arch_lm(stretches: &[&[f64]], lags: usize) -> Option<Tested> {
    let squares: Vec<Vec<f64>> = stretches.iter().map(|s| s.iter().map(|e| e * e).collect()).collect();
    let windows: Vec<&[f64]> = squares.iter().flat_map(|squares| squares.windows(lags + 1)).collect();
    let n = windows.len();
    if n <= lags + 1 {
        return None;
    }
    // centred, which accounts for the constant
    let mut columns = DMatrix::from_fn(n, lags + 1, |row, column| windows[row][column]);
    for mut column in columns.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    let target = columns.column(lags).into_owned();
    let total = target.norm_squared();
    if total <= 0.0 {
        return None;
    }
    let explained = columns.columns(0, lags).into_owned().qr().q().tr_mul(&target).norm_squared();
    Tested::of(n as f64 * explained / total, lags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::{autoregression, white_noise};
    use fos_testkit::reference::{self, Reference, assert_all_close, number, numbers};

    #[test]
    fn agree_with_statsmodels_and_scipy() {
        for reference in reference::each("residuals", "residual_tests_shared") {
            assert_as_statsmodels_and_scipy(&reference);
        }
    }

    fn assert_as_statsmodels_and_scipy(reference: &Reference) {
        let answers = &reference.answers;
        let series: &[&[f64]] = &[reference.series()];
        let tolerance = number(&answers["tolerance_relative"]);
        let close = |what: &str, value: f64, expected: &serde_json::Value| {
            let expected = number(expected);
            assert!((value / expected - 1.0).abs() < tolerance, "{what}: {value:e} for {expected:e}");
        };
        let rho = autocorrelation(series, 20).unwrap().values;
        assert_all_close("acf", &rho, &numbers(&answers["acf_0_20"]), tolerance);
        let partial = partial_autocorrelation(series, 10).unwrap();
        assert_all_close("pacf", &partial, &numbers(&answers["pacf_1_10_ywm"]), tolerance);
        let portmanteaus = answers["ljung_box"].as_object().unwrap();
        assert_eq!(portmanteaus.len(), 4);
        for (lags, expected) in portmanteaus {
            let lags = lags.parse().unwrap();
            let (ljung_box, box_pierce) =
                (ljung_box(series, lags).unwrap(), box_pierce(series, lags).unwrap());
            close("Ljung-Box", ljung_box.statistic, &expected["q"]);
            close("its p", ljung_box.p_value, &expected["p"]);
            close("Box-Pierce", box_pierce.statistic, &expected["box_pierce"]);
            close("its p", box_pierce.p_value, &expected["box_pierce_p"]);
        }
        let normal = jarque_bera(series).unwrap();
        close("Jarque-Bera", normal.statistic, &answers["jarque_bera"]["stat"]);
        close("its p", normal.p_value, &answers["jarque_bera"]["p"]);
        close("Durbin-Watson", durbin_watson(series).unwrap(), &answers["durbin_watson"]);
        let arch = arch_lm(series, 5).unwrap();
        close("ARCH-LM", arch.statistic, &answers["arch_lm_5"]["lm"]);
        close("its p", arch.p_value, &answers["arch_lm_5"]["p"]);
    }

    #[test]
    fn alarm_on_white_noise_at_their_nominal_rate() {
        // 400 series, each in two stretches: 5 % is 20, four binomial standard deviations are 17
        let mut alarms = [0; 4];
        for seed in 0..400 {
            let noise = white_noise(seed, 3000);
            let stretches: &[&[f64]] = &[&noise[..1100], &noise[1100..]];
            let tests = [
                ljung_box(stretches, 10),
                box_pierce(stretches, 10),
                jarque_bera(stretches),
                arch_lm(stretches, 5),
            ];
            for (alarms, test) in alarms.iter_mut().zip(tests) {
                *alarms += usize::from(test.unwrap().p_value < 0.05);
            }
        }
        assert!(alarms.iter().all(|alarms| (3..=37).contains(alarms)), "{alarms:?} of 400");
    }

    #[test]
    fn each_test_detects_its_alternative() {
        let memory = autoregression(1, 4000, &[0.5], 1.0);
        assert!(ljung_box(&[&memory], 10).unwrap().p_value < 1e-6);
        // 2(1 − φ); standard error of φ is 0.014
        assert!((durbin_watson(&[&memory]).unwrap() - 1.0).abs() < 0.12);
        let partial = partial_autocorrelation(&[&memory], 5).unwrap();
        // four standard errors 1/√N
        assert!((partial[0] - 0.5).abs() < 0.064 && partial[1..].iter().all(|p| p.abs() < 0.064));
        let noise = white_noise(2, 4000);
        let cubed: Vec<f64> = noise.iter().map(|e| e.powi(3)).collect();
        assert!(jarque_bera(&[&cubed]).unwrap().p_value < 1e-6);
        let bursts: Vec<f64> =
            noise.iter().enumerate().map(|(n, e)| if n / 50 % 2 == 0 { *e } else { 3.0 * e }).collect();
        assert!(arch_lm(&[&bursts], 5).unwrap().p_value < 1e-6);
    }

    #[test]
    fn tests_never_span_gaps() {
        // a jump between stretches is not a step
        assert_eq!(durbin_watson(&[&[1.0, 1.0], &[5.0, 5.0]]), Some(0.0));
        let noise = white_noise(7, 60);
        let joined = arch_lm(&[&noise], 2).unwrap();
        let apart = arch_lm(&[&noise[..30], &noise[30..]], 2).unwrap();
        assert!((joined.statistic - apart.statistic).abs() > 1e-6);
    }

    #[test]
    fn constant_and_short_series_give_none() {
        let constant: &[&[f64]] = &[&[2.0; 50]];
        assert_eq!((ljung_box(constant, 5), jarque_bera(constant), arch_lm(constant, 5)), (None, None, None));
        assert_eq!(durbin_watson(&[&[0.0; 9]]), None);
        assert_eq!(partial_autocorrelation(&[&[1.0, 2.0, 4.0]], 5), None);
        assert_eq!(ljung_box(&[&[1.0, 2.0, 4.0]], 0), None);
        assert_eq!(arch_lm(&[&[1.0, 2.0, 4.0]], 2), None);
    }
}
