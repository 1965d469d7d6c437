//! Fits one log repeatedly in one process: memory does not grow.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_fit::evaluate::{Trace, trace};
use fos_fit::fit::{AxisFit, FitOptions, fit_axis};
use fos_fit::playback::Playback;
use fos_simulate::{Simulation, simulate};

/// Number of fits until memory is steady: threads run, and the allocator has its working set.
const WARM: usize = 20;
const FITS: usize = 200;

/// Duration of the log, s: 6,000 rows at 200 Hz.
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

/// Number of rows for the evaluation: few, since coasts over all of them would take most of the time.
const JUDGED: usize = 1200;

/// Model of one axis, and its residual.
fn fit(recording: &Recording) -> (AxisFit, Trace) {
    let stillness = stillness::find(recording);
    let fitted = fit_axis(recording, &stillness, "gx", &FitOptions::default()).expect("it can be fitted");
    let playback = Playback::new(recording, &fitted.model, &stillness.still).expect("it can be fed");
    let left = trace(&fitted.model, &playback, recording.n_rows() - JUDGED..recording.n_rows())
        .expect("it can be run");
    (fitted, left)
}

/// Resident memory of this process, bytes.
fn resident() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<usize>().ok()? * 1024)
}

/// Growth of memory from fit [`WARM`] to fit [`FITS`], bytes.
fn growth(mut fit: impl FnMut()) -> usize {
    (0..WARM).for_each(|_| fit());
    let warm = resident().expect("it was there before");
    (WARM..FITS).for_each(|_| fit());
    resident().expect("it was there before").saturating_sub(warm)
}

#[test]
fn memory_stays_flat_over_two_hundred_fits() {
    if resident().is_none() {
        println!("skipped: this system has no /proc/self/status");
        return;
    }
    let recording = log();
    // a leak would be a series: a quarter of one column per fit is less than a fit allocates, and more than the
    // scatter of the allocator
    let bound = (FITS - WARM) * recording.n_rows() * size_of::<f64>() / 4;
    let flat = growth(|| drop(fit(&recording)));
    // negative control: with every result kept, memory must grow
    let mut kept = Vec::new();
    let kept_growth = growth(|| kept.push(fit(&recording)));
    println!(
        "from fit {WARM} to fit {FITS} of {} rows in one process, memory grew by {:.2} MB (limit: {:.2} MB). \
         Negative control: with every result kept, by {:.2} MB",
        recording.n_rows(),
        flat as f64 / 1e6,
        bound as f64 / 1e6,
        kept_growth as f64 / 1e6
    );
    assert!(flat < bound, "grew by {flat} bytes, at most {bound}");
    assert!(kept_growth > bound, "kept results grew by {kept_growth} bytes only");
}
