//! Minimum and profile intervals of −2 ln L over the logarithms of three parameters of a noise process.
//!
//! A search starts with the expected second derivatives, 2 Σ ∂ln S/∂θ_i · ∂ln S/∂θ_j over the frequencies of the block
//! means (Whittle 1953), which are close to the true ones and cost no evaluation of the likelihood.

use nalgebra::Matrix3;

use super::information::information;
use super::level::RISE;
use super::levels::{LogLevels, minimise_from};

/// Distance below the estimate, in logarithms, at which a process counts as absent: if the profile is within [`RISE`]
/// there, the process was not detected.
const ABSENT_BELOW: f64 = 12.0;

/// Largest distance of an interval's end from the value, in logarithms.
const MAX_DISTANCE: f64 = 16.0;

/// Accuracy of −2 ln L at an interval's end, 0.4 % of the width; and of the end's logarithm.
const EXACT_RISE: f64 = 0.02;
const EXACT: f64 = 1e-4;

/// Decrease of −2 ln L by a step after which a search ends: the next would gain less than a tenth of it.
const ENOUGH: f64 = 0.02;

/// Added to the expected curvature, which is 0 for an absent process: that of a parameter known within a factor of 7.
const LEAST_CURVATURE: f64 = 0.5;

/// Largest derivative of another parameter along a profile: a longer extrapolation would be worthless.
const STEEPEST: f64 = 3.0;

/// Shortest and longest first step from the estimate to the end of an interval, in logarithms.
const FIRST_STEP: [f64; 2] = [0.005, 1.0];

/// Ratio of a step beyond the expected end to the distance of that end, so that it lies outside; and its limits as a multiple
/// of the distance reached.
const BEYOND: f64 = 1.05;
const LONGER: [f64; 2] = [1.1, 3.0];

/// −2 ln L as a function of three logarithms.
pub(super) struct Profile<F, S> {
    /// −2 ln L.
    pub(super) deviance: F,
    /// Derivatives of the logarithm of the spectral density by the parameters, at a frequency in Hz.
    pub(super) slopes: S,
    /// Frequencies of the block means, Hz, and the number of frequencies that each stands for.
    pub(super) frequencies: Vec<(f64, f64)>,
}

/// Position of the minimum, and the inverse of the expected second derivatives there.
pub(super) struct Best {
    pub(super) logs: LogLevels,
    pub(super) deviance: f64,
    inverse: Matrix3<f64>,
}

/// Ends of the 90 % interval of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    /// Lower end; none if the interval reaches zero.
    pub(super) low: Option<f64>,
    /// Logarithms of all parameters there.
    pub(super) at_low: Option<LogLevels>,
    pub(super) high: f64,
}

/// Minimum along the profile of a parameter: the last position, and the derivatives of all by this one there.
#[derive(Clone)]
struct Track {
    logs: LogLevels,
    slopes: LogLevels,
}

impl<F: Fn(&LogLevels) -> f64, S: Fn(&LogLevels, f64) -> LogLevels> Profile<F, S> {
    /// Finds the minimum from several starts, as two processes may be mistaken for each other.
    pub(super) fn best(&self, starts: &[LogLevels]) -> Best {
        let found = starts.iter().map(|start| self.minimum([0, 1, 2], *start));
        let (logs, deviance) = found.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a start");
        Best { logs, deviance, inverse: self.inverse(&logs) }
    }

    /// Inverse of the expected second derivatives.
    fn inverse(&self, logs: &LogLevels) -> Matrix3<f64> {
        let slopes = |frequency_hz| (self.slopes)(logs, frequency_hz);
        let curvature = 2.0 * information(slopes, self.frequencies.iter().copied())
            + Matrix3::from_diagonal_element(LEAST_CURVATURE);
        curvature.try_inverse().unwrap_or_else(|| Matrix3::from_diagonal_element(1.0 / LEAST_CURVATURE))
    }

    /// Minimises −2 ln L over the `free` parameters.
    fn minimum<const D: usize>(&self, free: [usize; D], start: LogLevels) -> (LogLevels, f64) {
        let whole = |own: &[f64; D]| {
            let mut logs = start;
            free.iter().zip(own).for_each(|(parameter, log)| logs[*parameter] = *log);
            logs
        };
        let inverse = self.inverse(&start);
        // the parameters that are not free are known: their rows are projected out
        let known = (0..3).find(|parameter| !free.contains(parameter));
        let conditional = |i: usize, j: usize| match known {
            Some(known) => {
                inverse[(i, j)] - inverse[(i, known)] * inverse[(known, j)] / inverse[(known, known)]
            }
            None => inverse[(i, j)],
        };
        let inverse = free.map(|i| free.map(|j| conditional(i, j)));
        let own = free.map(|parameter| start[parameter]);
        let (own, least) = minimise_from(own, inverse, ENOUGH, |own| (self.deviance)(&whole(own)));
        (whole(&own), least)
    }

    /// Returns −2 ln L at a value of one parameter, minimised over the other two.
    fn profile(&self, parameter: usize, log: f64, track: &mut Track) -> f64 {
        let others = [[1, 2], [0, 2], [0, 1]][parameter];
        let (logs, deviance) = self.minimum(others, track.at(parameter, log));
        track.push(parameter, logs);
        deviance
    }

    /// Returns the 90 % interval of a parameter.
    pub(super) fn interval(&self, parameter: usize, best: &Best) -> Interval {
        let start = Track {
            logs: best.logs,
            slopes: std::array::from_fn(|i| {
                (best.inverse[(i, parameter)] / best.inverse[(parameter, parameter)])
                    .clamp(-STEEPEST, STEEPEST)
            }),
        };
        let centre = best.logs[parameter];
        let first =
            (2.0 * RISE * best.inverse[(parameter, parameter)]).sqrt().clamp(FIRST_STEP[0], FIRST_STEP[1]);
        let rise = |log: f64, track: &mut Track| self.profile(parameter, log, track) - best.deviance - RISE;
        let end = |direction: f64| -> Option<Track> {
            let mut track = start.clone();
            let (mut inside, mut below, mut log) = (centre, -RISE, centre + direction * first);
            // terminates: the distance grows by at least a tenth
            let (mut outside, mut above) = loop {
                if (log - centre).abs() > MAX_DISTANCE {
                    return None;
                }
                match rise(log, &mut track) {
                    there if there.abs() < EXACT_RISE => return Some(track),
                    there if there > 0.0 => break (log, there),
                    there => (inside, below) = (log, there),
                }
                // the increase is nearly a parabola
                let expected = (RISE / (below + RISE).max(f64::MIN_POSITIVE)).sqrt();
                log = centre + (inside - centre) * (BEYOND * expected).clamp(LONGER[0], LONGER[1]);
            };
            // terminates: the bracket shrinks by at least a twentieth
            while (outside - inside).abs() > EXACT {
                // the root of the increase is nearly linear, as the increase is nearly a parabola
                let [below_root, above_root] =
                    [below, above].map(|rise| (rise + RISE).max(0.0).sqrt() - RISE.sqrt());
                let share = (-below_root / (above_root - below_root)).clamp(0.05, 0.95);
                let log = inside + share * (outside - inside);
                match rise(log, &mut track) {
                    there if there.abs() < EXACT_RISE => return Some(track),
                    there if there > 0.0 => (outside, above) = (log, there),
                    there => (inside, below) = (log, there),
                }
            }
            Some(track)
        };
        let high = end(1.0).map_or(centre + MAX_DISTANCE, |end| end.logs[parameter]).exp();
        // the others do not follow a parameter that far
        let mut absent = Track { slopes: [0.0; 3], ..start.clone() };
        let may_be_none = rise(centre - ABSENT_BELOW, &mut absent) <= 0.0;
        let at_low = if may_be_none { None } else { end(-1.0) }.map(|end| end.logs);
        Interval { low: at_low.map(|logs| logs[parameter].exp()), at_low, high }
    }
}

impl Track {
    /// Predicts all parameters at a value of this one.
    fn at(&self, parameter: usize, log: f64) -> LogLevels {
        let moved = log - self.logs[parameter];
        let mut logs: LogLevels = std::array::from_fn(|i| self.logs[i] + self.slopes[i] * moved);
        logs[parameter] = log;
        logs
    }

    fn push(&mut self, parameter: usize, logs: LogLevels) {
        let moved = logs[parameter] - self.logs[parameter];
        if moved.abs() > EXACT {
            self.slopes =
                std::array::from_fn(|i| ((logs[i] - self.logs[i]) / moved).clamp(-STEEPEST, STEEPEST));
        }
        self.logs = logs;
    }
}
