//! The stillness detector with a phone on a table and in a hand.

use fos_core::{Fixed, Scalar, StillnessDetector, StillnessLimits};
use fos_testkit::models::PERIOD_S;
use fos_testkit::noise::Noise;

/// Standard deviations of one sample of a phone's sensors at 200 Hz: 180 µg/√Hz and 0.007 dps/√Hz over 80 Hz.
const ACCEL_NOISE: f64 = 0.016;
const GYRO_NOISE: f64 = 0.0011;
const DPS: f64 = core::f64::consts::PI / 180.0;
const BIAS: [f64; 3] = [0.4 * DPS, -0.2 * DPS, 0.1 * DPS];
const WINDOW: u32 = 100;

/// Limits: twice the variances of the noise, summed over the axes; rates up to 0.5 dps from the fitted offsets.
fn detector() -> StillnessDetector<f32> {
    detector_with(0.5 * DPS)
}

fn detector_with(gyro_deviation: f64) -> StillnessDetector<f32> {
    let limits = StillnessLimits {
        window: WINDOW as u16,
        accel_variance: 2.0 * 3.0 * ACCEL_NOISE * ACCEL_NOISE,
        gyro_variance: 2.0 * 3.0 * GYRO_NOISE * GYRO_NOISE,
        gyro_at_rest: BIAS,
        gyro_deviation,
    };
    StillnessDetector::new(limits.convert()).unwrap()
}

/// A phone at rest or in motion, with sensor noise and bias.
struct Phone {
    noise: Noise,
    gravity: [f64; 3],
}

impl Phone {
    fn new(seed: u64) -> Self {
        Self { noise: Noise::new(seed), gravity: [0.3, -0.5, 9.78] }
    }

    fn sample(&mut self, accel: [f64; 3], rate: [f64; 3]) -> ([f32; 3], [f32; 3]) {
        let mut force = [0.0; 3];
        let mut turn_rate = [0.0; 3];
        for axis in 0..3 {
            force[axis] = (self.gravity[axis] + accel[axis] + ACCEL_NOISE * self.noise.normal()) as f32;
            turn_rate[axis] = (BIAS[axis] + rate[axis] + GYRO_NOISE * self.noise.normal()) as f32;
        }
        (force, turn_rate)
    }

    /// One sample of rest.
    fn rest(&mut self, detector: &mut StillnessDetector<f32>) -> bool {
        let (accel, gyro) = self.sample([0.0; 3], [0.0; 3]);
        detector.update(accel, gyro)
    }

    /// A detector in the still state.
    fn still_detector(&mut self) -> StillnessDetector<f32> {
        let mut detector = detector();
        let still = (0..5 * WINDOW).map(|_| self.rest(&mut detector)).last();
        assert_eq!(still, Some(true));
        detector
    }
}

#[test]
fn phone_at_rest_is_still_after_two_windows() {
    let (mut detector, mut phone) = (detector(), Phone::new(1));
    for n in 1..=1_000_000 {
        assert_eq!(phone.rest(&mut detector), n >= 2 * WINDOW, "{n}");
    }
}

#[test]
fn phone_in_a_hand_is_never_still() {
    // physiological tremor at 9 Hz, 0.05 m/s² and 1 dps, and a sway of 0.5 Hz
    for seed in 0..5 {
        let (mut detector, mut phone) = (detector(), Phone::new(seed));
        for n in 0..100_000 {
            let t = f64::from(n) * PERIOD_S;
            let tremor = (core::f64::consts::TAU * 9.0 * t).sin();
            let sway = (core::f64::consts::TAU * 0.5 * t).sin();
            let (accel, gyro) =
                phone.sample([0.05 * tremor, 0.1 * sway, 0.0], [DPS * tremor, 2.0 * DPS * sway, 0.0]);
            assert!(!detector.update(accel, gyro), "seed {seed}, sample {n}");
        }
    }
}

#[test]
fn tap_ends_stillness_in_its_first_sample() {
    for (accel, rate) in
        [([0.0, 0.0, 0.5], [0.0; 3]), ([0.5, 0.0, 0.0], [0.0; 3]), ([0.0; 3], [0.0, 2.0 * DPS, 0.0])]
    {
        let mut phone = Phone::new(2);
        let mut detector = phone.still_detector();
        let (accel, gyro) = phone.sample(accel, rate);
        assert!(!detector.update(accel, gyro));
        // still again after two windows
        for n in 1..=2 * WINDOW {
            assert_eq!(phone.rest(&mut detector), n == 2 * WINDOW, "{n}");
        }
    }
}

#[test]
fn picking_up_ends_stillness_within_a_window() {
    let mut phone = Phone::new(2);
    let mut detector = phone.still_detector();
    let first = (0..WINDOW).find(|&n| {
        let t = f64::from(n) * PERIOD_S;
        let (accel, gyro) = phone.sample([0.0, 0.0, 3.0 * t], [0.0, 1.0 * t, 0.0]);
        !detector.update(accel, gyro)
    });
    // 7·√2 of the noise's length, reached at 1 rad/s² after some 20 ms
    assert!(first.is_some_and(|n| n < 10), "{first:?}");
}

#[test]
fn slow_rotation_about_the_vertical_is_never_still() {
    // no variance and no change of gravity: only the distance from the rate at rest shows the motion
    for rate in [2.0 * DPS, -2.0 * DPS, 1.0 * DPS] {
        let (mut detector, mut phone) = (detector(), Phone::new(3));
        for n in 0..200_000 {
            let (accel, gyro) = phone.sample([0.0; 3], [0.0, 0.0, rate]);
            assert!(!detector.update(accel, gyro), "{n}");
        }
    }
}

#[test]
fn start_of_a_rotation_ends_stillness_within_two_windows() {
    for rate in [2.0 * DPS, 1.2 * DPS] {
        let mut phone = Phone::new(4);
        let mut detector = phone.still_detector();
        let still: Vec<bool> = (0..100 * WINDOW)
            .map(|_| {
                let (accel, gyro) = phone.sample([0.0; 3], [0.0, 0.0, rate]);
                detector.update(accel, gyro)
            })
            .collect();
        assert!(still[2 * WINDOW as usize..].iter().all(|still| !still), "{rate}");
    }
}

#[test]
fn rotation_about_a_horizontal_axis_is_never_still() {
    // also with a larger limit on the gyros, because gravity shows the rotation: its mean moves by rate · 0.5 s · 9.81 m/s²
    // from window to window, 0.086 m/s² at 1 dps, against a limit of √(2·3·0.016²) = 0.039 m/s²
    for (rate, gyro_deviation) in [(2.0 * DPS, 0.5 * DPS), (1.0 * DPS, 3.0 * DPS)] {
        let (mut detector, mut phone) = (detector_with(gyro_deviation), Phone::new(5));
        for n in 0..100_000 {
            let angle = rate * f64::from(n) * PERIOD_S;
            phone.gravity = [0.0, 9.81 * angle.sin(), 9.81 * angle.cos()];
            let (accel, gyro) = phone.sample([0.0; 3], [rate, 0.0, 0.0]);
            assert!(!detector.update(accel, gyro), "{rate}: {n}");
        }
    }
}

#[test]
fn tilt_is_motion_and_the_new_orientation_still_again() {
    let mut phone = Phone::new(6);
    let mut detector = phone.still_detector();
    // 1° within half a second
    let mut moved = false;
    for n in 0..WINDOW {
        let angle = DPS * f64::from(n) / f64::from(WINDOW);
        phone.gravity = [0.0, 9.81 * angle.sin(), 9.81 * angle.cos()];
        let (accel, gyro) = phone.sample([0.0; 3], [2.0 * DPS, 0.0, 0.0]);
        moved |= !detector.update(accel, gyro);
    }
    assert!(moved);
    let still: Vec<bool> = (0..4 * WINDOW).map(|_| phone.rest(&mut detector)).collect();
    assert!(still[3 * WINDOW as usize..].iter().all(|still| *still));
}

#[test]
fn bias_drift_with_temperature_stays_still() {
    // 0.02 dps/K over 20 K in an hour: 0.4 dps, within gyro_deviation of 0.5 dps
    let mut phone = Phone::new(7);
    let mut detector = phone.still_detector();
    for n in 0..720_000 {
        let drift = 0.4 * DPS * f64::from(n) / 720_000.0;
        let (accel, gyro) = phone.sample([0.0; 3], [0.0, drift, 0.0]);
        assert!(detector.update(accel, gyro), "{n}");
    }
}

#[test]
fn non_finite_value_is_motion_and_vanishes() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for place in 0..6 {
            let mut phone = Phone::new(8);
            let mut detector = phone.still_detector();
            let (mut accel, mut gyro) = phone.sample([0.0; 3], [0.0; 3]);
            if place < 3 {
                accel[place] = bad
            } else {
                gyro[place - 3] = bad
            }
            assert!(!detector.update(accel, gyro));
            for n in 1..=2 * WINDOW {
                assert_eq!(phone.rest(&mut detector), n == 2 * WINDOW, "{n}");
            }
        }
    }
}

#[test]
fn huge_value_is_motion_and_vanishes() {
    // its square overflows
    for huge in [1e20, -3e38, f32::MAX] {
        let mut phone = Phone::new(9);
        for mut detector in [phone.still_detector(), detector()] {
            let (mut accel, gyro) = phone.sample([0.0; 3], [0.0; 3]);
            accel[1] = huge;
            assert!(!detector.update(accel, gyro));
            // the affected window, and two more
            let still: Vec<bool> = (0..3 * WINDOW).map(|_| phone.rest(&mut detector)).collect();
            assert_eq!(still.last(), Some(&true), "{huge}");
        }
    }
}

#[test]
fn a_saturated_sum_is_motion() {
    // in fixed point a sum of squares saturates at 131,072 (m/s²)²: here it would be less than the square of the mean
    let limits = StillnessLimits {
        window: 1000,
        accel_variance: 0.1,
        gyro_variance: 0.1,
        gyro_at_rest: [0.0; 3],
        gyro_deviation: 0.1,
    };
    let mut detector = StillnessDetector::<Fixed>::new(limits).unwrap();
    for n in 0..3000 {
        let x = if n % 1000 == 0 { -3.0 } else { 9.0 + 0.5 * f64::from(n % 2) };
        let still = detector.update([x, 0.0, 0.0].map(Fixed::from_f64), [Fixed::ZERO; 3]);
        assert!(!still, "{n}");
    }
}

#[test]
fn missing_samples_are_motion() {
    let mut phone = Phone::new(10);
    let mut detector = phone.still_detector();
    assert!(!detector.disturbed());
    for n in 1..=2 * WINDOW {
        assert_eq!(phone.rest(&mut detector), n == 2 * WINDOW, "{n}");
    }
}
