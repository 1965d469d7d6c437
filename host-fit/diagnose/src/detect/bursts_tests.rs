//! Logs of few seconds and duty-cycled logs: effects are found from the means of the bursts, and a short log is tested
//! for all that it can show.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_simulate::{Simulation, simulate};

use super::{Diagnosis, Question, Verdict, diagnose};
use crate::effects::Library;

/// Six hours of a device that wakes for 5 s every 300 s; `temperature` is a multiple of its 0.02 (°/s)/K.
fn duty_cycled(seed: u64, temperature: f64) -> Recording {
    let simulation = Simulation { duration_s: 6.0 * 3600.0, rate_hz: 50.0, seed, temperature, motion: false };
    let mut columns = simulate(&simulation).columns;
    columns.retain(|(name, _)| ["t_s", "gx_rads", "temp_c"].contains(&name.as_str()));
    let awake: Vec<bool> = columns[0].1.iter().map(|time_s| time_s.rem_euclid(300.0) < 5.0).collect();
    for (_, values) in &mut columns {
        let mut awake = awake.iter();
        values.retain(|_| *awake.next().expect("as many"));
    }
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a recording")
}

fn answer(field: &Recording) -> Diagnosis {
    let library = Library::built_in();
    let question = Question::new(field, "gx", &library);
    diagnose(&question).expect("a diagnosis")
}

/// Such a log was read as sampled at 0.83 Hz, and the resulting means had little power.
#[test]
fn finds_temperature_drift_in_bursts() {
    for seed in 1..=2 {
        let log = duty_cycled(seed, 1.0);
        assert!((log.rate.true_hz / 50.0 - 1.0).abs() < 0.011, "{} Hz", log.rate.true_hz);
        assert_eq!((log.segments.len(), log.samples_missing()), (72, 0));
        let answer = answer(&log);
        assert_eq!(answer.verdict, Verdict::Missing, "{}", answer.sentence);
        let found: Vec<&str> = answer.findings.iter().map(|finding| finding.effect.as_str()).collect();
        assert_eq!(found, ["temp_linear"]);
        let [low, high] = answer.findings[0].sizes[0].interval;
        assert!(low < 0.0202 && high > 0.0198 && high - low < 0.002, "{low} … {high}");
    }
}

/// A log of 28 s was refused, though faults and lines show in it.
#[test]
fn short_log_lists_untested_effects_and_finds_faults() {
    let simulation =
        Simulation { duration_s: 28.0, rate_hz: 800.0, seed: 4, temperature: 0.0, motion: false };
    let mut columns = simulate(&simulation).columns;
    columns.retain(|(name, _)| ["t_s", "gx_rads", "temp_c"].contains(&name.as_str()));
    let recording = |columns: Vec<(String, Vec<f64>)>| {
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default())
            .expect("a recording")
    };
    let reference = answer(&recording(columns.clone()));
    assert_eq!((reference.verdict, reference.findings.len()), (Verdict::NotEnoughData, 0));
    let untested = reference.untested.iter().find(|untested| untested.effect == "temp_linear").expect("said");
    assert_eq!(untested.needs, ["30 s at rest, 3 s more than this log has"]);
    // dropped samples
    for (_, values) in &mut columns {
        values.drain(9000..9100);
    }
    assert_eq!(answer(&recording(columns)).findings[0].effect, "dropped_samples");
}

#[test]
fn finds_nothing_in_bursts_without_drift() {
    for seed in 1..=2 {
        let answer = answer(&duty_cycled(seed, 0.0));
        assert_eq!(answer.verdict, Verdict::NothingMissing, "{}", answer.sentence);
        assert!(answer.findings.is_empty());
    }
}
