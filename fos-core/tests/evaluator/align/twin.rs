//! What a row must hold, computed of whole streams at once: a slow, obvious twin of `fos_core::align`.
#![allow(unreachable_pub)] // a module of a test

use fos_core::Real;
use fos_core::align::{HELD_PERIODS, Held, Interpolated};

/// What a follower with these samples, in order, has at a stamp.
pub fn follower<R: Real>(samples: &[(i64, [R; 3])], period: i64, stamp: i64) -> Interpolated<R> {
    let finite = |values: &[R; 3]| values.iter().all(|value| value.is_finite());
    let sound: Vec<_> = samples.iter().filter(|(_, values)| finite(values)).collect();
    let before = sound.iter().rfind(|(at, _)| *at <= stamp);
    let after = sound.iter().find(|(at, _)| *at >= stamp);
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

/// What a slow channel with these values, in order, has at a stamp.
pub fn slow<R: Real>(values: &[(i64, R)], period: i64, stamp: i64) -> Held<R> {
    let newest = values.iter().rfind(|(at, value)| *at <= stamp && value.is_finite());
    let held = newest.map(|(at, value)| (*value, i128::from(stamp) - i128::from(*at)));
    match held.filter(|(_, age)| *age <= i128::from(HELD_PERIODS) * i128::from(period)) {
        Some((value, age)) => Held { value, age: Some(i64::try_from(age).unwrap_or(i64::MAX)) },
        None => Held { value: R::from_f64(f64::NAN), age: None },
    }
}

/// Values as bits, every NaN alike.
pub fn bits<R: Real>(value: R) -> u64 {
    let value = value.to_f64();
    if value.is_nan() { u64::MAX } else { value.to_bits() }
}

/// Whether two have the same bits.
pub fn same<R: Real>(a: &Interpolated<R>, b: &Interpolated<R>) -> bool {
    a.weight == b.weight && a.values.map(bits) == b.values.map(bits)
}
