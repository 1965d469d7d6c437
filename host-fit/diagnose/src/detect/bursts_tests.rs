//! Duty-cycled logs: what is missing in them is found from the means of their bursts.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_simulate::{Simulation, simulate};

use super::{Diagnosis, Question, Verdict, diagnose};
use crate::effects::Library;

/// Six hours of a unit that wakes for 5 s every 300 s; `temperature` as a multiple of its 0.02 °/s/K.
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
    let question = Question {
        field,
        quiet: None,
        judged: None,
        target: "gx",
        sheet: None,
        full_scale: None,
        lsb: None,
        library: &library,
        given: &[],
    };
    diagnose(&question).expect("a diagnosis")
}

/// It was read as 0.83 samples a second, of whose means little could be told.
#[test]
fn a_drift_with_temperature_is_named_from_bursts_with_its_size() {
    for seed in 1..=3 {
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

#[test]
fn nothing_is_missing_in_bursts_without_it() {
    for seed in 1..=3 {
        let answer = answer(&duty_cycled(seed, 0.0));
        assert_eq!(answer.verdict, Verdict::NothingMissing, "{}", answer.sentence);
        assert!(answer.findings.is_empty());
    }
}
