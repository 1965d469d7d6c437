//! Every loop that searches ends, whatever the data. Steps are counted, not time: the loops say where they are by
//! [`check`](crate::interrupt::check), of which so many are allowed.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

mod series;

use rayon::prelude::*;

use crate::candidates::Candidates;
use crate::effects::Library;
use crate::fit::exchange::{refine_within, two_rules};
use crate::fit::{FitOptions, NoiseRule, Search, Stop, StopRule, fit_axis, fos};
use crate::grow::{Ground, Growth, GrowthLogs};
use crate::interrupt::counted;
use crate::moments::{Gram, Moments, Rows};
use crate::paper;
use crate::recording::{LoadOptions, Recording, Source};
use crate::rest;
use crate::signal::{self, allan, noise_floor};

/// Moves that a refinement needs nowhere near.
const MOST_MOVES: usize = 100;

/// Steps that no search on these logs needs nearly.
const MOST_STEPS: u64 = 20_000;

fn gram(series: &[f64], lags: u16, degree: usize) -> Gram {
    let pool = Candidates::builder().output(1..=lags, degree).build().unwrap();
    let rows = Rows::usable(&[series], &[0..series.len()], pool.factors()).unwrap();
    Moments::accumulate(&[series], &rows, &pool).unwrap().gram(&pool).unwrap()
}

/// Centred and scaled as for a fit; as it is where that cannot be done.
fn scaled(series: &[f64]) -> Vec<f64> {
    let (mean, deviation) = (signal::mean(&[series]), signal::variance(&[series]).sqrt());
    match deviation.is_normal() {
        true => series.iter().map(|x| (x - mean) / deviation).collect(),
        false => series.to_vec(),
    }
}

fn rules() -> Vec<StopRule> {
    let rule = |noise, mse_ratio, max_terms| StopRule { max_terms, mse_ratio, noise };
    let noise_rules = [NoiseRule::Off, NoiseRule::Korenberg, NoiseRule::ExtendedBic];
    let mut rules: Vec<StopRule> = noise_rules.into_iter().map(|noise| rule(noise, None, 12)).collect();
    rules.extend([rule(NoiseRule::Korenberg, Some(1e-4), 12), rule(NoiseRule::Off, None, 4)]);
    rules
}

/// A fit of the lags of a spline of noise never ended: `prune` took out what `extend` had added, thousands of times.
#[test]
fn every_search_ends_on_every_kind_of_data() {
    let kinds = series::every_kind(1000);
    let refinements: Vec<Refinement> = kinds.par_iter().flat_map_iter(refinements).collect();
    for Refinement { what, moves, .. } in &refinements {
        assert!(*moves < MOST_MOVES, "{what}: no end after {moves} moves");
    }
    let searches = searches();
    let two_rules = |name: &str| {
        let without_end = refinements.iter().filter(|r| r.two_rules == MOST_MOVES && r.what.contains(name));
        without_end.count()
    };
    println!(
        "attack: searches end | {} kinds of data (smooth, flat, coarse, periodic, exact, chaotic, wandering, over 300 decades of scale): \
         {} refinements of FOS by 5 stop rules from 3 pools make at most {} moves; {} fits, tables, noise floors, diagnoses and growths take \
         at most {} steps of {MOST_STEPS} allowed | negative control: with one rule to take terms out and another to add them, {} of the \
         refinements still go on after {MOST_MOVES} moves",
        kinds.len(),
        refinements.len(),
        refinements.iter().map(|refinement| refinement.moves).max().unwrap(),
        searches.len(),
        searches.iter().max().unwrap(),
        two_rules(""),
    );
    // those on which it was found
    assert!(two_rules("spline") > 0 && two_rules("Butterworth") > 0, "the negative control was not noticed");
}

/// A refinement of FOS.
struct Refinement {
    what: String,
    moves: usize,
    /// Moves with two rules that contradict one another.
    two_rules: usize,
}

fn refinements((name, values): &(String, Vec<f64>)) -> Vec<Refinement> {
    let mut found = Vec::new();
    let scaled = scaled(values);
    for (series, (lags, degree)) in
        [(&scaled, (10, 1)), (&scaled, (6, 2)), (&scaled, (3, 3)), (values, (4, 2))]
    {
        let gram = gram(series, lags, degree);
        for rule in rules() {
            let greedy = fos::search(&gram, &rule);
            let two_rules = two_rules::moves(MOST_MOVES, &gram, &rule, &greedy);
            let (_, moves) = refine_within(MOST_MOVES, &gram, &rule, greedy);
            let what = format!("{name}, L = {lags}, CP {degree}, {rule:?}");
            found.push(Refinement { what, moves, two_rules });
        }
    }
    found
}

fn recording(values: &[f64]) -> Recording {
    let n = values.len();
    let column = |name: &str, values: Vec<f64>| (name.to_owned(), values);
    let columns = vec![
        column("t_s", (0..n).map(|k| k as f64 / 50.0).collect()),
        column("gx_rads", values.to_vec()),
        column("temp_c", (0..n).map(|k| 25.0 + (k as f64 / 900.0).sin()).collect()),
    ];
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
}

/// Steps of the search behind every command on every kind of data; errors are ends too.
fn searches() -> Vec<u64> {
    let library = Library::built_in();
    let of = |(name, values): &(String, Vec<f64>)| {
        let recording = recording(values);
        let rest = rest::find(&recording);
        let mut found = Vec::new();
        let mut count = |what: &str, work: &mut dyn FnMut()| {
            let steps = counted(MOST_STEPS, work);
            let steps = steps.unwrap_or_else(|| panic!("{what} of {name}: no end after {MOST_STEPS} steps"));
            found.push(steps);
        };
        let mut fitted = None;
        for stop in [Stop::Multiplicity, Stop::Korenberg, Stop::Never] {
            for search in [Search::Greedy, Search::Exchange] {
                let options = FitOptions { stop, search, max_lag: 6, max_terms: 12, ..FitOptions::default() };
                count("fit", &mut || fitted = fit_axis(&recording, &rest, "gx", &options).ok());
            }
        }
        let options =
            FitOptions { physical: vec!["temp_c".parse().unwrap()], max_lag: 4, ..FitOptions::default() };
        count("fit with a physical part", &mut || drop(fit_axis(&recording, &rest, "gx", &options)));
        let settings = paper::Settings {
            train_s: 30.0,
            evaluate_s: 20.0,
            max_order: 4,
            max_degree: 2,
            denoising: "db4:4:soft".parse().unwrap(),
            repeats: 1,
            search: Search::Exchange,
        };
        let errors = recording.error_series("gx").unwrap();
        count("table", &mut || drop(paper::compare(&recording, &rest, &errors, &settings, |_| {})));
        count("noise floor", &mut || {
            let _ = noise_floor::noise_floor(&[values]);
            let times = allan::averaging_times(&[values], 0.02, 10);
            drop(allan::allan_deviation(&[values], 0.02, &times));
        });
        if let Some(fit) = fitted {
            let ground = Ground::new(&recording, None, None, &library);
            count("diagnosis and growth", &mut || {
                let Ok(first) = ground.first_stair(&fit.model) else { return };
                let source = || Source::made_by("test");
                let logs = GrowthLogs {
                    field: source(),
                    quiet: None,
                    judged: None,
                    fitted_rows: ground.fitted_rows(),
                    read: LoadOptions::default(),
                };
                let growth = Growth { column: "gx_rads".to_owned(), logs, stairs: vec![first] };
                drop(ground.add_best(&growth, |_, _| {}));
            });
        }
        found
    };
    series::every_kind(4000).par_iter().flat_map_iter(of).collect()
}
