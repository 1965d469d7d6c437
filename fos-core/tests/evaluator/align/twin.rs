//! A slow, simple twin of `fos_core::align`, which computes rows from whole streams.
#![allow(unreachable_pub)] // a module of a test

use fos_core::Real;
use fos_core::align::{HELD_PERIODS, Held, Interpolated};

/// Values of a follower with these ordered samples at a timestamp.
pub fn follower<R: Real>(samples: &[(i64, [R; 3])], period: i64, stamp: i64) -> Interpolated<R> {
    let finite = |values: &[R; 3]| values.iter().all(|value| value.is_finite());
    let usable: Vec<_> = samples.iter().filter(|(_, values)| finite(values)).collect();
    let before = usable.iter().rfind(|(at, _)| *at <= stamp);
    let after = usable.iter().find(|(at, _)| *at >= stamp);
    let missing = Interpolated { values: [R::from_f64(f64::NAN); 3], weight: None };
    let (Some((t0, a)), Some((t1, b))) = (before, after) else { return missing };
    if t0 == t1 {
        return Interpolated { values: *a, weight: Some(0) };
    }
    let (part, whole) = (i128::from(stamp) - i128::from(*t0), i128::from(*t1) - i128::from(*t0));
    if 2 * whole > 3 * i128::from(period) {
        return missing;
    }
    let weight = (2 * (part << 24) + whole) / (2 * whole);
    let w = R::from_f64(weight as f64 / f64::from(1 << 24));
    let values = [0, 1, 2].map(|axis| a[axis] + w * (b[axis] - a[axis]));
    if finite(&values) { Interpolated { values, weight: Some(weight as u32) } } else { missing }
}

/// Value of a slow channel with these ordered values at a timestamp.
pub fn slow<R: Real>(values: &[(i64, R)], period: i64, stamp: i64) -> Held<R> {
    let newest = values.iter().rfind(|(at, value)| *at <= stamp && value.is_finite());
    let held = newest.map(|(at, value)| (*value, i128::from(stamp) - i128::from(*at)));
    match held.filter(|(_, age)| *age <= i128::from(HELD_PERIODS) * i128::from(period)) {
        Some((value, age)) => Held { value, age: Some(i64::try_from(age).unwrap_or(i64::MAX)) },
        None => Held { value: R::from_f64(f64::NAN), age: None },
    }
}

/// Bits of a value; every NaN gives the same.
pub fn bits<R: Real>(value: R) -> u64 {
    let value = value.to_f64();
    if value.is_nan() { u64::MAX } else { value.to_bits() }
}

/// True if both have the same bits.
pub fn same<R: Real>(a: &Interpolated<R>, b: &Interpolated<R>) -> bool {
    a.weight == b.weight && a.values.map(bits) == b.values.map(bits)
}
