//! Pictures of the effects for docs/effects.md: the regressors of the library on a log in which every input varies, and a
//! course of each effect without regressors.

use std::f64::consts::TAU;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::effects::{Detector, Effect, Inputs, Regressor};
use fos_figures::{Axis, Figure, Ink, Panel, Series, Shape, svg};
use fos_testkit::noise::white_noise;

const RATE_HZ: f64 = 20.0;
const DURATION_S: f64 = 1200.0;
/// Drawn points of a curve.
const POINTS: usize = 240;
const CLOCK: &str = "t_s";

/// Two slow cycles of temperature, supply and field, load in pulses, turns, and a vibration that grows.
fn log() -> Recording {
    let time: Vec<f64> = (0..(RATE_HZ * DURATION_S) as usize).map(|row| row as f64 / RATE_HZ).collect();
    let cycle = |period_s: f64, size: f64| move |t: f64| size * (TAU * t / period_s).sin();
    let shakes =
        |period_s: f64| move |t: f64| cycle(period_s, 5.0)(t) + t / DURATION_S * (TAU * 4.9 * t).sin() * 3.0;
    let columns: [(&str, &dyn Fn(f64) -> f64); 15] = [
        ("gx_rads", &|_| 0.0),
        ("temp_c", &|t| 25.0 + cycle(600.0, 10.0)(t)),
        ("supply_v", &|t| 3.3 + cycle(600.0, 0.2)(t)),
        ("load_pct", &|t| if (t / 300.0).fract() < 0.5 { 10.0 } else { 80.0 }),
        ("mag_x_ut", &cycle(600.0, 40.0)),
        ("mag_y_ut", &cycle(400.0, 40.0)),
        ("mag_z_ut", &cycle(300.0, 40.0)),
        ("ax_mps2", &shakes(600.0)),
        ("ay_mps2", &shakes(400.0)),
        ("az_mps2", &shakes(300.0)),
        ("ref_gx_rads", &cycle(60.0, 3.0)),
        ("ref_gy_rads", &cycle(400.0, 3.0)),
        ("ref_gz_rads", &cycle(300.0, 3.0)),
        ("ref_ax_mps2", &cycle(60.0, 10.0)),
        ("gy_rads", &|_| 0.0),
    ];
    let columns = columns
        .iter()
        .map(|(name, value)| ((*name).to_owned(), time.iter().map(|t| value(*t)).collect::<Vec<f64>>()));
    let columns = std::iter::once((CLOCK.to_owned(), time.clone())).chain(columns).collect();
    Recording::from_columns(Source::made_by("picture"), columns, &LoadOptions::default()).expect("a log")
}

/// Values of `y`, which gets the number of a point and its x, at points over `range`.
fn over(range: f64, y: &mut dyn FnMut(usize, f64) -> f64) -> Vec<(f64, f64)> {
    let x = |point: usize| range * point as f64 / POINTS as f64;
    (0..POINTS).map(|point| (x(point), y(point, x(point)))).collect()
}

/// Titles of both axes, and points.
type Course = (&'static str, &'static str, Vec<(f64, f64)>);

/// Course of an effect that has no regressors.
fn course(id: &str) -> Option<Course> {
    let noise = white_noise(1, POINTS);
    let (seconds, error, signal) = ("time (s)", "error (1)", "sensor output (1)");
    let course = match id {
        "bias_step" => {
            (seconds, error, over(DURATION_S, &mut |_, t| f64::from(u8::from(t > DURATION_S / 2.0))))
        }
        "spectral_line" => (seconds, error, over(1.0, &mut |_, t| (TAU * 9.0 * t).sin())),
        "drifting_line" => (seconds, error, over(1.0, &mut |_, t| (TAU * (5.0 + 4.0 * t) * t).sin())),
        "noise_temperature" => {
            ("temp_c", error, over(60.0, &mut |point, temp_c| noise[point] * (1.0 + 0.05 * temp_c)))
        }
        "saturation" => {
            (seconds, signal, over(1.0, &mut |_, t| (1.5 * (TAU * 2.0 * t).sin()).clamp(-1.0, 1.0)))
        }
        // a third of the samples is missing from half of the log, and the logger counts those that arrive
        "dropped_samples" => {
            (seconds, signal, over(1.0, &mut |_, t| (TAU * 4.0 * (t + 0.5 * (t - 0.5).max(0.0))).sin()))
        }
        "quantisation" => (seconds, signal, over(1.0, &mut |_, t| (4.0 * (TAU * t).sin()).round() / 4.0)),
        "dead_zone" => {
            let shrunk = |rate: f64| if rate.abs() < 0.3 { 0.0 } else { rate };
            let points = over(2.0, &mut |_, from_left| shrunk(from_left - 1.0));
            ("true rate (1)", signal, points.into_iter().map(|(x, y)| (x - 1.0, y)).collect())
        }
        "gauss_markov" | "rate_random_walk" => {
            let (keeps, mut state) = (if id == "gauss_markov" { 0.93 } else { 1.0 }, 0.0);
            let mut step = |point: usize, _| {
                state = keeps * state + noise[point];
                state
            };
            (seconds, error, over(DURATION_S, &mut step))
        }
        "random_telegraph" => {
            let mut level = 1.0;
            let mut step = |point: usize, _| {
                level *= if noise[point].abs() > 2.0 { -1.0 } else { 1.0 };
                level + 0.05 * noise[point]
            };
            (seconds, error, over(DURATION_S, &mut step))
        }
        _ => return None,
    };
    Some(course)
}

/// Picture of an effect: its regressors, each over its largest value, against the first input, or against time if that is
/// the clock, comes in pulses or is averaged; without regressors, a course of it.
pub(crate) fn picture(effect: &Effect) -> String {
    let panel = match course(&effect.id) {
        Some((x, y, points)) => {
            let series = Series::new("", Ink::Method(0), Shape::Line(points));
            Panel::new(Axis::linear(x), Axis::linear(y), [series])
        }
        None => of_regressors(effect),
    };
    svg(&Figure { title: effect.name.clone(), panels: vec![panel] }).expect("a picture")
}

fn of_regressors(effect: &Effect) -> Panel {
    assert_eq!(effect.search, Detector::Terms, "{}", effect.id);
    let log = log();
    let inputs = Inputs::new(&log);
    let target = if effect.strikes("gx_rads") { "gx_rads" } else { "ax_mps2" };
    // in the middle of the range, where two cycles show it
    let value =
        effect.parameter.as_ref().map(|parameter| (parameter.low * parameter.high).sqrt().clamp(0.0, 300.0));
    let regressors = effect.regressors(target, value).expect("regressors");
    let (_, first) = regressors.first().expect("a regressor");
    let column = first.columns().next().unwrap_or(CLOCK);
    let is_over_time = column == CLOCK || column == "load_pct" || first.to_string().contains("variance");
    let column = if is_over_time { CLOCK } else { column };
    // loops have settled in the second half
    let begin = if is_over_time { 0 } else { log.n_rows() / 2 };
    let x = if is_over_time { &log.time_s } else { &log.channel(column).expect("a column").values };
    let line = |regressor: &Regressor| {
        let values = inputs.regressor(regressor).expect("a regressor");
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let largest = values.iter().map(|value| (value - mean).abs()).fold(0.0, f64::max);
        let points = x.iter().zip(values.iter()).skip(begin).step_by((log.n_rows() - begin) / POINTS);
        Shape::Line(points.map(|(x, y)| (*x, (y - mean) / largest)).collect())
    };
    // those of other inputs have the same shape against them
    let is_of_column =
        |regressor: &Regressor| is_over_time || regressor.columns().all(|other| other == column);
    let drawn: Vec<_> = regressors
        .iter()
        .enumerate()
        .filter(|(place, (_, regressor))| *place == 0 || is_of_column(regressor))
        .map(|(_, regressor)| regressor)
        .collect();
    let label = |term: usize| match drawn.len() {
        1 => String::new(),
        _ => effect.terms[term].regressor.clone(),
    };
    let series = drawn
        .iter()
        .enumerate()
        .map(|(place, (term, regressor))| Series::new(label(*term), Ink::Method(place), line(regressor)));
    let x = Axis::linear(if is_over_time { "time (s)" } else { column });
    Panel::new(x, Axis::linear("error about its mean (1)"), series)
}
