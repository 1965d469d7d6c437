//! Fits one log again and again in one process: memory stays where it was.

use host_fit::compare::study_of;
use host_fit::evaluate::Trace;
use host_fit::fit::{FitOptions, fit_axis};
use host_fit::recording::{LoadOptions, Recording, Source};
use host_fit::rest;
use host_fit::simulate::{Simulation, simulate};
use host_fit::study::Study;

/// From here on nothing is new: threads run, the allocator has what it needs at once.
const WARM: usize = 20;
const FITS: usize = 200;

/// A minute at 200 Hz: 12,000 rows.
const DURATION_S: f64 = 60.0;

fn log() -> Recording {
    let log = simulate(&Simulation {
        duration_s: DURATION_S,
        rate_hz: 200.0,
        seed: 1,
        temperature: 1.0,
        motion: false,
    });
    let source = Source { path: "log".to_owned(), bytes: 0, sha256: String::new() };
    Recording::from_columns(source, log.columns, &LoadOptions::default()).expect("a log")
}

fn fit(recording: &Recording) -> (Study, Trace) {
    let rest = rest::find(recording);
    let options = FitOptions::default();
    let fitted = fit_axis(recording, &rest, "gx", &options).expect("it can be fitted");
    let (study, _, trace) =
        study_of(recording, &rest, vec![fitted], options, Vec::new(), |_| {}).expect("it can be judged");
    (study, trace)
}

/// Memory of this process that is in RAM, bytes.
fn resident() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<usize>().ok()? * 1024)
}

/// By how much memory grows from fit [`WARM`] to fit [`FITS`], bytes.
fn growth(mut fit: impl FnMut()) -> usize {
    (0..WARM).for_each(|_| fit());
    let warm = resident().expect("it was there before");
    (WARM..FITS).for_each(|_| fit());
    resident().expect("it was there before").saturating_sub(warm)
}

#[test]
fn two_hundred_fits_take_no_more_memory_than_twenty() {
    if resident().is_none() {
        println!("skipped: this system has no /proc/self/status");
        return;
    }
    let recording = log();
    // what leaks is a series or a result: a quarter of one column a fit is less than any series that a fit makes, and more
    // than the allocator scatters
    let bound = (FITS - WARM) * recording.n_rows() * size_of::<f64>() / 4;
    let flat = growth(|| drop(fit(&recording)));
    // the same with every result kept: a check that does not see this sees nothing
    let mut kept = Vec::new();
    let kept_growth = growth(|| kept.push(fit(&recording)));
    println!(
        "from fit {WARM} to fit {FITS} of {} rows in one process memory grew by {:.2} MB (at most {:.2} MB); \
         with every result kept by {:.2} MB",
        recording.n_rows(),
        flat as f64 / 1e6,
        bound as f64 / 1e6,
        kept_growth as f64 / 1e6
    );
    assert!(flat < bound, "grew by {flat} bytes, at most {bound}");
    assert!(kept_growth > bound, "kept results grew by {kept_growth} bytes only");
}
