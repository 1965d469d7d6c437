//! Minimum and profile intervals of −2 ln L over the logarithms of three parameters of a noise process.

use super::levels::{LogLevels, hessian, minimise};

/// Increase of −2 ln L at the ends of an interval: the 90 % quantile of χ² with one degree of freedom.
pub(super) const RISE: f64 = 2.705_543;

/// Distance below the estimate, in logarithms, at which a process counts as absent: if the profile is within [`RISE`]
/// there, the process was not detected.
const ABSENT_BELOW: f64 = 12.0;

/// Largest distance of an interval's end from the value, in logarithms.
const MAX_DISTANCE: f64 = 16.0;

/// Accuracy of −2 ln L at an interval's end, 0.4 % of the width; and of the end's logarithm.
const EXACT_RISE: f64 = 0.02;
const EXACT: f64 = 1e-4;

/// Second derivative of −2 ln L that the search expects, of a level known to 20 %; and the longest unit of its steps.
const USUAL_CURVATURE: f64 = 50.0;
const LONGEST_UNIT: f64 = 6.0;

/// Least curvature of a parameter that is held fixed to none: a parameter known within a factor of 7.
const LEAST_CURVATURE: f64 = 0.5;

/// Largest derivative of another parameter along a profile: a longer extrapolation would be worthless.
const STEEPEST: f64 = 3.0;

/// Shortest and longest first step from the estimate to the end of an interval, in logarithms.
const FIRST_STEP: [f64; 2] = [0.005, 1.0];

/// −2 ln L as a function of three logarithms.
pub(super) struct Profile<F> {
    at: F,
}

/// Position of the minimum, and the shape of the function around it.
pub(super) struct Best {
    pub(super) logs: LogLevels,
    pub(super) deviance: f64,
    units: LogLevels,
    curvature: [[f64; 3]; 3],
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

/// The two other parameters along the profile of one: the last position, and their derivatives there.
#[derive(Clone)]
struct Track {
    log: f64,
    others: [f64; 2],
    slopes: [f64; 2],
}

impl Track {
    /// Predicts the others at a value of the parameter.
    fn others_at(&self, log: f64) -> [f64; 2] {
        std::array::from_fn(|i| self.others[i] + self.slopes[i] * (log - self.log))
    }

    fn push(&mut self, log: f64, others: [f64; 2]) {
        let moved = log - self.log;
        if moved.abs() > EXACT {
            self.slopes =
                std::array::from_fn(|i| ((others[i] - self.others[i]) / moved).clamp(-STEEPEST, STEEPEST));
        }
        (self.log, self.others) = (log, others);
    }
}

impl<F: Fn(&LogLevels) -> f64> Profile<F> {
    pub(super) fn new(at: F) -> Self {
        Self { at }
    }

    pub(super) fn at(&self, logs: &LogLevels) -> f64 {
        (self.at)(logs)
    }

    /// Finds the minimum from several starts, as two processes may be mistaken for each other.
    pub(super) fn best(&self, starts: &[LogLevels]) -> Best {
        let found = starts.iter().map(|start| minimise(*start, &self.at));
        let (logs, _) = found.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a start");
        let units = steps_of(&hessian(logs, &self.at));
        let (logs, deviance) = minimise_in(&units, logs, &self.at);
        let curvature = hessian(logs, &self.at);
        Best { logs, deviance, units: steps_of(&curvature), curvature }
    }
    /// Returns −2 ln L at a value of one parameter, minimised over the other two.
    fn profile(&self, parameter: usize, log: f64, track: &mut Track, units: &LogLevels) -> f64 {
        let units = without(parameter, units);
        let at = |others: &[f64; 2]| (self.at)(&with(parameter, log, others));
        let (others, deviance) = minimise_in(&units, track.others_at(log), at);
        track.push(log, others);
        deviance
    }

    /// Returns the 90 % interval of a parameter.
    pub(super) fn interval(&self, parameter: usize, best: &Best) -> Interval {
        let (track, curvature) = best.along(parameter);
        let centre = best.logs[parameter];
        let first = (2.0 * RISE / curvature).sqrt().clamp(FIRST_STEP[0], FIRST_STEP[1]);
        let rise = |log: f64, track: &mut Track| {
            self.profile(parameter, log, track, &best.units) - best.deviance - RISE
        };
        let end = |direction: f64| -> Option<Track> {
            let mut track = track.clone();
            let (mut inside, mut below, mut step) = (centre, -RISE, first);
            // terminates: the step doubles
            let (mut outside, mut above) = loop {
                let log = inside + direction * step;
                if (log - centre).abs() > MAX_DISTANCE {
                    return None;
                }
                match rise(log, &mut track) {
                    there if there.abs() < EXACT_RISE => return Some(track),
                    there if there > 0.0 => break (log, there),
                    there => (inside, below) = (log, there),
                }
                step *= 2.0;
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
        let high = end(1.0).map_or(centre + MAX_DISTANCE, |end| end.log).exp();
        // the others do not follow a parameter that far
        let mut absent = Track { slopes: [0.0; 2], ..track.clone() };
        let may_be_none = rise(centre - ABSENT_BELOW, &mut absent) <= 0.0;
        let low = if may_be_none { None } else { end(-1.0) };
        let at_low = low.as_ref().map(|end| with(parameter, end.log, &end.others));
        Interval { low: low.map(|end| end.log.exp()), at_low, high }
    }
}

impl Best {
    /// Returns how the other two parameters follow one near the minimum, and the second derivative of its profile.
    fn along(&self, parameter: usize) -> (Track, f64) {
        let c = &self.curvature;
        let [i, j] = without(parameter, &[0, 1, 2]);
        let own = |k: usize| c[k][k].max(LEAST_CURVATURE);
        let determinant = (own(i) * own(j) - c[i][j] * c[i][j]).max(LEAST_CURVATURE * LEAST_CURVATURE);
        let [towards_i, towards_j] = [c[i][parameter], c[j][parameter]];
        let slopes = [
            -(own(j) * towards_i - c[i][j] * towards_j) / determinant,
            -(own(i) * towards_j - c[i][j] * towards_i) / determinant,
        ]
        .map(|slope| slope.clamp(-STEEPEST, STEEPEST));
        let curvature = own(parameter) + slopes[0] * towards_i + slopes[1] * towards_j;
        let track = Track { log: self.logs[parameter], others: without(parameter, &self.logs), slopes };
        (track, curvature.max(LEAST_CURVATURE))
    }
}

/// Step sizes of the search: a poorly determined parameter needs long steps.
fn steps_of(curvature: &[[f64; 3]; 3]) -> LogLevels {
    std::array::from_fn(|i| {
        (USUAL_CURVATURE / curvature[i][i].max(f64::MIN_POSITIVE)).sqrt().clamp(0.5, LONGEST_UNIT)
    })
}

fn with(parameter: usize, log: f64, others: &[f64; 2]) -> LogLevels {
    let [one, other] = *others;
    match parameter {
        0 => [log, one, other],
        1 => [one, log, other],
        _ => [one, other, log],
    }
}

fn without<T: Copy>(parameter: usize, all: &[T; 3]) -> [T; 2] {
    match parameter {
        0 => [all[1], all[2]],
        1 => [all[0], all[2]],
        _ => [all[0], all[1]],
    }
}

/// Runs [`minimise`] in units of these step sizes.
fn minimise_in<const D: usize>(
    units: &[f64; D],
    start: [f64; D],
    f: impl Fn(&[f64; D]) -> f64,
) -> ([f64; D], f64) {
    let whole = |scaled: &[f64; D]| std::array::from_fn(|i| units[i] * scaled[i]);
    let (place, least) = minimise(std::array::from_fn(|i| start[i] / units[i]), |scaled| f(&whole(scaled)));
    (whole(&place), least)
}
