//! Fits one log again and again in one process: memory stays where it was.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_fit::evaluate::{Trace, trace};
use fos_fit::fit::{AxisFit, FitOptions, fit_axis};
use fos_fit::playback::Playback;
use fos_simulate::{Simulation, simulate};

/// From here on nothing is new: threads run, the allocator has what it needs at once.
const WARM: usize = 20;
const FITS: usize = 200;

/// Half a minute at 200 Hz: 6,000 rows.
const DURATION_S: f64 = 30.0;

fn log() -> Recording {
    let log = simulate(&Simulation {
        duration_s: DURATION_S,
        rate_hz: 200.0,
        seed: 1,
        temperature: 1.0,
        motion: false,
    });
    let source = Source::made_by("log");
    Recording::from_columns(source, log.columns, &LoadOptions::default()).expect("a log")
}

/// Rows that a fit is judged on: a few, since coasts over all of them would take most of the time.
const JUDGED: usize = 1200;

/// A model of one axis, and what it leaves of the error.
fn fit(recording: &Recording) -> (AxisFit, Trace) {
    let stillness = stillness::find(recording);
    let fitted = fit_axis(recording, &stillness, "gx", &FitOptions::default()).expect("it can be fitted");
    let playback = Playback::new(recording, &fitted.model, &stillness.still).expect("it can be fed");
    let left =
        trace::<f64>(&fitted.model, &playback, recording.n_rows() - JUDGED..recording.n_rows(), |_| {})
            .expect("it can be run");
    (fitted, left)
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
    // what would leak is a series: a quarter of one column a fit is less than what a fit makes of it, and more than the
    // allocator scatters
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
