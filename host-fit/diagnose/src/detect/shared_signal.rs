//! Slow signal that several axes share after all findings are subtracted: one cause that is not logged, for example an
//! unlogged temperature.
//!
//! Independent noise is uncorrelated between axes, and so are the changes of random walks from one mean to the next,
//! but not the walks themselves. Therefore changes are compared (Granger and Newbold 1974, spurious regressions).

use nalgebra::{DMatrix, SymmetricEigen};

use super::answer::{Diagnosis, Finding, SharedSignal, Verdict};
use super::correction::correction;
use super::error_in_blocks::ErrorInBlocks;
use super::findings::listed;
use fos_data::column::{AXES, Column};
use fos_data::disturbance;
use fos_data::interrupt::in_parallel;
use fos_data::recording::{Recording, RecordingError};
use fos_fit::evaluate::SLOW_BLOCK_S;
use fos_fit::noise::{combination, dot};

/// Numbers of means that a log is divided into, from fine to coarse: a fast signal needs many, a slow one under much
/// white noise needs few.
const MEANS: [f64; 3] = [400.0, 200.0, 100.0];

/// Standard errors that a correlation must exceed; noise alone does so once in 100,000 axes.
const STANDARD_ERRORS: f64 = 4.5;

/// Changes of white noise are correlated with their neighbours by −½, which increases the variance of a correlation.
const VARIANCE_OF_WHITE: f64 = 1.5;

/// Least number of axes that share a signal: two may be one cause seen twice, as under a tilt.
const MIN_AXES: usize = 3;

/// Clipping limit of changes, in standard deviations: one shock in all axes is not a slow signal.
const CLIP_AT: f64 = 3.0;

/// Axes in the same blocks of a log.
struct Together {
    axes: Vec<String>,
    /// Middle of each block, s.
    time_s: Vec<f64>,
    /// Mean of the residual of each axis in each block, about its level.
    means: Vec<Vec<f64>>,
    /// Blocks whose change from the block before is known.
    changes: Vec<usize>,
    mean_s: f64,
}

/// Adds to the diagnoses of a log the slow signal that their axes share. If nothing else explains an axis, its verdict
/// becomes *unexplained* by this signal.
pub fn with_shared_signal(
    mut answers: Vec<Diagnosis>,
    recording: &Recording,
) -> Result<Vec<Diagnosis>, RecordingError> {
    let axes: Vec<(&str, &[Finding])> =
        answers.iter().map(|answer| (answer.target.as_str(), answer.findings.as_slice())).collect();
    let Some(signal) = shared_signal(&axes, recording)? else { return Ok(answers) };
    for answer in &mut answers {
        if !signal.axes.contains(&answer.target) {
            continue;
        }
        let is_open = matches!(answer.verdict, Verdict::NothingMissing | Verdict::Unexplained);
        if is_open && answer.findings.iter().all(|finding| finding.doubt.is_some()) {
            answer.verdict = Verdict::Unexplained;
            answer.sentence = signal.sentence(&answer.target, recording);
        }
        answer.notes.push(signal.describe(recording));
        answer.shared_signal = Some(signal.clone());
    }
    Ok(answers)
}

impl SharedSignal {
    fn sentence(&self, target: &str, recording: &Recording) -> String {
        let others = self.axes.iter().filter(|axis| *axis != target);
        format!(
            "Something is missing that is not logged: a slow signal is common to this axis and {}. {}",
            listed(others.cloned()),
            advice(recording)
        )
    }

    /// Describes the shared signal as a remark on one of its axes.
    fn describe(&self, recording: &Recording) -> String {
        let bounds = self
            .correlations
            .iter()
            .fold([1.0_f64, 0.0_f64], |[low, high], one| [low.min(*one), high.max(*one)]);
        format!(
            "shares a slow signal with other axes that no finding explains (correlation {:.2} … {:.2} of the changes of {:.0}-s means). {}",
            bounds[0],
            bounds[1],
            self.mean_s,
            advice(recording)
        )
    }
}

/// Advises to log the columns that would show a common cause.
fn advice(recording: &Recording) -> String {
    let missing: Vec<&str> =
        ["temp_c", "supply_v"].into_iter().filter(|column| recording.channel(column).is_err()).collect();
    match missing[..] {
        [] => "Neither temp_c nor supply_v explains it.".to_owned(),
        _ => format!("Probably temperature or supply voltage: log {}.", missing.join(" and ")),
    }
}

/// Returns the signal that axes share after the findings of each are subtracted.
fn shared_signal(
    axes: &[(&str, &[Finding])],
    recording: &Recording,
) -> Result<Option<SharedSignal>, RecordingError> {
    let inertial: Vec<(&str, &[Finding])> =
        axes.iter().copied().filter(|(axis, _)| AXES.contains(axis)).collect();
    if inertial.len() < MIN_AXES {
        return Ok(None);
    }
    let at_rest = &*disturbance::marked(recording).0;
    let lengths_s = MEANS.map(|means| (at_rest.duration_s() / means).max(SLOW_BLOCK_S));
    let means: Vec<[Means; MEANS.len()]> =
        in_parallel(&inertial, |(axis, findings)| Means::of(axis, findings, at_rest, lengths_s))
            .into_iter()
            .collect::<Result<_, _>>()?;
    let mut best: Option<SharedSignal> = None;
    let strength = |signal: &SharedSignal| signal.correlations.iter().sum::<f64>();
    for (at, mean_s) in lengths_s.into_iter().enumerate() {
        let axes = inertial.iter().zip(&means).map(|((axis, _), means)| (*axis, &means[at]));
        let signal = Together::new(&axes.collect::<Vec<_>>(), mean_s).signal();
        let signal =
            signal.filter(|signal| best.as_ref().is_none_or(|best| strength(best) < strength(signal)));
        best = signal.or(best);
    }
    Ok(best)
}

/// Means of the residual of an axis over blocks of one length.
struct Means {
    /// Index of each block, ascending.
    index: Vec<u64>,
    /// Means about the level of each orientation.
    values: Vec<f64>,
    /// Blocks, as positions in these lists, at which another level begins.
    restarts: Vec<usize>,
}

impl Means {
    /// Computes the means for each length, s.
    fn of<const N: usize>(
        axis: &str,
        findings: &[Finding],
        recording: &Recording,
        lengths_s: [f64; N],
    ) -> Result<[Self; N], RecordingError> {
        let found = correction(findings, recording, recording)?;
        let mut by_length = Vec::with_capacity(N);
        for length_s in lengths_s {
            let ErrorInBlocks { blocks, error, .. } =
                ErrorInBlocks::in_blocks_of(recording, axis, &[], length_s)?;
            let left: Vec<f64> = error.iter().zip(&found).map(|(error, found)| error - found).collect();
            let means = blocks.means(&left);
            by_length.push(Self {
                index: blocks.blocks.iter().map(|block| block.index).collect(),
                values: blocks.about_levels(&means, 0..means.len()),
                restarts: blocks.restarts().to_vec(),
            });
        }
        let mut by_length = by_length.into_iter();
        Ok(std::array::from_fn(|_| by_length.next().expect("one for each length")))
    }
}

impl Together {
    fn new(axes: &[(&str, &Means)], mean_s: f64) -> Self {
        let mut together = Self {
            axes: axes.iter().map(|(axis, _)| (*axis).to_owned()).collect(),
            time_s: Vec::new(),
            means: vec![Vec::new(); axes.len()],
            changes: Vec::new(),
            mean_s,
        };
        let mut before = None;
        for index in axes.first().into_iter().flat_map(|(_, means)| means.index.iter().copied()) {
            let places = axes.iter().map(|(_, means)| means.index.binary_search(&index).ok());
            let Some(places) = places.collect::<Option<Vec<usize>>>() else { continue };
            let restarts = axes.iter().zip(&places).any(|((_, means), place)| means.restarts.contains(place));
            if before == Some(index.wrapping_sub(1)) && !restarts {
                together.changes.push(together.time_s.len());
            }
            together.time_s.push((index as f64 + 0.5) * mean_s);
            for ((known, (_, means)), place) in together.means.iter_mut().zip(axes).zip(&places) {
                known.push(means.values[*place]);
            }
            before = Some(index);
        }
        together
    }

    /// Returns the changes of an axis from one mean to the next.
    fn changes(&self, axis: usize) -> Vec<f64> {
        let means = &self.means[axis];
        self.changes.iter().map(|at| means[*at] - means[at - 1]).collect()
    }

    /// Returns the changes in standard deviations, clipped to [`CLIP_AT`].
    fn standardised(&self, axis: usize) -> Vec<f64> {
        let changes = self.changes(axis);
        let most = CLIP_AT * rms(&changes);
        // no `clamp`, which panics if an unknown mean makes the limit NaN
        let limited: Vec<f64> = changes.iter().map(|change| change.max(-most).min(most)).collect();
        let deviation = rms(&limited);
        limited.iter().map(|change| change / deviation).collect()
    }

    /// Returns the signal if enough axes share one, a gyro among them: accelerometers alone may have been tilted.
    fn signal(&self) -> Option<SharedSignal> {
        let n = self.changes.len() as f64;
        let changes: Vec<Vec<f64>> = (0..self.axes.len()).map(|axis| self.standardised(axis)).collect();
        let known: Vec<usize> = (0..changes.len())
            .filter(|axis| changes[*axis].iter().all(|change| change.is_finite()))
            .collect();
        let least = STANDARD_ERRORS * (VARIANCE_OF_WHITE / n.max(1.0)).sqrt();
        if known.len() < MIN_AXES || least >= 1.0 {
            return None;
        }
        let correlation = |axis: &usize| -> f64 {
            let others: Vec<usize> = known.iter().copied().filter(|other| other != axis).collect();
            let common = combination(&changes, &weights(&changes, &others), self.changes.len());
            dot(&changes[*axis], &common).abs() / (n * dot(&common, &common)).sqrt()
        };
        let sharing: Vec<(usize, f64)> =
            known.iter().map(|axis| (*axis, correlation(axis))).filter(|(_, one)| *one > least).collect();
        let axes: Vec<usize> = sharing.iter().map(|(axis, _)| *axis).collect();
        let has_gyro = axes.iter().any(|axis| Column::named(&self.axes[*axis]).is_angular_rate());
        if axes.len() < MIN_AXES || !has_gyro {
            return None;
        }
        let course = combination(&self.means, &self.scaled(&weights(&changes, &axes)), self.time_s.len());
        let deviation = rms(&course);
        Some(SharedSignal {
            axes: axes.iter().map(|axis| self.axes[*axis].clone()).collect(),
            correlations: sharing.iter().map(|(_, one)| *one).collect(),
            mean_s: self.mean_s,
            course: self.time_s.iter().zip(course).map(|(time, value)| [*time, value / deviation]).collect(),
        })
    }

    /// Converts weights of standardised changes to weights of means.
    fn scaled(&self, weights: &[f64]) -> Vec<f64> {
        weights
            .iter()
            .enumerate()
            .map(|(axis, weight)| if *weight == 0.0 { 0.0 } else { weight / rms(&self.changes(axis)) })
            .collect()
    }
}

fn rms(values: &[f64]) -> f64 {
    (dot(values, values) / values.len() as f64).sqrt()
}

/// Weights of the first principal component of the columns `of`; 0 for the others.
fn weights(columns: &[Vec<f64>], of: &[usize]) -> Vec<f64> {
    let products = DMatrix::from_fn(of.len(), of.len(), |i, j| dot(&columns[of[i]], &columns[of[j]]));
    let eigen = SymmetricEigen::new(products);
    let first = eigen.eigenvalues.imax();
    let mut weights = vec![0.0; columns.len()];
    for (place, axis) in of.iter().enumerate() {
        weights[*axis] = eigen.eigenvectors[(place, first)];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Half an hour of six axes at 10 Hz with independent white noise and random walks; the first `sharing` axes also
    /// have a common walk with steps of size `common`.
    fn log(seed: u64, common: f64, sharing: usize) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let n = 18_000;
        let mut white = |size: f64| -> Vec<f64> {
            (0..n)
                .map(|_| {
                    let unit: f64 = StandardNormal.sample(&mut random);
                    size * unit
                })
                .collect()
        };
        let walk = |steps: Vec<f64>| -> Vec<f64> {
            steps
                .iter()
                .scan(0.0, |level, step| {
                    *level += step;
                    Some(*level)
                })
                .collect()
        };
        let shared = walk(white(common));
        let mut columns = vec![("t_s".to_owned(), (0..n).map(|row| row as f64 / 10.0).collect())];
        for (place, axis) in AXES.into_iter().enumerate() {
            let (mut values, own) = (white(1e-4), walk(white(3e-6)));
            values.iter_mut().zip(&own).for_each(|(value, own)| *value += own);
            if place < sharing {
                values.iter_mut().zip(&shared).for_each(|(value, shared)| *value -= shared);
            }
            columns.push((axis.to_owned(), values));
        }
        Recording::from_columns(Source::made_by("shared"), columns, &LoadOptions::default()).expect("a log")
    }

    fn found(log: &Recording) -> Option<SharedSignal> {
        shared_signal(&AXES.map(|axis| (axis, &[][..])), log).expect("its columns")
    }

    #[test]
    fn independent_walks_share_nothing() {
        for seed in 0..20 {
            assert_eq!(found(&log(seed, 0.0, 0)), None, "{seed}");
        }
    }

    #[test]
    fn finds_common_walk_in_affected_axes() {
        let signal = found(&log(1, 1e-5, 5)).expect("a common walk");
        assert_eq!(signal.axes, AXES[..5]);
        assert!(signal.correlations.iter().all(|correlation| *correlation > 0.5), "{signal:?}");
    }

    #[test]
    fn accelerometers_alone_share_no_signal() {
        assert_eq!(found(&log(1, 1e-5, 3)), None);
    }
}
