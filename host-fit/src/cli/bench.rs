//! `bench`: cost of fits on this machine.

use clap::Args;

use super::numbers::count;
use super::output::{Failure, print_json, print_line, progress, table};
use crate::bench::evaluator::{self, StepTimes};
use crate::bench::{Settings, Timings, measure};

/// Lengths of the records, samples: the paper's three minutes and an hour at 200 Hz.
const SAMPLES: [usize; 2] = [36_000, 720_000];

/// Time fits on this machine
///
/// One thread: moments, search and refit, against a textbook search and the machine's peak rate of multiply-adds, as
/// ratios in one run.
#[derive(Debug, Args)]
#[command(after_help = "Example: fos bench")]
pub(super) struct Bench {
    /// Largest output lag L
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=50))]
    max_lag: u16,
    /// Cross-product degree (CP)
    #[arg(long, default_value_t = 2, value_parser = count(1..=3))]
    degree: usize,
    /// Terms chosen
    #[arg(long, default_value_t = 10, value_parser = count(1..=1000))]
    terms: usize,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Bench {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let bar = progress(SAMPLES.len() as u64, "timing");
        let mut timings = Vec::new();
        for samples in SAMPLES {
            timings.push(measure(&Settings {
                samples,
                max_lag: self.max_lag,
                degree: self.degree,
                terms: self.terms,
                ..Settings::default()
            })?);
            bar.inc(1);
        }
        let steps = evaluator::measure(100_000)?;
        bar.finish_and_clear();
        if self.json { print_json(&(timings, steps)) } else { self.print(&timings, steps) }
    }

    fn print(&self, timings: &[Timings], steps: StepTimes) -> Result<(), Failure> {
        print_line!("L = {}, CP {}, one thread, least of several runs\n", self.max_lag, self.degree);
        let mut header = vec!["samples".to_owned()];
        header.extend(timings.iter().map(|timing| timing.samples.to_string()));
        let mut rows = table(&header);
        let mut add = |name: &str, value: &dyn Fn(&Timings) -> String| {
            let mut row = vec![name.to_owned()];
            row.extend(timings.iter().map(value));
            rows.add_row(row);
        };
        let milliseconds = |seconds: f64| format!("{:.3} ms", seconds * 1e3);
        add("candidates", &|t| t.candidates.to_string());
        add("distinct moments", &|t| t.distinct_moments.to_string());
        add("terms", &|t| t.terms.to_string());
        add("moments", &|t| milliseconds(t.moments_s));
        add("search", &|t| milliseconds(t.search_s));
        add("refit", &|t| milliseconds(t.refit_s));
        add("together", &|t| milliseconds(t.total_s));
        add("textbook search", &|t| t.twin_s.map_or("–".into(), milliseconds));
        add("  times as long as moments and search", &|t| {
            t.times_faster.map_or("–".into(), |x| format!("{x:.0}"))
        });
        add("peak multiply-adds", &|t| format!("{:.1} G/s", t.peak_multiply_adds_per_s * 1e-9));
        add("  moments over that limit", &|t| format!("{:.2}", t.moments_over_limit));
        add("memory beyond the data", &|t| format!("{:.2} MB", t.working_bytes as f64 * 1e-6));
        add("", &|_| String::new());
        for (i, (name, _)) in
            timings.first().map(|t| t.methods_s.as_slice()).unwrap_or_default().iter().enumerate()
        {
            add(name, &|t| t.methods_s.get(i).map_or("–".into(), |(_, time_s)| milliseconds(*time_s)));
        }
        print_line!("{rows}");
        let StepTimes { tracked_s, side_by_side_s, bare_s } = steps;
        print_line!(
            "\na step of an axis with ten linear terms: tracked {:.1} ns, coasting beside seven others {:.1} ns; its loads, multiplications and additions alone {:.1} ns: {:.1} and {:.1} times that",
            tracked_s * 1e9,
            side_by_side_s * 1e9,
            bare_s * 1e9,
            tracked_s / bare_s,
            side_by_side_s / bare_s
        );
        Ok(())
    }
}
