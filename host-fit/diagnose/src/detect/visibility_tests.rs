//! Visibility of effects predicted for a planned recording, against logs simulated as planned.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_fit::noise::{Blocks, NoiseLevels};
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;

use super::{Course, Diagnosis, Question, Visibility, diagnose, estimate, visibility};
use crate::effects::{Library, SizeUnit};

const AXIS: &str = "gx_rads";
const COURSE: Course = Course { seconds: 1800.0, start_c: 25.0, span_k: 10.0, cycles: 2.0 };

/// Noise of a consumer gyro: 0.005 (°/s)/√Hz, 8 °/h, 2 °/h/√h.
fn levels() -> NoiseLevels {
    NoiseLevels { white: 8.7e-5, flicker: 4e-5, walk: 1.5e-6, gauss_markov: None }
}

/// A recording as planned, with noise, and a drift of `slope` rad/s/K with the temperature.
fn simulated(course: &Course, slope: f64, seed: u64) -> Recording {
    let planned = course.recording(AXIS).expect("a recording");
    let rows = Blocks::new(&planned, planned.rate.period_s, vec![true; planned.n_rows()]);
    let noise = levels().simulate(&rows, &mut ChaCha12Rng::seed_from_u64(seed));
    let temp_c = planned.channel("temp_c").expect("temperature").values.to_vec();
    let axis = noise.iter().zip(&temp_c).map(|(noise, temp_c)| noise + slope * (temp_c - 25.0)).collect();
    let columns = vec![
        ("t_s".to_owned(), planned.time_s.clone()),
        (AXIS.to_owned(), axis),
        ("temp_c".to_owned(), temp_c),
        ("still".to_owned(), vec![1.0; planned.n_rows()]),
    ];
    Recording::from_columns(Source::made_by(format!("seed {seed}")), columns, &LoadOptions::default())
        .expect("a recording")
}

fn at_rest() -> Recording {
    simulated(&Course { seconds: 3600.0, span_k: 0.0, ..COURSE }, 0.0, 1)
}

fn planned(course: &Course, reference: &Recording) -> Vec<Visibility> {
    let recording = course.recording(AXIS).expect("a recording");
    visibility(&recording, reference, AXIS, &Library::built_in()).expect("an answer")
}

fn of<'v>(all: &'v [Visibility], effect: &str) -> &'v Visibility {
    all.iter().find(|one| one.effect == effect).unwrap_or_else(|| panic!("{effect}: {all:?}"))
}

#[test]
fn predicts_the_interval_that_a_log_then_gives() {
    let reference = at_rest();
    let library = Library::built_in();
    let predicted = planned(&COURSE, &reference);
    let predicted = of(&predicted, "temp_linear").half_width;
    let slope = 0.02 * SizeUnit::of_axis(fos_data::column::Column::named(AXIS)).si;
    let mut ratios: Vec<f64> = (10..19)
        .map(|seed| {
            let log = simulated(&COURSE, slope, seed);
            let question = Question { reference: Some(&reference), ..Question::new(&log, AXIS, &library) };
            let found = estimate(&question, &["temp_linear".to_owned()]).expect("an estimate");
            let [low, high] = found[0].sizes[0].interval;
            // a 95 % interval beside one of 90 %
            0.5 * (high - low) * 1.644_854 / 1.959_964 / predicted
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    assert!((0.85..1.15).contains(&ratios[4]), "{ratios:?}");
}

#[test]
fn nine_of_ten_logs_show_an_effect_of_the_predicted_size() {
    let reference = at_rest();
    let library = Library::built_in();
    let si = SizeUnit::of_axis(fos_data::column::Column::named(AXIS)).si;
    let size = of(&planned(&COURSE, &reference), "temp_linear").detected_from.expect("a size");
    let follows = |diagnosis: &Diagnosis| {
        diagnosis.findings.iter().any(|finding| finding.shows_against.as_deref() == Some("temp_c"))
    };
    let found = |size: f64, logs: u64| {
        (100..100 + logs)
            .filter(|seed| {
                let log = simulated(&COURSE, size * si, *seed);
                let question =
                    Question { reference: Some(&reference), ..Question::new(&log, AXIS, &library) };
                follows(&diagnose(&question).expect("a diagnosis"))
            })
            .count()
    };
    // of 8 at 90 %, 5 or more with a probability of 99.5 %
    let (at_size, below) = (found(size, 8), found(0.3 * size, 4));
    println!("{at_size} of 8 found at the predicted size, {below} of 4 at a third of it");
    assert!(at_size >= 5 && below <= 2, "{at_size} of 8, {below} of 4");
}

#[test]
fn more_cycles_and_more_kelvin_show_more() {
    let reference = at_rest();
    let rise = planned(&Course { cycles: 0.5, ..COURSE }, &reference);
    let cycles = planned(&COURSE, &reference);
    let wide = planned(&Course { span_k: 30.0, ..COURSE }, &reference);
    let sizes = |all: &[Visibility], effect: &str| {
        let one = of(all, effect);
        [one.detected_from, one.distinguishable_from].map(|size| size.unwrap_or(f64::INFINITY))
    };
    for effect in ["temp_linear", "thermal_lag", "thermal_hysteresis"] {
        let [one, two, three] = [&rise, &cycles, &wide].map(|all| sizes(all, effect));
        assert!(two[1] < one[1], "{effect}: two cycles {two:?}, one rise {one:?}");
        assert!(three[0] < two[0] && three[1] < two[1], "{effect}: 30 K {three:?}, 10 K {two:?}");
    }
    // one rise hardly separates a lag from other courses
    assert!(sizes(&rise, "thermal_lag")[1] > 3.0 * sizes(&cycles, "thermal_lag")[1]);
}

#[test]
fn empty_first_cells_of_the_temperature_are_not_counted() {
    let mut planned = COURSE.recording(AXIS).expect("a recording");
    let full = visibility(&planned, &at_rest(), AXIS, &Library::built_in()).expect("an answer");
    let mut temp_c = planned.channel("temp_c").expect("temperature").values.to_vec();
    temp_c[..60].fill(f64::NAN);
    let columns = vec![
        ("t_s".to_owned(), planned.time_s.clone()),
        (AXIS.to_owned(), vec![0.0; planned.n_rows()]),
        ("temp_c".to_owned(), temp_c),
        ("still".to_owned(), vec![1.0; planned.n_rows()]),
    ];
    planned = Recording::from_columns(Source::made_by("empty"), columns, &LoadOptions::default())
        .expect("a recording");
    let found = visibility(&planned, &at_rest(), AXIS, &Library::built_in()).expect("an answer");
    let half_widths = |all: &[Visibility]| of(all, "temp_linear").half_width;
    assert!((half_widths(&found) / half_widths(&full) - 1.0).abs() < 0.1, "{found:?}");
}
