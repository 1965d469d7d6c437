//! Every search loop terminates for any data. Steps are counted, not time: each loop calls
//! [`check`](fos_data::interrupt::check), and the number of calls is limited.
//!
//! A refinement once did not terminate on splines of noise: it removed a term below the rounding error of ⟨y²⟩ and added
//! it again, because its reduction was above the noise of the residual.

use rayon::prelude::*;

use fos_data::interrupt::counted;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::Refiner;
use fos_diagnose::study::{LogSources, Refinement};
use fos_fit::fit::{FitOptions, Search, Stop, fit_axis};
use fos_fit::signal::{allan, noise_floor};
use fos_testkit::series::every_kind;
use host_fit::paper;

/// Limit far above the number of steps of any search on these logs.
const MAX_STEPS: u64 = 20_000;

#[test]
fn every_search_ends_on_every_kind_of_data() {
    let kinds = every_kind(4000);
    let searches: Vec<Searches> = kinds.par_iter().map(|kind| Searches::of(kind, MAX_STEPS)).collect();
    let endless: Vec<&String> = searches.iter().flat_map(|searches| &searches.endless).collect();
    assert!(endless.is_empty(), "no end after {MAX_STEPS} steps: {endless:?}");
    let steps: Vec<u64> = searches.iter().flat_map(|searches| searches.steps.clone()).collect();
    let longest_of = |place: &usize| searches[*place].steps.iter().max().copied().unwrap_or(0);
    let slowest = (0..kinds.len()).max_by_key(longest_of).unwrap();
    let longest = longest_of(&slowest);
    let cut_off = Searches::of(&kinds[slowest], longest / 100).endless;
    assert!(!cut_off.is_empty(), "the negative control was not noticed");
    println!(
        "attack: searches end | {} fits, tables, noise floors, diagnoses and additions of effects on all kinds of data take at most {longest} steps of {MAX_STEPS} allowed | negative control: with a limit of {} steps, {} of those on one kind of data did not end",
        steps.len(),
        longest / 100,
        cut_off.len(),
    );
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

/// Search behind every command on one kind of data; an error also counts as an end.
#[derive(Default)]
struct Searches {
    /// Steps of the searches that terminated.
    steps: Vec<u64>,
    /// Searches that did not terminate within the limit.
    endless: Vec<String>,
}

impl Searches {
    fn of((name, values): &(String, Vec<f64>), most: u64) -> Self {
        let library = Library::built_in();
        let recording = recording(values);
        let stillness = stillness::find(&recording);
        let mut found = Self::default();
        let mut count = |what: &str, work: &mut dyn FnMut()| match counted(most, work) {
            Some(steps) => found.steps.push(steps),
            None => found.endless.push(format!("{what} of {name}")),
        };
        let mut fitted = None;
        for stop in [Stop::Multiplicity, Stop::Korenberg, Stop::Never] {
            for search in [Search::Greedy, Search::Exchange] {
                let options = FitOptions { stop, search, max_lag: 6, max_terms: 12, ..FitOptions::default() };
                count("fit", &mut || fitted = fit_axis(&recording, &stillness, "gx", &options).ok());
            }
        }
        let options =
            FitOptions { physical: vec!["temp_c".parse().unwrap()], max_lag: 4, ..FitOptions::default() };
        count("fit with a physical part", &mut || drop(fit_axis(&recording, &stillness, "gx", &options)));
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
        count("table", &mut || drop(paper::compare(&recording, &stillness, &errors, &settings, |_| {})));
        count("noise floor", &mut || {
            let _ = noise_floor::noise_floor(&[values]);
            let times = allan::averaging_times(&[values], 0.02, 10);
            drop(allan::allan_deviation(&[values], 0.02, &times));
        });
        if let Some(fit) = fitted {
            let refiner = Refiner::new(&recording, None, None, &library);
            count("diagnosis and refinement", &mut || {
                let Ok(first) = refiner.first_step(&fit.model) else { return };
                let source = || Source::made_by("test");
                let logs = LogSources {
                    log: source(),
                    reference: None,
                    evaluation: None,
                    fitted_rows: refiner.fitted_rows(),
                    read: LoadOptions::default(),
                };
                let refinement = Refinement { column: "gx_rads".to_owned(), logs, steps: vec![first] };
                drop(refiner.add_best(&refinement, &mut |_, _| {}));
            });
        }
        found
    }
}
