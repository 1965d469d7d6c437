//! Shared steps of the axes that follow a logged channel: a supply that dips shifts all of them, and nothing moves.
//!
//! The second differences of the axes are regressed on those of the channel, one block before, at, and after each
//! block: a filter delays one of them. Each window is predicted with coefficients of the others, so that a motion that
//! coincides by chance with a change of the channel is not explained: the other changes predict another size, or none.
//! A channel that changes once explains nothing.

use std::ops::Range;

use super::scale::{FAR, NEAR, Scale, Usual, log_mean, median_of_known, sum_but_most};
use crate::column::{AXES, Column};
use crate::recording::{Recording, back_filled};
use crate::statistics::MAD_TO_SD;
use crate::unit::Unit;

/// A channel changes if its second difference exceeds this many standard deviations of the channel's noise: noise alone does
/// so once in 16,000 blocks.
const MIN_SIGMAS: f64 = 4.0;

/// Minimum reduction of the shared excess by the prediction. Chance does not reach it: a prediction from unrelated
/// windows adds to the energy.
const MIN_REDUCTION: f64 = 0.25;

/// Coefficients of an axis: of the previous block, of the block, of the next one.
const TAPS: usize = 3;

/// The axes on one time scale.
pub(super) struct Axes<'a> {
    pub(super) scale: Scale,
    pub(super) means: &'a [Vec<f64>],
    pub(super) energies: &'a [Vec<f64>],
    pub(super) usual: &'a [Usual],
}

/// Rows whose shared excess a channel explains.
#[derive(Debug)]
pub(super) struct Explained {
    pub(super) channel: String,
    pub(super) rows: Range<usize>,
}

/// Merges stretches of one channel that are less than `within` rows apart.
pub(super) fn joined(mut all: Vec<Explained>, within: usize) -> Vec<Explained> {
    all.sort_by(|one, other| (&one.channel, one.rows.start).cmp(&(&other.channel, other.rows.start)));
    let mut stretches: Vec<Explained> = Vec::new();
    for one in all {
        match stretches.last_mut() {
            Some(last) if last.channel == one.channel && one.rows.start < last.rows.end + within => {
                last.rows.end = last.rows.end.max(one.rows.end);
            }
            _ => stretches.push(one),
        }
    }
    stretches
}

/// Names of the channels that may cause an error: neither moving with the device, as a magnetometer does, nor computed
/// from the axes.
pub(super) fn possible_causes(recording: &Recording) -> Vec<&str> {
    let may_cause = |name: &str| {
        let column = Column::named(name);
        let moves_along = matches!(
            column.unit(),
            Unit::MetrePerSecondSquared | Unit::RadianPerSecond | Unit::Microtesla | Unit::Second
        );
        !(moves_along || AXES.contains(&name) || column.measured().is_some() || column.is_of_model())
    };
    recording.channels().iter().map(|channel| &channel.name[..]).filter(|name| may_cause(name)).collect()
}

/// Lowers the score of the windows that one of `causes` explains.
pub(super) fn lower_explained_scores(
    recording: &Recording,
    axes: &Axes<'_>,
    causes: &[&str],
    score: &mut [f64],
) -> Vec<Explained> {
    let mut explained = Vec::new();
    for name in causes {
        if !score.iter().any(|score| *score >= FAR) {
            break;
        }
        let Some(changes) = Changes::of(recording, name, &axes.scale) else { continue };
        let suspects: Vec<usize> = (0..score.len())
            .filter(|window| score[*window] >= NEAR && changes.in_rows(axes.scale.rows(*window)))
            .collect();
        if !suspects.iter().any(|window| score[*window] >= FAR) {
            continue;
        }
        let folds: Vec<Vec<Fold>> = (0..axes.means.len()).map(|axis| changes.folds(axes, axis)).collect();
        for window in suspects {
            let rows = axes.scale.rows(window);
            let excess = (0..axes.means.len()).map(|axis| {
                let coefficients = coefficients(&folds[axis], &rows, axes.scale.window);
                let energy = match coefficients {
                    Some(coefficients) => {
                        changes.energy_without(&axes.means[axis], rows.clone(), coefficients)
                    }
                    None => axes.energies[axis][window],
                };
                axes.usual[axis].excess(window, energy)
            });
            let remaining = sum_but_most(excess);
            if remaining < FAR && remaining < MIN_REDUCTION * score[window] {
                if score[window] >= FAR {
                    explained.push(Explained { channel: (*name).to_owned(), rows });
                }
                score[window] = remaining;
            }
        }
    }
    explained
}

/// Changes of a channel on one time scale.
struct Changes<'a> {
    recording: &'a Recording,
    scale: Scale,
    /// Second difference where it stands out or is next to one that does, else 0.
    of_row: Vec<f64>,
}

/// Normal equations of the rows of a window-length piece.
struct Fold {
    rows: Range<usize>,
    normal: [[f64; TAPS]; TAPS],
    right: [f64; TAPS],
}

impl<'a> Changes<'a> {
    /// `None` if nothing stands out.
    fn of(recording: &'a Recording, name: &str, scale: &Scale) -> Option<Self> {
        let n = recording.n_rows();
        let mut means = recording.channel(name).ok()?.values.to_vec();
        back_filled(&mut means);
        let mut shorter = 1;
        while shorter < scale.block {
            means = Scale { block: shorter, ..*scale }.doubled(means);
            shorter *= 2;
        }
        let mut second = vec![0.0; n];
        for segment in &recording.segments {
            for row in scale.inner(segment) {
                let difference = scale.second_difference(&means, row);
                second[row] = if difference.is_finite() { difference } else { 0.0 };
            }
        }
        let sizes: Vec<f64> = second.iter().step_by(scale.stride).map(|value| value.abs()).collect();
        let largest = means
            .iter()
            .copied()
            .filter(|mean| mean.is_finite())
            .fold(0.0, |most: f64, mean| most.max(mean.abs()));
        // a sum of equal values may be off by rounding
        let limit = (MIN_SIGMAS * MAD_TO_SD * median_of_known(&sizes)).max(1e-9 * largest);
        let mut of_row = vec![0.0; n];
        let mut end = 0;
        for row in (0..n).filter(|row| second[*row].abs() > limit) {
            let beside = row.saturating_sub(scale.block).max(end)..(row + scale.block + 1).min(n);
            end = beside.end.max(end);
            of_row[beside.clone()].copy_from_slice(&second[beside]);
        }
        (end > 0).then_some(Self { recording, scale: *scale, of_row })
    }

    fn in_rows(&self, rows: Range<usize>) -> bool {
        self.of_row[rows].iter().any(|change| *change != 0.0)
    }

    fn taps(&self, row: usize) -> [f64; TAPS] {
        let block = self.scale.block;
        [self.of_row[row - block], self.of_row[row], self.of_row[row + block]]
    }

    /// Rows within `rows` with their taps and the second difference of an axis.
    fn equations<'b>(
        &'b self,
        means: &'b [f64],
        rows: Range<usize>,
    ) -> impl Iterator<Item = (usize, [f64; TAPS], f64)> + 'b {
        let segments = self.recording.segments.iter().map(move |segment| {
            let inner = self.scale.inner(segment);
            inner.start.max(rows.start)..inner.end.min(rows.end)
        });
        segments.flatten().filter_map(|row| {
            let second = self.scale.second_difference(means, row);
            second.is_finite().then(|| (row, self.taps(row), second))
        })
    }

    /// Normal equations of an axis. A piece is weighted down by its energy: one with motion hardly counts.
    fn folds(&self, axes: &Axes<'_>, axis: usize) -> Vec<Fold> {
        let length = axes.scale.window;
        let mut folds: Vec<Fold> = Vec::new();
        for (row, taps, second) in self.equations(&axes.means[axis], 0..self.of_row.len()) {
            if taps == [0.0; TAPS] {
                continue;
            }
            let start = row / length * length;
            let window = (start / axes.scale.stride).min(axes.energies[axis].len() - 1);
            let weight = (-axes.energies[axis][window]).exp();
            if !weight.is_finite() {
                continue;
            }
            if folds.last().is_none_or(|last| last.rows.start != start) {
                let rows = start..start + length;
                folds.push(Fold { rows, normal: [[0.0; TAPS]; TAPS], right: [0.0; TAPS] });
            }
            let Some(fold) = folds.last_mut() else { continue };
            for i in 0..TAPS {
                fold.right[i] += weight * taps[i] * second;
                (0..TAPS).for_each(|j| fold.normal[i][j] += weight * taps[i] * taps[j]);
            }
        }
        folds
    }

    /// ln of the energy of an axis in a window after subtraction of the channel's share.
    fn energy_without(&self, means: &[f64], rows: Range<usize>, coefficients: [f64; TAPS]) -> f64 {
        let length = rows.len();
        let (mut sum, mut count) = (0.0, 0);
        for (_, taps, second) in self.equations(means, rows) {
            let predicted: f64 =
                taps.iter().zip(coefficients).map(|(tap, coefficient)| tap * coefficient).sum();
            sum += (second - predicted).powi(2);
            count += 1;
        }
        log_mean(sum, count, length)
    }
}

/// Coefficients of an axis from all pieces at least a window's length away from these rows; `None` if the channel does
/// not change in any of them.
fn coefficients(folds: &[Fold], rows: &Range<usize>, apart: usize) -> Option<[f64; TAPS]> {
    let is_apart = |fold: &&Fold| fold.rows.start >= rows.end + apart || fold.rows.end + apart <= rows.start;
    let (mut normal, mut right) = ([[0.0; TAPS]; TAPS], [0.0; TAPS]);
    for fold in folds.iter().filter(is_apart) {
        for i in 0..TAPS {
            right[i] += fold.right[i];
            (0..TAPS).for_each(|j| normal[i][j] += fold.normal[i][j]);
        }
    }
    let trace: f64 = (0..TAPS).map(|i| normal[i][i]).sum();
    if trace <= 0.0 {
        return None;
    }
    // taps of a slow change are nearly collinear: a ridge shares their common part among them
    (0..TAPS).for_each(|i| normal[i][i] += 1e-6 * trace);
    Some(solved(normal, right))
}

/// Solution of a positive definite system by elimination.
fn solved(mut a: [[f64; TAPS]; TAPS], mut b: [f64; TAPS]) -> [f64; TAPS] {
    for i in 0..TAPS {
        for j in i + 1..TAPS {
            let factor = a[j][i] / a[i][i];
            (i..TAPS).for_each(|k| a[j][k] -= factor * a[i][k]);
            b[j] -= factor * b[i];
        }
    }
    for i in (0..TAPS).rev() {
        let known: f64 = (i + 1..TAPS).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}
