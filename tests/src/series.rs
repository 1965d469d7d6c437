//! Series that are difficult for searches: smooth, flat, coarse, periodic, exact, chaotic, without a mean, of any scale.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Every kind of series, with its name.
pub fn every_kind(n: usize) -> Vec<(String, Vec<f64>)> {
    let white = gaussian(n, 1);
    let mut kinds: Vec<(String, Vec<f64>)> = Vec::new();
    let mut add = |name: &str, values: Vec<f64>| kinds.push((name.to_owned(), values));
    for every in [10, 100, 400] {
        add(&format!("cubic spline of noise, a knot every {every}"), spline(n, every));
    }
    for cut_off in [0.02, 0.05, 0.2] {
        add(&format!("noise through a Butterworth filter at {cut_off}"), butterworth(&white, cut_off));
    }
    let smooth = spline(n, 100);
    add("spline ·1e6", smooth.iter().map(|x| 1e6 * x).collect());
    add("spline ·1e-6", smooth.iter().map(|x| 1e-6 * x).collect());
    add("spline in f32", smooth.iter().map(|x| f64::from(*x as f32)).collect());
    add("spline and a little noise", smooth.iter().zip(&white).map(|(x, e)| x + 1e-6 * e).collect());
    add("flat but for one value", (0..n).map(|k| f64::from(u8::from(k == n / 3))).collect());
    add("two levels", white.iter().map(|e| e.signum()).collect());
    add("three levels", white.iter().map(|e| (0.6 * e).round().clamp(-1.0, 1.0)).collect());
    add("smooth, in steps", smooth.iter().map(|x| (3.0 * x).round()).collect());
    let sine = |period: f64| move |k: usize| (std::f64::consts::TAU * k as f64 / period).sin();
    add("sine", (0..n).map(sine(37.3)).collect());
    add("slow sine", (0..n).map(sine(611.0)).collect());
    let (a, b, c) = (sine(20.0), sine(33.3), sine(7.1));
    add("three sines", (0..n).map(|k| a(k) + b(k) + 0.3 * c(k)).collect());
    add("square wave", (0..n).map(|k| if k / 25 % 2 == 0 { 1.0 } else { -1.0 }).collect());
    add("autoregression without noise", recursion(n, &[1.2, 0.7], |past| 1.999 * past[0] - past[1]));
    add(
        "quadratic recursion without noise",
        recursion(n, &[0.3, 0.1], |p| 1.0 - 1.4 * p[0] * p[0] + 0.3 * p[1]),
    );
    add("logistic map", recursion(n, &[0.1234], |p| 4.0 * p[0] * (1.0 - p[0])));
    add("ramp", (0..n).map(|k| k as f64).collect());
    add("ramp and noise", white.iter().enumerate().map(|(k, e)| 0.01 * k as f64 + e).collect());
    add("parabola", (0..n).map(|k| (k as f64 / n as f64).powi(2)).collect());
    let walk = |step: &f64, sum: &mut f64| {
        *sum += step;
        *sum
    };
    let mut sum = 0.0;
    add("random walk", white.iter().map(|e| walk(e, &mut sum)).collect());
    let (mut sum, mut sum_of_sums) = (0.0, 0.0);
    add("walk of a walk", white.iter().map(|e| walk(&walk(e, &mut sum), &mut sum_of_sums)).collect());
    add("white", white.clone());
    add("white ·1e150", white.iter().map(|e| 1e150 * e).collect());
    add("white ·1e-150", white.iter().map(|e| 1e-150 * e).collect());
    add(
        "white and outliers",
        white.iter().enumerate().map(|(k, e)| if k % 701 == 9 { 1e9 } else { *e }).collect(),
    );
    kinds
}

fn gaussian(n: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
}

/// A uniform cubic B-spline whose control points are noise: consecutive polynomial pieces match up to the second
/// derivative.
fn spline(n: usize, every: usize) -> Vec<f64> {
    let points = gaussian(n / every + 4, 2);
    let at = |k: usize| {
        let (i, x) = (k / every, (k % every) as f64 / every as f64);
        let weights = [
            (1.0 - x).powi(3),
            3.0 * x.powi(3) - 6.0 * x * x + 4.0,
            -3.0 * x.powi(3) + 3.0 * x * x + 3.0 * x + 1.0,
            x.powi(3),
        ];
        points[i..].iter().zip(weights).map(|(point, weight)| point * weight / 6.0).sum()
    };
    (0..n).map(at).collect()
}

/// Butterworth low-pass of order 8, with the cut-off in units of half the sampling rate: four biquads by the bilinear
/// transform.
fn butterworth(series: &[f64], cut_off: f64) -> Vec<f64> {
    let w = (std::f64::consts::FRAC_PI_2 * cut_off).tan();
    let mut filtered = series.to_vec();
    for section in 0..4 {
        let damping = 2.0 * (std::f64::consts::PI * (2.0 * f64::from(section) + 1.0) / 16.0).sin();
        let a0 = 1.0 + damping * w + w * w;
        let (gain, a1, a2) = (w * w / a0, 2.0 * (w * w - 1.0) / a0, (1.0 - damping * w + w * w) / a0);
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        for value in &mut filtered {
            let now = gain * (*value + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
            (x, y) = ([*value, x[0]], [now, y[0]]);
            *value = now;
        }
    }
    filtered
}

/// Series that continues `first` by `next`, a function of its past values, latest first.
fn recursion(n: usize, first: &[f64], next: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut series = first.to_vec();
    while series.len() < n {
        let past: Vec<f64> = series.iter().rev().take(first.len()).copied().collect();
        series.push(next(&past));
    }
    series
}
