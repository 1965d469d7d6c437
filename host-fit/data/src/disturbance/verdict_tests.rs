//! Classes of logs and the properties that hold for all of them: a step explained by a logged channel is no motion,
//! leading rows have no influence, and a vehicle has no rest. Each check has a control that breaks the property on
//! purpose.

use super::*;
use crate::recording::{LoadOptions, Source};
use fos_testkit::noise::{random_walk, white_noise};

const RATE_HZ: f64 = 50.0;

/// White noise of each axis, and its share of a common step.
const DEVIATION: [f64; 6] = [0.012, 0.012, 0.012, 0.0015, 0.0015, 0.0015];
const SHARE: [f64; 6] = [8.0, -5.6, 4.0, 1.0, 0.8, -0.6];

/// Seconds from one change of a channel to the next.
const EVERY_S: f64 = 50.0;

#[derive(Clone)]
struct Log {
    columns: Vec<(String, Vec<f64>)>,
}

impl Log {
    /// White noise and a little random walk on all axes, gravity on z.
    fn at_rest(seed: u64, seconds: f64) -> Self {
        let n = (seconds * RATE_HZ) as usize;
        let axis = |axis: usize| {
            let (white, walk) =
                (white_noise(seed * 10 + axis as u64, n), random_walk(seed * 10 + 1000 + axis as u64, n));
            let level = if axis == 2 { 9.81 } else { 0.0 };
            let values = white.iter().zip(&walk).map(|(w, r)| level + DEVIATION[axis] * (w + 0.003 * r));
            (AXES[axis].to_owned(), values.collect())
        };
        Self { columns: (0..6).map(axis).collect() }
    }

    fn n(&self) -> usize {
        self.columns[0].1.len()
    }

    /// Adds to each axis its share of `of`, a function of axis and time in s.
    fn add(mut self, of: impl Fn(usize, f64) -> f64) -> Self {
        for (axis, (_, values)) in self.columns.iter_mut().take(6).enumerate() {
            values.iter_mut().enumerate().for_each(|(row, value)| *value += of(axis, row as f64 / RATE_HZ));
        }
        self
    }

    fn with(mut self, name: &str, of: impl Fn(f64) -> f64) -> Self {
        let noise = white_noise(name.len() as u64, self.n());
        let values =
            noise.iter().enumerate().map(|(row, noise)| of(row as f64 / RATE_HZ) * (1.0 + 3e-4 * noise));
        self.columns.push((name.to_owned(), values.collect()));
        self
    }

    fn without_leading(&self, rows: usize) -> Self {
        let columns = self.columns.iter().map(|(name, values)| (name.clone(), values[rows..].to_vec()));
        Self { columns: columns.collect() }
    }

    fn recording(&self) -> Recording {
        self.read(false)
    }

    fn read(&self, keep_moved: bool) -> Recording {
        let options = LoadOptions { rate_hz: Some(RATE_HZ), keep_moved, ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), self.columns.clone(), &options).unwrap()
    }

    fn found(&self) -> Vec<Disturbance> {
        let recording = self.recording();
        find(&recording, &vec![true; recording.n_rows()])
    }

    /// Excluded stretches, s.
    fn excluded(&self) -> Vec<[f64; 2]> {
        let excluded = self.found().into_iter().filter(Disturbance::is_excluded);
        excluded.map(|one| [one.rows.start as f64 / RATE_HZ, one.rows.end as f64 / RATE_HZ]).collect()
    }
}

/// 1 for `length_s` in every [`EVERY_S`], starting half a period in.
fn dip(length_s: f64) -> impl Fn(f64) -> f64 {
    move |t| f64::from((t + 0.5 * EVERY_S) % EVERY_S < length_s)
}

const LENGTHS_S: [f64; 4] = [2.0, 5.0, 8.0, 15.0];
const SIZES: [f64; 6] = [1e-3, 2e-3, 3e-3, 5e-3, 1e-2, 3e-2];

/// Every kind of channel with its level and its change.
const CHANNELS: [(&str, f64, f64); 5] = [
    ("supply_v", 3.3, -0.3),
    ("load_pct", 20.0, 60.0),
    ("temp_c", 30.0, 5.0),
    ("press_pa", 1e5, 3e3),
    ("current", 0.2, 0.4),
];

/// Excluded stretches of logs in which all axes follow one of `channels`, which alternate over lengths and sizes;
/// `logged` adds the logged version of the channel.
fn excluded_of(
    channels: &[(&str, f64, f64)],
    logged: impl Fn(Log, (&str, f64, f64), f64) -> Log,
) -> Vec<String> {
    let rest = Log::at_rest(3, 300.0);
    let mut excluded = Vec::new();
    let cases = LENGTHS_S.into_iter().flat_map(|length_s| SIZES.map(|size| (length_s, size)));
    for ((length_s, size), channel) in cases.zip(channels.iter().copied().cycle()) {
        let log = rest.clone().add(|axis, t| size * SHARE[axis] * dip(length_s)(t));
        let found = logged(log, channel, length_s).excluded();
        if !found.is_empty() {
            excluded.push(format!("{} {length_s} s, {size} rad/s: {found:?}", channel.0));
        }
    }
    excluded
}

#[test]
fn keeps_steps_that_follow_a_logged_channel() {
    let excluded = excluded_of(&CHANNELS, |log, (name, level, change), length_s| {
        log.with(name, |t| level + change * dip(length_s)(t))
    });
    assert_eq!(excluded, Vec::<String>::new());
    // the channel withheld, and shifted in time against the axes
    let withheld = excluded_of(&CHANNELS[..1], |log, _, _| log);
    let shifted = excluded_of(&CHANNELS[..1], |log, (name, level, change), length_s| {
        log.with(name, |t| level + change * dip(length_s)(t + 17.0))
    });
    for excluded in [&withheld, &shifted] {
        // steps of 1 and 2 mrad/s, and those that cover half of a window, are not detected
        assert!(excluded.len() >= 8, "a third of the logs and more: {excluded:?}");
    }
    println!(
        "attack: exclusions explained by a logged channel | {} logs in which all axes shift by 1 to 30 mrad/s for 2 to 15 s together with one of {} kinds of channel: nothing is excluded as motion | negative control: {} logs have exclusions without the channel, {} with a delayed channel",
        LENGTHS_S.len() * SIZES.len(),
        CHANNELS.len(),
        withheld.len(),
        shifted.len(),
    );
}

#[test]
fn counts_the_stretches_that_follow_a_channel() {
    let log = Log::at_rest(4, 300.0).add(|axis, t| 5e-3 * SHARE[axis] * dip(5.0)(t));
    let log = log.with("supply_v", |t| 3.3 - 0.3 * dip(5.0)(t));
    let lines = describe_disturbances(&log.recording(), &log.found());
    assert!(lines.len() == 1 && lines[0].ends_with("stretches follow supply_v and were kept"), "{lines:?}");
}

/// A ringing blow at `at_s`.
fn knock(size: f64, at_s: f64) -> impl Fn(usize, f64) -> f64 {
    move |axis, t| match t - at_s {
        since if (0.0..1.0).contains(&since) => {
            size * SHARE[axis] * (-since / 0.1).exp() * (std::f64::consts::TAU * 11.0 * since).cos()
        }
        _ => 0.0,
    }
}

/// Picked up at `at_s` for four seconds and put down in a different orientation.
fn handling(at_s: f64) -> impl Fn(usize, f64) -> f64 {
    move |axis, t| {
        let x = ((t - at_s) / 4.0).clamp(0.0, 1.0);
        let angle = std::f64::consts::PI * x;
        match axis {
            0 => 0.6 * (0.5 - 0.5 * angle.cos()),
            1 => -0.4 * (0.5 - 0.5 * angle.cos()) * (1.0 + 0.2 * (3.0 * angle).sin()),
            4 => 0.3 * angle.sin(),
            5 => -0.2 * (2.0 * angle).sin(),
            _ => 0.0,
        }
    }
}

#[test]
fn excludes_motion_during_a_channel_change() {
    let at_s = 125.0;
    let is_hit =
        |log: &Log| log.excluded().iter().any(|[start, end]| *start <= at_s + 0.1 && at_s + 0.1 <= *end);
    // with and without axes that follow the channel: a motion at one of its changes is still a motion
    for size in [0.0, 3e-3, 1e-2] {
        let log = Log::at_rest(5, 300.0).add(|axis, t| size * SHARE[axis] * dip(8.0)(t));
        let log =
            log.with("supply_v", |t| 3.3 - 0.3 * dip(8.0)(t)).with("load_pct", |t| 20.0 + 60.0 * dip(8.0)(t));
        assert!(is_hit(&log.clone().add(knock(0.05, at_s))), "a knock, {size}");
        assert!(is_hit(&log.clone().add(handling(at_s))), "handling, {size}");
        // steps that follow the channel elsewhere remain included
        let others = log.add(handling(at_s)).excluded();
        assert!(
            others
                .iter()
                .all(|[start, end]| (at_s - 15.0..at_s + 25.0).contains(start) && *end < at_s + 30.0),
            "{size}: {others:?}"
        );
    }
    // one change alone explains nothing
    let once = |t: f64| f64::from((120.0..400.0).contains(&t));
    let log = Log::at_rest(6, 300.0)
        .add(|axis, t| 0.02 * SHARE[axis] * once(t))
        .with("load_pct", |t| 20.0 + 60.0 * once(t));
    assert!(!log.excluded().is_empty());
}

/// Logs with and without disturbances, some of them just above the detection limit.
fn borderline() -> Vec<(&'static str, Log)> {
    let rest = |seed| Log::at_rest(seed, 200.0);
    vec![
        ("rest", rest(20)),
        ("knock", rest(21).add(knock(0.01, 70.0))),
        ("weak knock", rest(22).add(knock(0.0035, 70.0))),
        ("handling", rest(23).add(handling(90.0))),
        ("steps", rest(24).add(|axis, t| 3e-3 * SHARE[axis] * dip(5.0)(t))),
        ("weak steps", rest(25).add(|axis, t| 2.2e-3 * SHARE[axis] * dip(5.0)(t))),
        ("short steps", rest(26).add(|axis, t| 2.5e-3 * SHARE[axis] * dip(2.0)(t))),
    ]
}

/// Logs in which `excluded` counts a different number of stretches once up to 20 leading rows are dropped.
fn depending_on_leading_rows(excluded: impl Fn(&Log) -> usize) -> Vec<String> {
    let mut depending = Vec::new();
    for (name, log) in borderline() {
        let counts: Vec<usize> = (0..=20).map(|rows| excluded(&log.without_leading(rows))).collect();
        if counts.iter().any(|count| *count != counts[0]) {
            depending.push(format!("{name}: {counts:?}"));
        }
    }
    depending
}

#[test]
fn leading_rows_change_no_verdict() {
    assert_eq!(depending_on_leading_rows(|log| log.excluded().len()), Vec::<String>::new());
    // windows that begin at row 0 and do not overlap
    let anchored = |log: &Log| {
        let scale = scale::Scale { stride: 80, block: 10, window: 80, margin: 0 };
        let energies: Vec<Vec<f64>> = log
            .columns
            .iter()
            .map(|(_, values)| {
                let mut means = values.clone();
                for row in 0..means.len() {
                    let block = &values[row..(row + 10).min(values.len())];
                    means[row] = block.iter().sum::<f64>() / block.len() as f64;
                }
                scale.log_energy(&means, &log.recording().segments)
            })
            .collect();
        let level: Vec<f64> = energies.iter().map(|energy| scale::median_of_known(energy)).collect();
        let score =
            |window: usize| (0..6).map(|axis| (energies[axis][window] - level[axis]).max(0.0)).sum::<f64>();
        (0..energies[0].len()).filter(|window| score(*window) > 6.0).count()
    };
    let depending = depending_on_leading_rows(anchored);
    assert!(!depending.is_empty());
    println!(
        "attack: leading rows | {} logs with and without motion, some barely detectable: removing 1 to 20 leading rows does not change the number of excluded intervals | negative control: with windows anchored at the first row, it changes in {} of the logs",
        borderline().len(),
        depending.len(),
    );
}

/// A vehicle: white noise through a low-pass of 0.5 Hz, scaled by the second moment of each axis.
fn vehicle(seed: u64, seconds: f64, size: f64) -> Log {
    let mut log = Log::at_rest(seed, seconds);
    let pole = (-std::f64::consts::TAU * 0.5 / RATE_HZ).exp();
    for (axis, (_, values)) in log.columns.iter_mut().enumerate() {
        let deviation = size * if axis < 3 { 1.0 } else { 0.1 };
        let mut state = 0.0;
        for (value, drive) in
            values.iter_mut().zip(white_noise(seed * 100 + axis as u64, (seconds * RATE_HZ) as usize))
        {
            state = pole * state + (1.0 - pole * pole).sqrt() * drive;
            *value += deviation * state;
        }
    }
    log
}

#[test]
fn rejects_a_log_in_continuous_motion() {
    for log in
        [vehicle(30, 300.0, 1.0), vehicle(31, 120.0, 0.4), vehicle(32, 300.0, 1.0).with("still", |_| 1.0)]
    {
        let recording = log.recording();
        let error = check(&recording).unwrap_err();
        assert!(matches!(&error, RecordingError::Moves { rest_s, .. } if *rest_s < 10.0), "{error}");
        let stillness = crate::stillness::find(&recording);
        assert!(stillness.check_rest(&recording, &(0..recording.n_rows())).is_err());
        check(&log.read(true)).unwrap();
    }
    println!(
        "attack: motion all along | 3 drives, one of which is marked as still: refused, with the measured motion and the remedy | negative control: without excluding motion, {} of 3 are accepted as logs at rest",
        [vehicle(30, 300.0, 1.0), vehicle(31, 120.0, 0.4), vehicle(32, 300.0, 1.0)]
            .iter()
            .filter(|log| check(&log.read(true)).is_ok())
            .count(),
    );
}

#[test]
fn lost_samples_do_not_hide_a_drive() {
    let mut log = vehicle(34, 120.0, 1.0);
    let time_s = (0..log.n()).map(|row| (row + 2 * (row / 350)) as f64 / RATE_HZ).collect();
    log.columns.insert(0, ("t_s".to_owned(), time_s));
    assert!(log.recording().segments.len() > 10);
    assert!(check(&log.recording()).is_err());
}

#[test]
fn uses_the_rest_within_a_drive() {
    let drive = vehicle(33, 300.0, 1.0);
    let mut log = Log::at_rest(33, 300.0);
    for ((_, values), (_, driven)) in log.columns.iter_mut().zip(&drive.columns) {
        values[..10_000].copy_from_slice(&driven[..10_000]);
    }
    let recording = log.recording();
    check(&recording).unwrap();
    let rest = marked(&recording).0.still_rows();
    let seconds = rest.iter().map(|rows| rows.len()).sum::<usize>() as f64 / RATE_HZ;
    assert!((80.0..101.0).contains(&seconds), "{rest:?}");
}

#[test]
fn no_effect_looks_like_motion() {
    let rest = |seed| Log::at_rest(seed, 200.0);
    let walk = random_walk(99, 10_000);
    let logs = [
        ("drift", rest(40).add(|axis, t| 0.3 * SHARE[axis] * (t / 60.0).sin())),
        ("steps", rest(41).add(|axis, t| 0.03 * SHARE[axis] * f64::from((t / 13.0) as u32 % 2))),
        ("line", rest(42).add(|axis, t| 2.0 * DEVIATION[axis] * (std::f64::consts::TAU * 0.4 * t).sin())),
        ("loud line", rest(43).add(|axis, t| 0.1 * SHARE[axis] * (std::f64::consts::TAU * 17.0 * t).sin())),
        ("random walk", rest(44).add(|axis, t| 0.05 * DEVIATION[axis] * walk[(t * RATE_HZ) as usize])),
        // dps labelled as rad/s
        ("wrong unit", {
            let mut log = rest(45);
            log.columns.iter_mut().for_each(|(_, values)| values.iter_mut().for_each(|value| *value *= 57.3));
            log
        }),
        ("one axis", {
            let mut log = vehicle(46, 200.0, 1.0);
            log.columns.truncate(1);
            log.columns.extend(rest(46).columns.into_iter().skip(1));
            log
        }),
    ];
    for (name, log) in logs {
        let found = log.found();
        assert!(!found.iter().any(|one| one.kind == Kind::Motion), "{name}: {found:?}");
        check(&log.recording()).unwrap();
    }
    // where the motion of a shaker or a table is logged there is no absolute limit
    let mut log = vehicle(47, 200.0, 1.0);
    let references =
        vehicle(47, 200.0, 1.0).columns.into_iter().map(|(name, values)| (format!("ref_{name}"), values));
    log.columns.extend(references);
    check(&log.recording()).unwrap();
}
