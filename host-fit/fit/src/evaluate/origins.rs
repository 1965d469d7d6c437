//! Rows of a recording from which coasts begin, and their lengths.

use std::ops::Range;

use super::unaided::UNAIDED_S;
use fos_data::recording::pieces;

/// Horizons of the coast error, s.
pub const HORIZONS_S: [f64; 3] = [1.0, 10.0, 60.0];

/// Steps spent on the coasts of one horizon. 2·10⁶ at 200 Hz are 10,000 coasts of 1 s or 166 of 60 s.
const STEPS_PER_HORIZON: usize = 2_000_000;

/// Number of windows without aiding of one length that are run even beyond [`STEPS_PER_HORIZON`]; more of them are
/// thinned, as a long log costs no more than it must.
const MOST_WINDOWS: usize = 200;

/// Time from the start of a stretch to its first coast, s, at most a quarter of the stretch: a coast is to start from
/// measured history, not from the coast through the motion before.
const LEAD_S: f64 = 5.0;

/// Length of the consecutive coasts over the whole recording, s: the longest horizon.
const BLOCK_S: f64 = 60.0;

/// Rows from which coasts begin, and their lengths: evenly spread, every coast inside one still stretch.
pub(super) struct Origins {
    /// Samples of each horizon.
    pub(super) ticks: [usize; 3],
    /// (row, ticks), sorted by row.
    pub(super) reaches: Vec<(usize, usize)>,
    /// Consecutive coasts that cover the stretches.
    pub(super) blocks: Vec<Range<usize>>,
    /// Whole windows without aiding, sorted by begin, and the index of their length in [`UNAIDED_S`].
    pub(super) windows: Vec<(Range<usize>, usize)>,
}

impl Origins {
    pub(super) fn new(stretches: &[Range<usize>], period_s: f64) -> Self {
        let ticks = HORIZONS_S.map(|horizon| ((horizon / period_s).round() as usize).max(1));
        let lead = (LEAD_S / period_s) as usize;
        let after_lead = |stretch: &Range<usize>| stretch.start + lead.min(stretch.len() / 4)..stretch.end;
        let stretches: Vec<Range<usize>> = stretches.iter().map(after_lead).collect();
        let mut reaches = Vec::new();
        for ticks in ticks {
            let places = |stretch: &Range<usize>| (stretch.len() + 1).saturating_sub(ticks);
            let available: usize = stretches.iter().map(places).sum();
            let wanted = (STEPS_PER_HORIZON / ticks).max(1);
            let spacing = available.div_ceil(wanted).max(1);
            for stretch in &stretches {
                reaches.extend(
                    (0..places(stretch)).step_by(spacing).map(|place| (stretch.start + place, ticks)),
                );
            }
        }
        reaches.sort_unstable();
        // where several start in one row, the longest passes through the shorter ones
        reaches.dedup_by(|later, kept| {
            let same = later.0 == kept.0;
            if same {
                kept.1 = kept.1.max(later.1);
            }
            same
        });
        let block = ((BLOCK_S / period_s).round() as usize).max(1);
        let blocks = pieces(&stretches, block);
        let windows = windows(&stretches, period_s);
        Self { ticks, reaches, blocks, windows }
    }
}

/// Windows without aiding that follow one another in every stretch, evenly thinned where there are many.
fn windows(stretches: &[Range<usize>], period_s: f64) -> Vec<(Range<usize>, usize)> {
    let mut windows = Vec::new();
    for (length, window_s) in UNAIDED_S.into_iter().enumerate() {
        let ticks = ((window_s / period_s).round() as usize).max(1);
        let mut whole = pieces(stretches, ticks);
        whole.retain(|window| window.len() == ticks);
        let wanted = (STEPS_PER_HORIZON / ticks).max(MOST_WINDOWS);
        let spacing = whole.len().div_ceil(wanted).max(1);
        windows.extend(whole.into_iter().step_by(spacing).map(|window| (window, length)));
    }
    windows.sort_by_key(|(window, _)| window.start);
    windows
}
