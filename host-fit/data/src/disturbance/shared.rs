//! Finds excess energy on several axes at the same time.

use std::ops::Range;

use super::explained::{self, Axes, Explained, possible_causes};
use super::scale::{FAR, NEAR, Scale, Usual, local_level, median_of_known, stretches, sum_but_most};
use crate::interrupt::in_parallel;
use crate::recording::{Recording, runs};

/// Longest sampling period, s: slower logs have no time scale on which a knock stands out from noise.
pub(super) const LONGEST_PERIOD_S: f64 = 0.2;

/// Longest blocks, s: the slowest sway of a building takes ten seconds.
const LONGEST_BLOCK_S: f64 = 2.6;

/// Longest blocks that resolve vibration, s; longer ones resolve motion. In a log slower than this the single samples
/// stand for vibration: the scales of motion are compared with the level of a shorter one.
const VIBRATION_BLOCK_S: f64 = 0.1;

/// Pieces of the local level of vibration, s: an event is shorter than two and a half of them.
const PIECE_S: f64 = 5.0;

/// Minimum duration of vibration that counts as a state, s.
const LASTING_S: f64 = 28.0;

/// Motions closer than this are merged, s.
const MERGE_S: f64 = 0.75;

/// Minimum excess of the level of vibration in a lasting stretch above that of the quietest tenth: half as much again in
/// deviation.
const SHAKEN: f64 = 0.8;

/// Excess from which vibration is violent, and an event unless it lasts: ten times the deviation.
const VIOLENT: f64 = 4.6;

/// Stretches of motion.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Temporary motion: events and slow motion.
    pub(super) moved: Vec<Range<usize>>,
    pub(super) shaken: Vec<Range<usize>>,
    /// Stretches that a logged channel explains: no motion.
    pub(super) explained: Vec<Explained>,
}

/// Searches all axes on all time scales. With a reference for the motion, slow motion is not searched: its remaining
/// part is the error.
pub(super) fn find(recording: &Recording, mut means: Vec<Vec<f64>>, has_reference: bool) -> Shared {
    let period_s = recording.rate.period_s;
    let n = recording.n_rows();
    let mut moved = vec![false; n];
    let mut shaken = vec![false; n];
    let mut violent = vec![false; n];
    // excess of the slowest vibration of each axis above its minimum, window by window
    let mut leaking: Vec<(Scale, Vec<f64>)> = Vec::new();
    let causes = possible_causes(recording);
    let mut explained = Vec::new();
    for level in 0.. {
        let scale = Scale::new(level, period_s);
        let block_s = scale.block as f64 * period_s;
        if block_s > LONGEST_BLOCK_S || 4 * scale.window > n || has_reference && block_s > VIBRATION_BLOCK_S {
            break;
        }
        let energies: Vec<Vec<f64>> =
            in_parallel(&means, |means| scale.log_energy(means, &recording.segments));
        let is_vibration = level == 0 || block_s <= VIBRATION_BLOCK_S;
        let usual: Vec<Usual> = match is_vibration {
            true => {
                leaking.clear();
                let piece = (PIECE_S / (scale.stride as f64 * period_s)).ceil() as usize;
                in_parallel(&energies, |energy| {
                    Usual::about(local_level(energy, piece), vec![false; energy.len()], energy)
                })
            }
            false => energies
                .iter()
                .zip(&leaking)
                .map(|(energy, leak)| usual_motion(&scale, energy, leak))
                .collect(),
        };
        let excess = |window: usize| {
            usual.iter().zip(&energies).map(move |(usual, energy)| usual.excess(window, energy[window]))
        };
        let mut score: Vec<f64> = (0..energies[0].len()).map(|window| sum_but_most(excess(window))).collect();
        let axes = Axes { scale, means: &means, energies: &energies, usual: &usual };
        explained.extend(explained::lower_explained_scores(recording, &axes, &causes, &mut score));
        mark(&mut moved, &scale, &score);
        drop((energies, score));
        if is_vibration {
            leaking = usual.into_iter().map(|usual| (scale, above_least(usual.level))).collect();
            mark_shaken(&mut shaken, &scale, &leaking, SHAKEN);
            mark_shaken(&mut violent, &scale, &leaking, VIOLENT);
        }
        // stretches found already are removed: a knock within the mean of a second would mark the seconds around it
        // as well
        let found = runs(0..n, |row| moved[row]);
        means = in_parallel(means, |mut means| {
            found.iter().for_each(|rows| scale.forget(&mut means, rows));
            scale.doubled(means)
        });
    }
    let joined = (MERGE_S / period_s) as usize;
    let mut lasting = stretches(&shaken, (PIECE_S / period_s) as usize);
    let lasts = |rows: &Range<usize>| rows.len() as f64 * period_s >= LASTING_S;
    // a large excess that ends sooner is an event, although its middle raised the local level
    let events = stretches(&violent, joined);
    events.iter().filter(|rows| !lasts(rows)).for_each(|rows| moved[rows.clone()].fill(true));
    lasting.retain(lasts);
    Shared {
        moved: stretches(&moved, joined),
        shaken: lasting,
        explained: explained::joined(explained, joined),
    }
}

/// Usual energy on a scale of motion: that of the windows without vibration, plus at most as much as the vibration exceeds
/// its minimum. Only these windows determine it: a shaker that runs for most of a log hardly reaches the slow scales, and
/// its pauses are no motion.
fn usual_motion(scale: &Scale, log_energy: &[f64], (of, leak): &(Scale, Vec<f64>)) -> Usual {
    let leak_at = |window: usize| leak[(window * scale.stride / of.stride).min(leak.len() - 1)];
    let windows = 0..log_energy.len();
    let is_shaken: Vec<bool> = windows.clone().map(|window| leak_at(window) > SHAKEN).collect();
    let steady = windows.clone().filter(|window| !is_shaken[*window]);
    let middle =
        median_of_known(&steady.map(|window| log_energy[window] - leak_at(window)).collect::<Vec<_>>());
    Usual::about(windows.map(|window| middle + leak_at(window)).collect(), is_shaken, log_energy)
}

/// Marks the middle half of windows above the limit, of their neighbours while these have an excess too, and a margin on
/// either side: a filter rings. An excess in the outer quarters of a window is larger in the next one.
fn mark(moved: &mut [bool], scale: &Scale, score: &[f64]) {
    let mut window = 0;
    while window < score.len() {
        if score[window] < FAR {
            window += 1;
            continue;
        }
        let mut first = window;
        while first > 0 && score[first - 1] >= NEAR {
            first -= 1;
        }
        let mut end = window + 1;
        while end < score.len() && score[end] >= NEAR {
            end += 1;
        }
        // a large event rings for longer than its excess shows
        let most = score[first..end].iter().copied().fold(FAR, f64::max);
        let margin = (scale.margin as f64 * (1.0 + (most / FAR).log10())) as usize;
        let (start, until) =
            (scale.rows(first).start + scale.window / 4, scale.rows(end - 1).end - scale.window / 4);
        // no window begins before the first or ends after the last
        let start = if first == 0 { 0 } else { start.saturating_sub(margin) };
        let until = if end == score.len() { moved.len() } else { (until + margin).min(moved.len()) };
        moved[start..until].fill(true);
        window = end;
    }
}

/// Excess of a level above that of its quietest tenth.
fn above_least(mut level: Vec<f64>) -> Vec<f64> {
    let mut known: Vec<f64> = level.iter().copied().filter(|level| level.is_finite()).collect();
    let tenth = known.len() / 10;
    let least = match known.is_empty() {
        true => 0.0,
        false => *known.select_nth_unstable_by(tenth, f64::total_cmp).1,
    };
    for level in &mut level {
        *level = if level.is_finite() { (*level - least).max(0.0) } else { 0.0 };
    }
    level
}

/// Marks windows in which at least two axes exceed `least` at once.
fn mark_shaken(shaken: &mut [bool], scale: &Scale, axes: &[(Scale, Vec<f64>)], least: f64) {
    for window in 0..axes[0].1.len() {
        if axes.iter().filter(|(_, above)| above[window] > least).count() >= 2 {
            let rows = scale.rows(window);
            let middle = rows.start + (scale.window - scale.stride) / 2;
            let start = if window == 0 { 0 } else { middle };
            let end = if window + 1 == axes[0].1.len() { shaken.len() } else { middle + scale.stride };
            shaken[start..end].fill(true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The usual energy was too low by the excess of the vibration, and the pauses of a shaker were excluded as sway.
    #[test]
    fn pauses_of_vibration_are_usual() {
        let scale = Scale::new(6, 0.005);
        let leak: Vec<f64> = (0..100).map(|window| if window % 5 == 0 { 0.0 } else { 3.0 }).collect();
        let energy: Vec<f64> = (0..100).map(|window| 0.01 * f64::from(window % 7)).collect();
        let usual = usual_motion(&scale, &energy, &(scale, leak));
        for window in (0..100).step_by(5) {
            assert!((usual.level[window] - 0.03).abs() < 0.011, "{}", usual.level[window]);
            assert!(usual.excess(window, energy[window]) < 1.0);
        }
    }
}
