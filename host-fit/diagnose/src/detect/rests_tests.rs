//! Accelerometers that are turned between rests, and axes that are stuck for a while: neither is an effect, and a
//! separate level for each rest costs only its rows.

use std::f64::consts::TAU;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::noise::{Noise, white_noise};

use super::prepared::Prepared;
use super::{DiagnoseError, Diagnosis, Question, diagnose};
use crate::effects::Library;

const AXES: [&str; 6] = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];

type Columns = Vec<(String, Vec<f64>)>;

/// White noise on six axes at these times, with gravity from `force` in each row.
fn log(seed: u64, time_s: Vec<f64>, force: impl Fn(usize) -> [f64; 3]) -> Columns {
    let n = time_s.len();
    let temperature = time_s.iter().map(|t| 25.0 + 5.0 * (t / 2000.0).sin()).collect();
    let axis = |(i, name): (usize, &str)| {
        let noise = white_noise(10 * seed + i as u64, n);
        let gravity_at = |row: usize| if i < 3 { force(row)[i] } else { 0.0 };
        let deviation = if i < 3 { 0.012 } else { 0.0015 };
        (name.to_owned(), (0..n).map(|row| gravity_at(row) + deviation * noise[row]).collect())
    };
    let axes = AXES.into_iter().enumerate().map(axis);
    [("t_s".to_owned(), time_s), ("temp_c".to_owned(), temperature)].into_iter().chain(axes).collect()
}

fn recording(columns: Columns) -> Recording {
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a recording")
}

/// Bursts of 2 s every 10 s at 25 Hz, each in another orientation.
fn turned_bursts(seed: u64, bursts: usize) -> Recording {
    let mut random = Noise::new(seed);
    let forces: Vec<[f64; 3]> = (0..bursts)
        .map(|_| {
            let (z, angle) = (2.0 * random.uniform() - 1.0, TAU * random.uniform());
            let level = (1.0 - z * z).sqrt();
            [9.8 * level * angle.cos(), 9.8 * level * angle.sin(), 9.8 * z]
        })
        .collect();
    let time_s = (0..50 * bursts).map(|row| (row / 50) as f64 * 10.0 + (row % 50) as f64 / 25.0).collect();
    recording(log(seed, time_s, |row| forces[row / 50]))
}

fn with_question<T>(field: &Recording, target: &str, answer: impl FnOnce(&Question<'_>) -> T) -> T {
    let library = Library::built_in();
    let question = Question::new(field, target, &library);
    answer(&question)
}

fn effects(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.findings.iter().map(|finding| finding.effect.as_str()).collect()
}

#[test]
fn rests_add_no_regressors() {
    for bursts in [50, 100, 800] {
        let log = fos_data::disturbance::marked(&turned_bursts(1, bursts)).0.into_owned();
        let (given, blocks, rests) = with_question(&log, "az", |question| {
            let prepared = Prepared::new(question).expect("long enough");
            let blocks = &prepared.reduced.blocks;
            (prepared.given.len(), blocks.len(), blocks.restarts().len() + 1)
        });
        assert_eq!((given, rests), (1, bursts));
        assert!((2 * bursts..=4 * bursts).contains(&blocks), "{blocks} blocks of {bursts} bursts");
    }
}

/// The blocks that only determine a level were counted: "values of every logged input" were requested, which were known.
#[test]
fn short_log_of_many_rests_states_missing_time() {
    let log = fos_data::disturbance::marked(&turned_bursts(1, 18)).0.into_owned();
    let (blocks, needed) = with_question(&log, "az", |question| {
        let prepared = Prepared::new(question).expect("long enough for lines");
        assert!(prepared.is_short());
        (prepared.reduced.blocks.len(), prepared.time_needed().expect("a message"))
    });
    assert!(blocks >= super::MIN_BLOCKS, "{blocks}");
    assert!(needed.contains("more than this log has"), "{needed}");
}

/// A bias step of up to 99 % was found in half of them.
#[test]
fn finds_nothing_in_bursts_between_turns() {
    for (seed, bursts) in [(1, 30), (2, 60), (3, 100), (4, 100)] {
        let field = turned_bursts(seed, bursts);
        for axis in ["ax", "az"] {
            let answer = with_question(&field, axis, diagnose).expect("a diagnosis");
            assert_eq!(effects(&answer), [""; 0], "{seed} {axis}: {}", answer.sentence);
            // a level for each burst takes every slow course, so none was tested
            let needs = |id: &str| {
                let untested = answer.untested.iter().find(|untested| untested.effect == id);
                untested.map(|untested| untested.needs.join(", "))
            };
            for effect in ["temp_linear", "warmup_exp", "bias_ramp"] {
                assert_eq!(needs(effect).as_deref(), Some("longer rests in one orientation"), "{effect}");
                assert!(!answer.tested.iter().any(|tested| tested == effect), "{effect}");
            }
        }
    }
}

/// Ten minutes at 20 Hz with a pause in the middle, during which the device is tilted by `degrees`.
fn tilted_in_pause(pause_s: f64, degrees: f64) -> Recording {
    let time_s = (0..12_000).map(|row| row as f64 * 0.05 + if row < 6000 { 0.0 } else { pause_s }).collect();
    let (sin, cos) = degrees.to_radians().sin_cos();
    let tilted = |row: usize| if row < 6000 { [0.0, 0.0, 9.8] } else { [9.8 * sin, 0.0, 9.8 * cos] };
    recording(log(5, time_s, tilted))
}

#[test]
fn tilt_during_pause_is_not_a_bias_step() {
    for degrees in [0.5, 5.0] {
        let field = tilted_in_pause(60.0, degrees);
        let answer = with_question(&field, "ax", diagnose).expect("a diagnosis");
        assert_eq!(effects(&answer), [""; 0], "{degrees}°: {}", answer.sentence);
        let states_ambiguity = |caution: &String| caution.contains("indistinguishable across a pause");
        assert!(answer.cautions.iter().any(states_ambiguity), "{:?}", answer.cautions);
    }
    // negative control: the same change during recording is a step
    let answer = with_question(&tilted_in_pause(0.0, 0.5), "ax", diagnose).expect("a diagnosis");
    assert_eq!(effects(&answer), ["bias_step"]);
    let [from_s, to_s] = answer.findings[0].shows_from_to_s.expect("where it shows");
    assert!((from_s..to_s).contains(&300.0) && to_s - from_s < 60.0, "{from_s} … {to_s}");
    println!(
        "attack: orientation across pauses | tilts of 0.5° and 5° during a pause: no effect is reported, and the ambiguity is stated | negative control: the same tilt without a pause is reported as {}",
        effects(&answer).join(", "),
    );
}

/// A gyro that repeats one value for a share of ten minutes at 20 Hz.
fn stuck_for(share: f64) -> Result<Diagnosis, DiagnoseError> {
    let time_s = (0..12_000).map(|row| row as f64 * 0.05).collect();
    let mut columns = log(6, time_s, |_| [0.0, 0.0, 9.8]);
    let values = &mut columns.last_mut().expect("columns").1;
    let held = values[3000] + 0.003;
    values[3000..=3000 + (share * 12_000.0) as usize].fill(held);
    with_question(&recording(columns), "gz", diagnose)
}

#[test]
fn excludes_stuck_stretch_or_rejects_axis() {
    for share in [0.015, 0.05, 0.11, 0.3] {
        let answer = stuck_for(share).expect("a diagnosis");
        assert_eq!(effects(&answer), [""; 0], "{share}: {}", answer.sentence);
        let seconds = format!("repeats one value for {:.1} s from 150", 600.0 * share);
        assert!(answer.cautions.iter().any(|caution| caution.contains(&seconds)), "{:?}", answer.cautions);
    }
    assert!(matches!(stuck_for(0.55), Err(DiagnoseError::Stuck { .. })));
}
