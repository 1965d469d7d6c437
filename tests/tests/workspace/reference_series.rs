//! Series of `tests/fixtures/reference`, computed from their seeds and compared with the stored ones.

use std::fs;
use std::path::Path;

use fos_testkit::noise::{autoregression, random_walk, white_noise};
use fos_testkit::reference;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Series of a fixture: its channels, and the value of one step of its codes if it is stored in 16 bits.
struct Series {
    name: &'static str,
    channels: Vec<Vec<f64>>,
    lsb: Option<Vec<f64>>,
}

fn all() -> Vec<Series> {
    let of = |name, channels| Series { name, channels, lsb: None };
    let mut all = vec![
        // two damped resonances: poles of radius 0.95 and 0.8
        of("autoregression", vec![autoregression(1, 256, &[1.362, -1.2193, 0.8176, -0.5776], 1.0)]),
        of("autoregression_with_mean", vec![with_mean()]),
        of("selection", vec![quadratic(4, 2000)]),
        of("gaps", vec![with_holes(quadratic(5, 1500))]),
        of("prediction", vec![quadratic(6, 500)]),
        of("residuals", vec![residuals()]),
        of("allan", vec![sum(&white_noise(8, 1000), 0.05, &random_walk(9, 1000))]),
        of("wavelet", vec![steps()]),
        of("spectrum", vec![sum(&autoregression(11, 700, &[0.9, -0.5], 1.0), 1.0, &sine(700, 0.13))]),
    ];
    let (cubic, products, bilinear) = (uniform(12, -1.0), uniform(13, -1.0), uniform(14, -1.0));
    let exact = uniform(15, 0.0);
    all.push(of(
        "narx_cubic",
        narx(cubic, 0.01, 16, |y, x| 0.7 * y[0] + 0.5 * x[1] + 0.3 * x[1] * x[1] - 0.6 * x[1].powi(3)),
    ));
    all.push(of(
        "narx_products",
        narx(products, 0.01, 17, |y, x| {
            0.3 * y[0].powi(3) + 0.6 * y[0] * x[1] + 0.5 * x[2] * x[2] - 0.8 * y[1] * x[2] * x[2] - 0.4 * y[1]
        }),
    ));
    all.push(of(
        "narx_bilinear",
        narx(bilinear, 0.05, 18, |y, x| 0.3 * y[0] + 0.2 * y[0] * x[1] + 0.8 * x[2]),
    ));
    // exact, without noise: 17 digits must be recovered
    all.push(of(
        "narx_exact",
        narx(exact, 0.0, 19, |y, x| {
            0.9 + 0.15 * y[0] + 0.25 * x[2] * x[3] - 0.3 * y[1] * x[1] - 0.95 * x[0] - 0.04 * y[0] * y[1]
        }),
    ));
    all.extend(effects());
    all
}

fn sum(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

fn sine(length: usize, cycles_per_sample: f64) -> Vec<f64> {
    (0..length).map(|n| (std::f64::consts::TAU * cycles_per_sample * n as f64).sin()).collect()
}

/// A slow resonance about a mean that is much larger.
fn with_mean() -> Vec<f64> {
    autoregression(20, 300, &[1.4, -0.7], 1.0).iter().map(|x| 50.0 + 10.0 * x).collect()
}

/// Four lags, two products that are difficult for a search (each resembles others), and noise: the subject of the
/// fixtures `selection`, `gaps` and `prediction`.
fn quadratic(seed: u64, length: usize) -> Vec<f64> {
    let run_in = 500;
    let mut y = white_noise(seed, run_in + length);
    for n in 4..y.len() {
        y[n] = 1.5 * y[n - 1] - 0.85 * y[n - 2] + 0.35 * y[n - 3] - 0.1 * y[n - 4]
            + 0.04 * y[n - 1] * y[n - 2]
            - 0.05 * y[n - 3] * y[n - 3]
            + 0.2 * y[n];
    }
    y.split_off(run_in)
}

/// Gaps at the start, of a single sample, and shorter and longer than the lags.
fn with_holes(mut series: Vec<f64>) -> Vec<f64> {
    for hole in [0..2, 300..420, 700..701, 703..705, 900..911] {
        series[hole].fill(f64::NAN);
    }
    series
}

/// Residuals with a short memory and with bursts, so that every whiteness test has a result.
fn residuals() -> Vec<f64> {
    let noise = white_noise(7, 1501);
    let mut x = vec![noise[0]];
    for n in 1..noise.len() {
        let spread = (0.7 + 0.2 * x[n - 1] * x[n - 1]).sqrt();
        x.push(0.1 * x[n - 1] + spread * noise[n]);
    }
    x.split_off(1)
}

/// A slow sine, a step and noise, of a length that is no power of two.
fn steps() -> Vec<f64> {
    let noise = white_noise(10, 250);
    let slow = sine(250, 0.01);
    (0..250).map(|n| slow[n] + if n < 140 { 0.0 } else { 1.5 } + 0.2 * noise[n]).collect()
}

fn uniform(seed: u64, low: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..800).map(|_| random.random_range(low..1.0)).collect()
}

/// Input and output of a system that begins at rest: `next` is a function of the past outputs, latest first, and of the
/// inputs, the present one first.
fn narx(input: Vec<f64>, noise: f64, seed: u64, next: impl Fn(&[f64; 2], &[f64; 4]) -> f64) -> Vec<Vec<f64>> {
    let added = white_noise(seed, input.len());
    let mut output = vec![0.0; input.len()];
    for n in 4..input.len() {
        let inputs = std::array::from_fn(|lag| input[n - lag]);
        output[n] = next(&[output[n - 1], output[n - 2]], &inputs) + noise * added[n];
    }
    vec![input, output]
}

/// A gyro with a memory, and four channels logged with it: one of them shifts it, the same noise in all three.
fn effects() -> Vec<Series> {
    const N: usize = 6000;
    let of_unit_size = |seed, ar: &[f64], variance| autoregression(seed, N, ar, variance);
    let temperature: Vec<f64> = sum(&sine(N, 0.8 / N as f64), 0.1, &of_unit_size(21, &[0.999], 0.002));
    let temperature: Vec<f64> = temperature.iter().map(|x| 30.0 + 6.0 * x).collect();
    // resonates like a hull, louder in the middle
    let shaken = of_unit_size(22, &[1.2, -0.8], 0.2);
    let loudness: Vec<f64> = sine(N, 0.5 / N as f64).iter().map(|x| 0.3 + x).collect();
    let acceleration: Vec<f64> = shaken.iter().zip(&loudness).map(|(x, loud)| x * loud).collect();
    let supply: Vec<f64> = of_unit_size(23, &[0.995], 0.01).iter().map(|x| 3.3 + 0.02 * x).collect();
    let magnetic: Vec<f64> = of_unit_size(24, &[0.98], 0.04);
    let lsb =
        vec![2.0_f64.powi(-12), 2.0_f64.powi(-8), 2.0_f64.powi(-10), 2.0_f64.powi(-12), 2.0_f64.powi(-10)];
    let codes =
        |values: Vec<f64>, lsb: f64| -> Vec<f64> { values.iter().map(|x| (x / lsb).round() * lsb).collect() };
    let others = [temperature, acceleration, supply, magnetic];
    let others: Vec<Vec<f64>> = others.into_iter().zip(&lsb[1..]).map(|(x, lsb)| codes(x, *lsb)).collect();
    let noise = white_noise(25, N);
    let shifted = |name, effect: &dyn Fn(usize) -> f64| {
        let mut y = vec![0.0; N];
        for n in 2..N {
            y[n] = 0.5 * y[n - 1] + 0.2 * y[n - 2] + effect(n) + 0.02 * noise[n];
        }
        let mut channels = vec![codes(y, lsb[0])];
        channels.extend(others.iter().cloned());
        Series { name, channels, lsb: Some(lsb.clone()) }
    };
    vec![
        shifted("effect_temp_linear", &|n| 0.001 * (others[0][n] - 30.0)),
        shifted("effect_supply_sensitivity", &|n| 0.3 * (others[2][n.saturating_sub(3)] - 3.3)),
        shifted("effect_vibration_rectification", &|n| 0.005 * others[1][n].powi(2)),
    ]
}

#[test]
fn stored_series_match_their_seeds() {
    for Series { name, channels, .. } in all() {
        let stored = reference::own(name);
        assert_eq!(stored.channels.len(), channels.len(), "{name}");
        for (stored, made) in stored.channels.iter().zip(&channels) {
            assert_eq!(stored.len(), made.len(), "{name}");
            for (n, (stored, made)) in stored.iter().zip(made).enumerate() {
                // logarithms and sines of another system may differ in their last digit
                let same =
                    (stored - made).abs() <= 1e-12 * (1.0 + made.abs()) || stored.is_nan() && made.is_nan();
                assert!(same, "{name} [{n}]: {stored} for {made}");
            }
        }
    }
}

/// Writes the series; then `tests/fixtures/reference/make.py` computes the answers again.
#[test]
#[ignore = "writes the fixtures"]
fn make() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/reference");
    for Series { name, channels, lsb } in all() {
        let values = || channels.iter().flatten();
        match lsb {
            None => {
                let bytes: Vec<u8> = values().flat_map(|value| value.to_le_bytes()).collect();
                fs::write(folder.join(name).with_extension("f64"), bytes).unwrap();
            }
            Some(lsb) => {
                let code = |(value, lsb): (&f64, &f64)| (value / lsb).round() as i16;
                let bytes = channels.iter().zip(&lsb).flat_map(|(channel, lsb)| {
                    channel.iter().flat_map(move |value| code((value, lsb)).to_le_bytes())
                });
                fs::write(folder.join(name).with_extension("i16"), bytes.collect::<Vec<u8>>()).unwrap();
            }
        }
    }
}
