//! With thermometers that are coarse, held or failing, the correct effect is identified.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_simulate::{Simulation, simulate};

use super::{Diagnosis, Question, diagnose};
use crate::effects::Library;

/// 25 minutes at 50 Hz of a gyro with 0.02 (°/s)/K; its thermometer is `read` applied to every 50th value.
fn answer(seed: u64, read: impl Fn(usize, f64) -> f64) -> Diagnosis {
    let simulation = Simulation { duration_s: 1500.0, rate_hz: 50.0, seed, temperature: 1.0, motion: false };
    let mut columns = simulate(&simulation).columns;
    columns.retain(|(name, _)| ["t_s", "gx_rads", "temp_c"].contains(&name.as_str()));
    let temp_c = &mut columns[2].1;
    let held: Vec<f64> = (0..temp_c.len()).map(|row| read(row, temp_c[row - row % 50])).collect();
    *temp_c = held;
    let source = Source::made_by("test");
    let field = &Recording::from_columns(source, columns, &LoadOptions::default()).expect("a recording");
    let library = &Library::built_in();
    diagnose(&Question::new(field, "gx", library)).expect("a diagnosis")
}

#[track_caller]
fn names_the_drift(answer: &Diagnosis, caution: &str) {
    let found: Vec<&str> = answer.findings.iter().map(|finding| finding.effect.as_str()).collect();
    assert_eq!(found, ["temp_linear"], "{}", answer.sentence);
    assert!((answer.findings[0].sizes[0].value / 0.02 - 1.0).abs() < 0.05, "{:?}", answer.findings[0].sizes);
    assert!(answer.cautions.iter().any(|text| text.contains(caution)), "{:?}", answer.cautions);
}

/// A low-pass smooths the steps, and a lag of the sensor was reported.
#[test]
fn coarse_thermometer_is_not_mistaken_for_lag() {
    for seed in 1..=3 {
        names_the_drift(&answer(seed, |_, temp_c| temp_c.round()), "in steps of 1 K");
    }
}

/// A random walk was reported.
#[test]
fn failed_temperature_reads_hide_nothing() {
    let read = |row: usize, temp_c: f64| match row % 3001 {
        0..=9 => 0.0,
        1500..=1800 => 85.0,
        2000 => -273.15,
        _ => temp_c,
    };
    for seed in 1..=3 {
        names_the_drift(&answer(seed, read), "are exactly -273.15 or 0 or 85 °C");
    }
}
