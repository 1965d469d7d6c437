use super::*;
use crate::recording::{LoadOptions, Source};
use fos_testkit::noise::{random_walk, white_noise};

const RATE_HZ: f64 = 200.0;

/// Six axes of noise over `n` rows, each passed through `shape`.
fn at_rest(seed: u64, n: usize, shape: impl Fn(usize, &mut [f64])) -> Vec<(String, Vec<f64>)> {
    AXES.into_iter()
        .enumerate()
        .map(|(axis, name)| {
            let mut values: Vec<f64> = white_noise(seed * 10 + axis as u64, n);
            let walk = random_walk(seed * 10 + 1000 + axis as u64, n);
            values.iter_mut().zip(&walk).for_each(|(value, walk)| *value += 0.003 * walk);
            shape(axis, &mut values);
            let scale = if axis < 3 { 0.01 } else { 0.001 };
            (name.to_owned(), values.into_iter().map(|value| scale * value).collect())
        })
        .collect()
}

fn found(columns: Vec<(String, Vec<f64>)>) -> Vec<Disturbance> {
    let options = LoadOptions { rate_hz: Some(RATE_HZ), ..LoadOptions::default() };
    let recording = Recording::from_columns(Source::made_by("test"), columns, &options).unwrap();
    let rest = vec![true; recording.n_rows()];
    find(&recording, &rest)
}

#[test]
fn noise_of_any_kind_is_no_motion() {
    let n = 120_000;
    for seed in 0..4 {
        let heavy = |_: usize, values: &mut [f64]| values.iter_mut().for_each(|value| *value *= value.abs());
        let coarse =
            |_: usize, values: &mut [f64]| values.iter_mut().for_each(|value| *value = value.round());
        let smooth = |_: usize, values: &mut [f64]| {
            (1..values.len()).for_each(|row| values[row] = 0.9 * values[row - 1] + 0.3 * values[row]);
        };
        // bursts of one axis: electrical
        let bursts = |axis: usize, values: &mut [f64]| {
            if axis == 2 {
                (50_000..50_400).for_each(|row| values[row] *= 20.0);
            }
        };
        // the noise of all axes rises slowly
        let louder = |_: usize, values: &mut [f64]| {
            values.iter_mut().enumerate().for_each(|(row, value)| *value *= 1.0 + row as f64 / n as f64);
        };
        // all drift with the temperature
        let drift = |axis: usize, values: &mut [f64]| {
            let size = 10.0 * (axis as f64 + 1.0);
            values
                .iter_mut()
                .enumerate()
                .for_each(|(row, value)| *value += size * (row as f64 / 30_000.0).sin());
        };
        let kinds: [(&str, &Shape<'_>); 7] = [
            ("plain", &|_, _| {}),
            ("heavy", &heavy),
            ("coarse", &coarse),
            ("smooth", &smooth),
            ("bursts", &bursts),
            ("louder", &louder),
            ("drift", &drift),
        ];
        for (name, shape) in kinds {
            let left_out: Vec<Disturbance> =
                found(at_rest(seed, n, shape)).into_iter().filter(Disturbance::is_excluded).collect();
            assert_eq!(left_out, [], "{name}, seed {seed}");
        }
    }
}

/// Addition to the values of an axis.
type Shape<'a> = dyn Fn(usize, &mut [f64]) + 'a;

/// A damped sine on several axes.
fn knock(size: f64, at: usize) -> impl Fn(usize, &mut [f64]) {
    move |axis, values| {
        let share = [1.0, 0.6, -0.4, 0.3, 0.2, -0.5][axis];
        for (since, value) in values[at..at + 60].iter_mut().enumerate() {
            let t = since as f64 / RATE_HZ;
            *value += size * share * (-t / 0.08).exp() * (std::f64::consts::TAU * 23.0 * t).cos();
        }
    }
}

#[test]
fn finds_a_knock_of_any_size_at_its_position() {
    for size in [15.0, 100.0, 3000.0] {
        let found = found(at_rest(7, 60_000, knock(size, 30_000)));
        assert_eq!(found.len(), 1, "{size}: {found:?}");
        assert!(found[0].rows.contains(&30_000) && found[0].rows.contains(&30_020), "{size}: {found:?}");
        assert!(found[0].rows.len() < 400, "{size}: {found:?}");
        assert_eq!((found[0].kind, found[0].is_tilted), (Kind::Knock, false), "{size}");
    }
}

#[test]
fn handling_rotates_and_tilts_the_device() {
    let (from, to) = (30_000, 31_200);
    let shape = |axis: usize, values: &mut [f64]| {
        for (since, value) in values[from..].iter_mut().enumerate() {
            let x = (since as f64 / (to - from) as f64).min(1.0);
            let tilt = 0.5 - 0.5 * (std::f64::consts::PI * x).cos();
            // in multiples of the noise: 1 m/s² along two axes; 0.5 rad about one
            match axis {
                0 => *value += 100.0 * tilt,
                2 => *value -= 60.0 * tilt,
                4 if since < to - from => {
                    *value += 500.0 * 0.5 * std::f64::consts::PI * (std::f64::consts::PI * x).sin() / 6.0;
                }
                _ => {}
            }
        }
    };
    let found = found(at_rest(8, 60_000, shape));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].kind, found[0].is_tilted), (Kind::Handling, true), "{found:?}");
    assert!(found[0].rows.start < 30_100 && found[0].rows.end > 31_100, "{found:?}");
}

#[test]
fn lasting_vibration_is_a_state_and_sway_is_motion() {
    let machine = |axis: usize, values: &mut [f64]| {
        let share = 4.0 / (1.0 + axis as f64);
        (20_000..50_000).for_each(|row| values[row] += share * (row as f64 * 1.3).sin());
    };
    let found_of_machine = found(at_rest(9, 60_000, machine));
    assert!(found_of_machine.iter().any(|one| one.kind == Kind::Vibration && one.rows.len() > 20_000));
    let left_out: usize =
        found_of_machine.iter().filter(|one| one.is_excluded()).map(|one| one.rows.len()).sum();
    assert!(left_out < 4000, "{found_of_machine:?}");

    let sway = |axis: usize, values: &mut [f64]| {
        let share = [0.5, 0.4, 0.1, 0.2, 0.3, 0.0][axis];
        let angle = |row: usize| std::f64::consts::TAU * 0.2 * row as f64 / RATE_HZ;
        (60_000..120_000).for_each(|row| values[row] += share * angle(row).sin());
    };
    let found_of_sway = found(at_rest(10, 240_000, sway));
    let left_out: usize =
        found_of_sway.iter().filter(|one| one.is_excluded()).map(|one| one.rows.len()).sum();
    assert!((45_000..75_000).contains(&left_out), "{found_of_sway:?}");
}

#[test]
fn one_axis_alone_shows_no_motion() {
    let mut columns = at_rest(11, 20_000, knock(1000.0, 10_000));
    columns.truncate(1);
    assert!(found(columns).is_empty());
}

#[test]
fn finds_handling_next_to_a_longer_motion() {
    let n = 30_000;
    let handled = 7_000..7_800;
    let shape = |_: usize, values: &mut [f64]| {
        values[handled.clone()].iter_mut().for_each(|value| *value *= 3.0);
        let swing = |row: usize| 1000.0 * (row as f64 / 60.0).sin();
        (8_000..26_000).for_each(|row| values[row] += swing(row));
    };
    let all = found(at_rest(3, n, shape));
    let is_covered = |row: usize| all.iter().any(|one| one.is_excluded() && one.rows.contains(&row));
    assert!(handled.clone().step_by(100).all(is_covered), "{all:?}");
    assert!(is_covered(17_000) && !is_covered(3_000) && !is_covered(29_000), "{all:?}");
}
