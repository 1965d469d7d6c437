//! The monitor: false alarms, detection delays, and its statistics.

use fos_core::{AxisParameters, Correction, InnovationStatistics, ModelError, Monitor, Real, Validity};
use fos_testkit::models::{OwnedModel, PERIOD_S, plain};
use fos_testkit::noise::Noise;

const SCALE: f64 = 0.02;
const MEAN: f64 = 0.1;
const VARIANCE: f64 = 0.4;

fn monitor<R: Real>(lag_1_correlation: f64) -> Monitor<R> {
    let innovation = InnovationStatistics { mean: MEAN, variance: VARIANCE, lag_1_correlation };
    let parameters: AxisParameters<f64> = AxisParameters { scale: SCALE, innovation, ..plain() };
    Monitor::new(&parameters.convert(), PERIOD_S)
}

/// A correction whose innovation is `deviations` standard deviations of the fit from its mean.
fn correction<R: Real>(deviations: f64) -> Correction<R> {
    let innovation = SCALE * (MEAN + VARIANCE.sqrt() * deviations);
    Correction {
        predicted: R::ZERO,
        innovation: Some(R::from_f64(innovation)),
        corrected: R::ZERO,
        validity: Validity::VALID,
    }
}

#[test]
fn white_innovations_raise_no_alarm() {
    // one false alarm in some 2·10⁹ samples of the mean and 10⁹ of the power: 1.2·10⁷ samples show one with 2 %
    for seed in 100..106 {
        let (mut monitor, mut noise) = (monitor::<f32>(0.0), Noise::new(seed));
        for n in 0..2_000_000 {
            let drift = monitor.update(&correction(noise.normal()));
            assert!(!drift.mean && !drift.variance, "seed {seed}, sample {n}: {drift:?}");
        }
    }
}

#[test]
fn innovations_correlated_as_in_the_fit_raise_no_alarm() {
    for correlation in [-0.5_f64, 0.5, 0.8] {
        for seed in 0..2 {
            let (mut monitor, mut noise) = (monitor::<f32>(correlation), Noise::new(seed));
            let mut e = 0.0;
            for n in 0..1_000_000 {
                e = correlation * e + (1.0 - correlation * correlation).sqrt() * noise.normal();
                let drift = monitor.update(&correction(e));
                assert!(!drift.mean && !drift.variance, "{correlation}, seed {seed}, sample {n}: {drift:?}");
            }
        }
    }
}

/// Sorted numbers of samples until `found`, after 20,000 undisturbed ones, over 50 seeds.
fn delays(mut changed: impl FnMut(f64) -> f64, found: impl Fn(fos_core::Drift) -> bool) -> Vec<u32> {
    let mut delays: Vec<u32> = (0..50)
        .map(|seed| {
            let (mut monitor, mut noise) = (monitor::<f32>(0.0), Noise::new(seed));
            for _ in 0..20_000 {
                let _ = monitor.update(&correction(noise.normal()));
            }
            (1..10_000)
                .find(|_| found(monitor.update(&correction(changed(noise.normal())))))
                .unwrap_or(10_000)
        })
        .collect();
    delays.sort();
    delays
}

#[test]
fn a_shift_of_half_a_standard_deviation_is_found_in_about_160_samples() {
    for sign in [1.0, -1.0] {
        let delays = delays(|e| e + sign * 0.5, |drift| drift.mean);
        // h/(shift − k) = 40/0.25; the standard deviation of the sum is then √160/0.25 = 51 samples: 5 of them on either side
        assert!((120..200).contains(&delays[25]), "{delays:?}");
        assert!(delays[0] > 40 && delays[49] < 420, "{delays:?}");
    }
}

#[test]
fn a_doubled_variance_is_found_in_about_120_samples() {
    let delays = delays(|e| 2.0_f64.sqrt() * e, |drift| drift.variance);
    // h/(2 − 1.5) = 60/0.5, slightly more because a square is limited to 16; standard deviation √(120·8)/0.5 = 62 samples
    assert!((85..165).contains(&delays[25]), "{delays:?}");
    assert!(delays[49] < 450, "{delays:?}");
}

#[test]
fn a_single_outlier_is_no_drift() {
    // without a limit on the sum of the mean, one innovation of 41 standard deviations would be a shift of the mean
    for outlier in [41.0, -41.0, 1e3, 1e9, f64::from(f32::MAX)] {
        let (mut monitor, mut noise) = (monitor::<f32>(0.0), Noise::new(1));
        for n in 0..20_000 {
            let e = if n == 10_000 { outlier } else { noise.normal() };
            let drift = monitor.update(&correction(e));
            assert!(!drift.mean && !drift.variance, "{outlier}, sample {n}: {drift:?}");
        }
    }
}

fn assert_running_statistics_match_the_data<R: Real>() {
    let (rho, shift, growth) = (0.6_f64, 0.2, 1.3);
    let (mut monitor, mut noise) = (monitor::<R>(0.0), Noise::new(4));
    let (mut e, mut sums) = (0.0, [0.0; 3]);
    let samples = 400_000;
    for n in 0..samples {
        e = rho * e + (1.0 - rho * rho).sqrt() * noise.normal();
        let _ = monitor.update(&correction(shift + growth * e));
        if n >= samples / 2 {
            let now = monitor.statistics();
            let values = [now.mean, now.variance, now.lag_1_correlation];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value.to_f64());
        }
    }
    let [mean, variance, correlation] = sums.map(|sum| 2.0 * sum / f64::from(samples));
    // 2·10⁵ samples; the mean of an AR(1) has (1+ρ)/(1−ρ) = 4 times the variance, of its square 2(1+ρ²)/(1−ρ²) = 4.25:
    // standard errors 0.0045·1.3·√0.4 = 0.0037, 0.0046·1.69·0.4 = 0.0031, 0.0018. Four of each; the exponential
    // window takes gain/2·(1+ρ)/(1−ρ) = 0.03 % of the variance
    let truth = [MEAN + VARIANCE.sqrt() * shift, VARIANCE * growth * growth, rho];
    assert!((mean - truth[0]).abs() < 0.015, "{mean} {truth:?}");
    assert!((variance - truth[1]).abs() < 0.013, "{variance} {truth:?}");
    assert!((correlation - truth[2]).abs() < 0.0075, "{correlation} {truth:?}");
    assert!((monitor.mean_in_unit() - SCALE * monitor.statistics().mean.to_f64()).abs() < 1e-9);
    assert_eq!(monitor.samples(), 400_000);
}

#[test]
fn running_statistics_match_the_data_in_f32() {
    assert_running_statistics_match_the_data::<f32>();
}

#[test]
fn running_statistics_match_the_data_in_f64() {
    assert_running_statistics_match_the_data::<f64>();
}

#[test]
fn deviation_ratio_is_the_growth_of_the_noise() {
    // error bound of the square root with and without the feature: docs/decisions/micromath.md
    let budget = if cfg!(feature = "micromath") { 0.0607 } else { 6.0e-8 };
    for growth in [0.1, 1.0, 2.0, 30.0] {
        let (mut monitor, mut noise) = (monitor::<f32>(0.0), Noise::new(7));
        assert!((f64::from(monitor.deviation_ratio()) - 1.0).abs() <= budget, "as fitted unless set");
        // ten time constants: the initial value of 1 has decayed
        for _ in 0..60_000 {
            let _ = monitor.update(&correction(growth * noise.normal()));
        }
        let ratio = f64::from(monitor.deviation_ratio());
        // 2·30 s of memory are 12,000 samples: standard error √(1/24,000) = 0.65 %; four of it
        assert!((ratio / growth - 1.0).abs() < 0.026 + budget, "{growth}: {ratio}");
        let exact = (f64::from(monitor.statistics().variance) / VARIANCE).sqrt();
        assert!((ratio / exact - 1.0).abs() < budget + 1e-6, "{growth}: {ratio} {exact}");
        let in_unit = f64::from(monitor.deviation_in_unit());
        assert!((in_unit / (ratio * SCALE * VARIANCE.sqrt()) - 1.0).abs() < 1e-6, "{growth}: {in_unit}");
    }
}

#[test]
fn effect_of_a_fault_on_the_statistics_decays_with_their_time_constant() {
    // a difference of `off` has decayed to 10⁻³ after 30 s·ln(off/10⁻³), in deviations and variances of the fit
    let (near, samples_per_tau) = (1e-3, 30.0 / PERIOD_S);
    let mut longest = 0;
    for lasts in [1, 60, 2000] {
        for size in [4.0, 1e3, f64::from(f32::MAX)] {
            let (mut clean, mut faulty, mut noise) =
                (monitor::<f32>(0.0), monitor::<f32>(0.0), Noise::new(9));
            for _ in 0..lasts {
                let e = noise.normal();
                let _ = (clean.update(&correction(e)), faulty.update(&correction(e + size)));
            }
            let differences = |clean: &Monitor<f32>, faulty: &Monitor<f32>| {
                let (clean, faulty) = (clean.statistics(), faulty.statistics());
                let mean = f64::from(faulty.mean - clean.mean).abs() / VARIANCE.sqrt();
                let variance = f64::from(faulty.variance - clean.variance).abs() / VARIANCE;
                [mean, variance, f64::from(faulty.lag_1_correlation - clean.lag_1_correlation).abs()]
            };
            let [mean, variance, _] = differences(&clean, &faulty);
            // a wrong mean enters the variance with its square and with its product with the noise
            let off = variance + mean * mean + mean;
            let samples = (samples_per_tau * (off / near).ln()).ceil() as u32;
            for _ in 0..samples {
                let e = correction(noise.normal());
                let _ = (clean.update(&e), faulty.update(&e));
            }
            let left = differences(&clean, &faulty);
            // every step is rounded to 10⁻⁴ of itself, so 26 time constants may take 1 % longer; a correlation has the
            // errors of both terms of its ratio
            assert!(
                left.iter().zip([1.0, 1.0, 2.0]).all(|(left, of)| *left <= 1.01 * of * near),
                "{lasts} samples of {size}: {left:?} after {samples}"
            );
            longest = longest.max(samples);
        }
    }
    // 10 s at the largest innovation that a monitor counts
    assert!(longest < 200_000, "{longest}");
    println!("longest: {longest} samples");
}

#[test]
fn ignores_non_finite_innovations() {
    let (mut clean, mut poisoned, mut noise) = (monitor::<f32>(0.0), monitor::<f32>(0.0), Noise::new(1));
    for n in 0..1000 {
        if n % 10 == 0 {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let drift = poisoned.update(&Correction { innovation: Some(bad), ..correction(0.0) });
                assert_eq!(drift, poisoned.drift());
            }
        }
        let e = correction(noise.normal());
        let _ = (clean.update(&e), poisoned.update(&e));
    }
    assert_eq!(poisoned.statistics(), clean.statistics());
    assert_eq!((poisoned.samples(), poisoned.drift()), (clean.samples(), clean.drift()));
}

#[test]
fn ignores_absent_innovations_and_own_history() {
    let mut monitor = monitor::<f32>(0.0);
    for _ in 0..1000 {
        let _ = monitor.update(&Correction { validity: Validity::OWN_HISTORY, ..correction(5.0) });
        let _ = monitor.update(&Correction { innovation: None, ..correction(5.0) });
    }
    assert_eq!((monitor.samples(), monitor.drift()), (0, fos_core::Drift::default()));
}

#[test]
fn alarm_stays_until_restart() {
    let mut monitor = monitor::<f32>(0.0);
    for _ in 0..500 {
        let _ = monitor.update(&correction(1.0));
    }
    for _ in 0..5000 {
        assert!(monitor.update(&correction(0.0)).mean);
    }
    monitor.restart();
    for _ in 0..5000 {
        assert!(!monitor.update(&correction(0.0)).mean);
    }
}

/// All numbers that a monitor returns.
fn numbers<R: Real>(monitor: &Monitor<R>) -> [f64; 6] {
    let InnovationStatistics { mean, variance, lag_1_correlation } = monitor.statistics();
    [
        mean.to_f64(),
        variance.to_f64(),
        lag_1_correlation.to_f64(),
        monitor.mean_in_unit(),
        monitor.deviation_ratio().into(),
        monitor.deviation_in_unit().into(),
    ]
}

/// A number of any magnitude and sign, or NaN.
fn any_number(noise: &mut Noise) -> f64 {
    let sign = if noise.uniform() < 0.5 { -1.0 } else { 1.0 };
    match noise.bits() % 16 {
        0 => f64::NAN,
        1 => sign * f64::INFINITY,
        2 => 0.0,
        3 => sign * f64::from(f32::MAX),
        4..10 => sign * noise.normal(),
        _ => sign * 10.0_f64.powf(80.0 * noise.uniform() - 42.0),
    }
}

/// Draws parameters over the whole range of R. Counts accepted models, rejected ones, and rejected ones whose monitor would
/// have returned a number that is not finite.
fn count_finite_statistics<R: Real>(seed: u64) -> [u32; 3] {
    let mut noise = Noise::new(seed);
    let (mut models, mut refused, mut would_overflow) = (0, 0, 0);
    while models < 2000 {
        let magnitude =
            |noise: &mut Noise, low: f64, high: f64| 10.0_f64.powf(low + (high - low) * noise.uniform());
        let innovation = InnovationStatistics {
            mean: any_number(&mut noise),
            variance: magnitude(&mut noise, -44.0, 38.0),
            lag_1_correlation: 2.0 * noise.uniform() - 1.0,
        };
        let scale = magnitude(&mut noise, -12.0, 25.0);
        let parameters: AxisParameters<f64> = AxisParameters { scale, innovation, ..plain() };
        let model = OwnedModel::autoregressive(parameters.convert::<R>(), vec![]);
        let is_refused = match model.predictor() {
            Ok(_) => false,
            Err(ModelError::Innovation { axis: 0 } | ModelError::AxisParameter { axis: 0 }) => true,
            // the scale has a separate bound
            Err(ModelError::Unbounded { axis: 0 }) => continue,
            Err(error) => panic!("{error}: {parameters:?}"),
        };
        let mut monitor = Monitor::new(&model.axes[0].parameters, PERIOD_S);
        let mut all_finite = true;
        let mut given = Vec::new();
        for _ in 0..50 {
            let unit = scale * innovation.variance.sqrt();
            let innovation = any_number(&mut noise) * if noise.uniform() < 0.5 { unit } else { 1.0 };
            given.push(innovation);
            let _ =
                monitor.update(&Correction { innovation: Some(R::from_f64(innovation)), ..correction(0.0) });
            all_finite &= numbers(&monitor).into_iter().all(f64::is_finite);
        }
        if is_refused {
            refused += 1;
            would_overflow += u32::from(!all_finite);
        } else {
            models += 1;
            assert!(all_finite, "{:?}: {parameters:?}, {given:?}", numbers(&monitor));
        }
    }
    [models, refused, would_overflow]
}

#[test]
fn statistics_are_finite_for_any_model_and_innovations() {
    let [models, refused, control] = count_finite_statistics::<f32>(11);
    let [in_f64, refused_in_f64, _] = count_finite_statistics::<f64>(12);
    assert!(control > 0, "the same check without the refusal finds nothing: {refused} refused");
    println!(
        "attack: statistics of the monitor | {} models whose means, variances and scales span all of f32, each with 50 innovations of arbitrary bits in f32 and f64: every statistic is finite; {} more models are refused when they are built | negative control: without that refusal, {control} of {refused} produce values that are not finite",
        models + in_f64,
        refused + refused_in_f64
    );
}

#[test]
fn rejects_models_whose_monitor_would_overflow() {
    let built = |mean: f32, variance: f32, scale: f32| {
        let innovation = InnovationStatistics { mean, variance, lag_1_correlation: 0.0 };
        let parameters = AxisParameters { scale, innovation, ..plain() };
        OwnedModel::autoregressive(parameters, vec![]).predictor().err()
    };
    // the running mean would be infinite from the first sample on
    for (mean, variance, scale) in
        [(1e30, 1e-20, 1.0), (-1e30, 0.4, 1.0), (0.0, 1e30, 1.0), (0.0, 1e-40, 1.0), (0.0, 1.0, 1e-25)]
    {
        assert_eq!(
            built(mean, variance, scale),
            Some(ModelError::Innovation { axis: 0 }),
            "{mean} {variance} {scale}"
        );
    }
    // typical results of fits, also on data without noise
    for (mean, variance, scale) in
        [(0.0, 1.0, 1.0), (0.1, f32::MIN_POSITIVE, 1e-3), (1e-4, 2e-6, 0.02), (3.0, 1e3, 40.0)]
    {
        assert_eq!(built(mean, variance, scale), None, "{mean} {variance} {scale}");
    }
}
