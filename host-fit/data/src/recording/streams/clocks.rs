//! Offset between the clocks of an accelerometer and a gyro, from a motion that both measure.
//!
//! While a device turns at ω and gravity dominates the specific force f, df/dt = −ω × f. So the accelerometer alone
//! determines the rate perpendicular to f:
//!
//! ```text
//! p = (df/dt × f) / |f|²  =  ω − f (f · ω) / |f|²  =  ω⊥
//! ```
//!
//! The offset x of a window minimises S(x) = Σ |p(t) − ω⊥(t + x)|²; over the windows with rotation, a line x = offset +
//! drift (t − middle) is fitted, weighted by the curvature of S, which is the information of a window. Its standard
//! errors come from the scatter of the windows about it. A drift is used only if it is significant and large enough to
//! matter; else the offset is assumed to be constant. Periodic motion, such as a steady swing, has one minimum of S per
//! period: of minima that the scatter of the windows leaves indistinguishable, the one nearest to zero is taken, and
//! the period is reported. Rotation in gravity is distinguished from vibration, which appears on both sensors with any
//! phase, by requiring that p has the size of ω⊥ and explains most of it.

use std::fmt;
use std::ops::Range;

use crate::statistics::finite_median;
use crate::unit::STANDARD_GRAVITY_MPS2;

/// Result of the comparison of two clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clocks {
    Apart(Apart),
    /// The device does not turn, or too briefly: treated as one clock.
    NoMotion,
    /// It turns, but the two sensors disagree on the motion: treated as one clock.
    Unlike,
}

/// An offset between two clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Correction to be added to the timestamps of the stream in the middle of the log, s.
    pub offset_s: f64,
    /// Standard error of the offset, s.
    pub offset_error_s: f64,
    /// Drift of the offset, s/s; 0 if it is not significant.
    pub drift: f64,
    /// Standard error of the drift, s/s.
    pub drift_error: f64,
    /// Distance to the nearest other offset that explains the motion as well, s; `None` if the offset is unique. Of
    /// several, the one nearest to zero is chosen: delays within one device are shorter than the period of most swings.
    pub repeats_s: Option<f64>,
    /// True if it was added to the timestamps: it is significant, and exceeds a tenth of the stream's period somewhere.
    pub applied: bool,
    /// Middle of the log by the timestamps of the stream, ns.
    pub middle_ns: i64,
}

/// A triad with the timestamps of its samples in order, ns.
pub(super) struct Triad<'a> {
    pub(super) stamps_ns: &'a [i64],
    pub(super) values: [&'a [f64]; 3],
}

/// Largest offset searched, s: a larger one is no jitter of a hub but another clock, which a reader corrects.
const MAX_OFFSET_S: f64 = 0.5;

/// Largest drift searched: a crystal is within 100 ppm of its frequency over temperature and age; a ceramic resonator is
/// within some thousand, but is not used for timestamps.
const MAX_DRIFT: f64 = 500e-6;

/// Step of the grid for the comparison, s; and half the width of the triangular smoothing window, in steps: hands turn
/// at a few hertz, and faster components are noise or vibration.
const STEP_S: f64 = 0.01;
const SMOOTH: usize = 5;

/// Length of a window, in steps: 2 s.
const WINDOW: usize = 200;

/// Largest lag, in steps: the offset, and the drift of half an hour and more.
const LAGS: usize = 150;

/// Rate above which a window counts as rotation, rad/s (RMS about the median of the log): no gyro at rest shows 3 °/s of
/// noise.
const MIN_RATE_RADS: f64 = 0.05;

/// Maximum number of windows used, evenly spread over those with rotation.
const MAX_WINDOWS: usize = 600;

/// Minimum number of windows for a standard error.
const MIN_WINDOWS: usize = 4;

/// Largest deviation of the specific force from gravity, m/s², for gravity to dominate.
const MAX_OFF_GRAVITY_MPS2: f64 = 2.0;

/// Allowed gain of p over ω⊥, and minimum explained share of p.
const GAIN: std::ops::RangeInclusive<f64> = 0.75..=1.25;
const MIN_SHARE: f64 = 0.6;

/// Number of standard errors from which an offset or drift is significant.
const MIN_SIGMAS: f64 = 5.0;

/// Two minima of S count as one if S between them rises by less than this share of its range above the higher of them.
const BARRIER: f64 = 0.1;

/// A minimum explains the motion as well as the global one if S is higher by no more than `EQUAL_SIGMAS` standard errors
/// (of the differences of all windows) and `EQUAL_SHARE` of the range of S; or by `EXACT_SHARE` of it, the error of the
/// curve between steps of the grid.
const EQUAL_SIGMAS: f64 = 3.0;
const EQUAL_SHARE: f64 = 0.1;
const EXACT_SHARE: f64 = 0.01;

/// Minimum offset or accumulated drift that is corrected, as a share of the stream's period.
const MIN_SHARE_OF_PERIOD: f64 = 0.1;

/// Offset to be added to the timestamps of the accelerometer to match those of the gyro; `period_ns` is that of the
/// stream to be shifted.
pub(super) fn of_accelerometer(accelerometer: &Triad<'_>, gyro: &Triad<'_>, period_ns: i64) -> Clocks {
    let bias = gyro.values.map(|values| finite_median(values).unwrap_or(0.0));
    let turning = turning(gyro, bias);
    let stride = turning.len().div_ceil(MAX_WINDOWS).max(1);
    let (mut windows, mut p_power) = (Vec::new(), 0.0);
    for start_ns in turning.into_iter().step_by(stride) {
        crate::interrupt::check();
        if let Some(window) = Window::at(start_ns, accelerometer, gyro, bias) {
            p_power += window.p_power;
            windows.push(window);
        }
    }
    let (Some(first), Some(last)) = (gyro.stamps_ns.first(), gyro.stamps_ns.last()) else {
        return Clocks::NoMotion;
    };
    if windows.len() < MIN_WINDOWS {
        return Clocks::NoMotion;
    }
    let middle_ns = first.midpoint(*last);
    let half_s = 0.5 * last.saturating_sub(*first) as f64 * 1e-9;
    windows
        .iter_mut()
        .for_each(|window| window.from_middle_s = window.start_ns.saturating_sub(middle_ns) as f64 * 1e-9);
    let Some(least) = Line::best(&windows, half_s, p_power) else { return Clocks::Unlike };
    let (found, repeats_s) = least.nearest_to_zero(&windows);

    let at = |sums: &[f64], window: &Window| found.in_steps(window).map_or(0.0, |lag| between(sums, lag));
    let left: f64 = windows.iter().map(|window| at(&window.left, window)).sum();
    let rate_power: f64 = windows.iter().map(|window| at(&window.rate_power, window)).sum();
    // S = Σp² − 2 Σpω + Σω²
    let gain = 0.5 * (p_power + rate_power - left) / rate_power;
    if !(GAIN.contains(&gain) && left < (1.0 - MIN_SHARE) * p_power) {
        return Clocks::Unlike;
    }
    let worth_s = MIN_SHARE_OF_PERIOD * period_ns as f64 * 1e-9;
    let Some(line) = found.refined(&windows, worth_s / half_s) else { return Clocks::Unlike };
    let most_s = line.offset_s.abs() + line.drift.abs() * half_s;
    let significant = line.offset_s.abs() > MIN_SIGMAS * line.offset_error_s || line.drift != 0.0;
    let applied = significant && most_s > worth_s;
    let Line { offset_s, offset_error_s, drift, drift_error } = line;
    Clocks::Apart(Apart { offset_s, offset_error_s, drift, drift_error, repeats_s, applied, middle_ns })
}

/// Starts of windows in which the device turns, ns.
fn turning(gyro: &Triad<'_>, bias: [f64; 3]) -> Vec<i64> {
    let window_ns = (WINDOW as f64 * STEP_S * 1e9) as i64;
    let mut starts = Vec::new();
    let mut row = 0;
    while row < gyro.stamps_ns.len() {
        let start = gyro.stamps_ns[row];
        let end = start.saturating_add(window_ns);
        let end = row + gyro.stamps_ns[row..].partition_point(|stamp| *stamp < end).max(1);
        let square =
            |row: usize| (0..3).map(|axis| (gyro.values[axis][row] - bias[axis]).powi(2)).sum::<f64>();
        let mean = (row..end).map(square).sum::<f64>() / (end - row) as f64;
        if mean > MIN_RATE_RADS * MIN_RATE_RADS {
            starts.push(start);
        }
        row = end;
    }
    starts
}

/// Comparison of both sensors within one window of time.
struct Window {
    start_ns: i64,
    from_middle_s: f64,
    /// Σ |p|².
    p_power: f64,
    /// Σ |ω⊥|² and S for every lag from −`LAGS` to `LAGS`.
    rate_power: Vec<f64>,
    left: Vec<f64>,
}

impl Window {
    /// `None` if samples are missing, or gravity does not dominate.
    fn at(start_ns: i64, accelerometer: &Triad<'_>, gyro: &Triad<'_>, bias: [f64; 3]) -> Option<Self> {
        // one more on each side for the derivative
        let force = accelerometer.smooth(start_ns, -1..WINDOW as i64 + 1)?;
        let reach = LAGS as i64;
        let rate = gyro.smooth(start_ns, -reach..WINDOW as i64 + reach)?;
        let rate: Vec<[f64; 3]> =
            rate.iter().map(|r| [r[0] - bias[0], r[1] - bias[1], r[2] - bias[2]]).collect();
        let mut window = Self {
            start_ns,
            from_middle_s: 0.0,
            p_power: 0.0,
            rate_power: vec![0.0; 2 * LAGS + 1],
            left: vec![0.0; 2 * LAGS + 1],
        };
        let mut used = 0;
        for k in 0..WINDOW {
            let f = force[k + 1];
            let square = dot(f, f);
            if (square.sqrt() - STANDARD_GRAVITY_MPS2).abs() > MAX_OFF_GRAVITY_MPS2 {
                continue;
            }
            used += 1;
            let change = [0, 1, 2].map(|axis| (force[k + 2][axis] - force[k][axis]) / (2.0 * STEP_S));
            let p = cross(change, f).map(|value| value / square);
            window.p_power += dot(p, p);
            for lag in 0..=2 * LAGS {
                let w = rate[k + lag];
                let along = dot(f, w) / square;
                let across = [0, 1, 2].map(|axis| w[axis] - along * f[axis]);
                let apart = [0, 1, 2].map(|axis| p[axis] - across[axis]);
                window.rate_power[lag] += dot(across, across);
                window.left[lag] += dot(apart, apart);
            }
        }
        (2 * used > WINDOW).then_some(window)
    }
}

impl Triad<'_> {
    /// Smoothed values at steps of the grid starting at `start_ns`; `None` if samples are missing.
    fn smooth(&self, start_ns: i64, steps: Range<i64>) -> Option<Vec<[f64; 3]>> {
        let reach = SMOOTH as i64 - 1;
        let time = |step: i64| start_ns.saturating_add((step as f64 * STEP_S * 1e9) as i64);
        let from = time(steps.start - reach);
        let mut row = self.stamps_ns.partition_point(|stamp| *stamp <= from).checked_sub(1)?;
        let mut raw = Vec::with_capacity((steps.end - steps.start + 2 * reach) as usize);
        for step in steps.start - reach..steps.end + reach {
            let at = time(step);
            while *self.stamps_ns.get(row + 1)? < at {
                row += 1;
            }
            let (before, after) = (self.stamps_ns[row], self.stamps_ns[row + 1]);
            let wait = after.saturating_sub(before);
            // longer than the smoothing window: samples are missing
            if wait as f64 * 1e-9 > 2.0 * SMOOTH as f64 * STEP_S {
                return None;
            }
            let w = at.saturating_sub(before) as f64 / wait.max(1) as f64;
            raw.push(self.values.map(|values| values[row] + w * (values[row + 1] - values[row])));
        }
        let kernel: Vec<f64> = (0..2 * SMOOTH - 1)
            .map(|k| (SMOOTH - k.abs_diff(SMOOTH - 1)) as f64 / (SMOOTH * SMOOTH) as f64)
            .collect();
        let smoothed: Vec<[f64; 3]> = raw
            .windows(kernel.len())
            .map(|part| [0, 1, 2].map(|axis| part.iter().zip(&kernel).map(|(v, k)| k * v[axis]).sum()))
            .collect();
        smoothed.iter().flatten().all(|value| value.is_finite()).then_some(smoothed)
    }
}

/// Offset in the middle of the log, and its drift.
#[derive(Clone, Copy)]
struct Line {
    offset_s: f64,
    offset_error_s: f64,
    drift: f64,
    drift_error: f64,
}

impl Line {
    /// Best line on a grid, without drift unless a drift explains more. Steady swings at two times of a log are
    /// explained equally well by a drift of a period between them.
    fn best(windows: &[Window], half_s: f64, p_power: f64) -> Option<Self> {
        let offsets = (MAX_OFFSET_S / STEP_S) as i32;
        // a step of the grid at the ends of the log
        let drift_step = (STEP_S / half_s.max(STEP_S)).max(MAX_DRIFT / 200.0);
        let drifts = (MAX_DRIFT / drift_step) as i32;
        let mut best: Option<(f64, Self)> = None;
        let mut steady: Option<(f64, Self)> = None;
        for drift in (-drifts..=drifts).map(|n| f64::from(n) * drift_step) {
            for offset_s in (-offsets..=offsets).map(|n| f64::from(n) * STEP_S) {
                let line = Self { offset_s, offset_error_s: 0.0, drift, drift_error: 0.0 };
                let left = windows.iter().map(|window| Some(between(&window.left, line.in_steps(window)?)));
                let Some(left) = left.sum::<Option<f64>>() else { continue };
                if best.is_none_or(|(least, _)| left < least) {
                    best = Some((left, line));
                }
                if drift == 0.0 && steady.is_none_or(|(least, _)| left < least) {
                    steady = Some((left, line));
                }
            }
        }
        let (least, line) = best?;
        // the parabolas of the windows find a small drift from there
        Some(match steady {
            Some((left, steady)) if left - least <= EXACT_SHARE * p_power => steady,
            _ => line,
        })
    }

    /// Among lines of the same drift that explain the motion as well, the one nearest to zero, and the distance to its
    /// nearest alternative, s; for a motion that is not periodic, the line itself.
    fn nearest_to_zero(self, windows: &[Window]) -> (Self, Option<f64>) {
        let offsets = (MAX_OFFSET_S / STEP_S) as i32;
        let curve: Vec<(Self, f64)> = (-offsets..=offsets)
            .map(|step| Self { offset_s: f64::from(step) * STEP_S, ..self })
            .filter_map(|line| {
                let left = windows.iter().map(|window| Some(between(&window.left, line.in_steps(window)?)));
                Some((line, left.sum::<Option<f64>>()?))
            })
            .collect();
        let (low, high) = curve.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, left)| {
            (low.min(*left), high.max(*left))
        });
        let Some(least) = curve.iter().position(|(_, left)| *left == low) else { return (self, None) };
        let is_minimum =
            |at: &usize| curve[*at].1 <= curve[at - 1].1 && curve[*at].1 <= curve[at + 1].1 && *at != least;
        let is_apart = |at: &usize| {
            let between = &curve[least.min(*at)..=least.max(*at)];
            let ridge = between.iter().map(|(_, left)| *left).fold(low, f64::max);
            ridge - curve[*at].1 > BARRIER * (high - low)
        };
        let at_least: Vec<f64> =
            windows.iter().map(|window| self.lowest_near(&curve, least, window)).collect();
        let explains_as_well = |at: &usize| {
            let higher: Vec<f64> = windows
                .iter()
                .zip(&at_least)
                .map(|(window, least)| self.lowest_near(&curve, *at, window) - least)
                .collect();
            let n = higher.len() as f64;
            let mean = higher.iter().sum::<f64>() / n;
            let scatter = higher.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let share = n * mean / (high - low);
            share <= EXACT_SHARE || share <= EQUAL_SHARE && mean <= EQUAL_SIGMAS * (scatter / n).sqrt()
        };
        let mut equal: Vec<usize> = (1..curve.len().saturating_sub(1))
            .filter(|at| is_minimum(at) && is_apart(at) && explains_as_well(at))
            .collect();
        equal.push(least);
        let offset_s = |at: &usize| curve[*at].0.offset_s;
        let Some(nearest) =
            equal.iter().copied().min_by(|a, b| offset_s(a).abs().total_cmp(&offset_s(b).abs()))
        else {
            return (self, None);
        };
        let others = equal.iter().filter(|at| **at != nearest);
        let repeats_s = others.map(|at| (offset_s(at) - offset_s(&nearest)).abs()).reduce(f64::min);
        (curve[nearest].0, repeats_s)
    }

    /// S of a window at a minimum of the curve of all windows, which lies between steps of its grid: by parabolas through
    /// three steps.
    fn lowest_near(&self, curve: &[(Self, f64)], at: usize, window: &Window) -> f64 {
        let parabola = |[before, at, after]: [f64; 3]| (0.5 * (after - before), after - 2.0 * at + before);
        let sides =
            |of: &dyn Fn(usize) -> f64| [of(at.saturating_sub(1)), of(at), of((at + 1).min(curve.len() - 1))];
        let (slope, curvature) = parabola(sides(&|index| curve[index].1));
        let share = if curvature > 0.0 { (-slope / curvature).clamp(-0.5, 0.5) } else { 0.0 };
        let own = sides(&|index| {
            curve[index].0.in_steps(window).map_or(f64::INFINITY, |lag| between(&window.left, lag))
        });
        let (slope, curvature) = parabola(own);
        own[1] + share * slope + 0.5 * share * share * curvature
    }

    fn at_s(&self, window: &Window) -> f64 {
        self.offset_s + self.drift * window.from_middle_s
    }

    /// Index into the sums of a window; `None` outside of them.
    fn in_steps(&self, window: &Window) -> Option<f64> {
        let lag = self.at_s(window) / STEP_S + LAGS as f64;
        (1.0..=2.0 * LAGS as f64 - 1.0).contains(&lag).then_some(lag)
    }

    /// Refines the line from each window's own minimum nearby; constant unless the drift is at least `least_drift`.
    fn refined(self, windows: &[Window], least_drift: f64) -> Option<Self> {
        let mut line = self;
        for _ in 0..3 {
            line = line.fitted(windows)?;
        }
        if line.drift.abs() <= least_drift.max(MIN_SIGMAS * line.drift_error) {
            let constant = Self { drift: 0.0, drift_error: f64::INFINITY, ..line };
            line = Self { drift_error: line.drift_error, ..constant.fitted(windows)? };
        }
        Some(line)
    }

    /// Least-squares line through the minima of the parabolas through S about it, weighted by their curvature. An
    /// infinite error of the drift fixes it at 0.
    fn fitted(&self, windows: &[Window]) -> Option<Self> {
        let constant = self.drift_error.is_infinite();
        let mut points = Vec::new();
        for window in windows {
            let nearest = self.in_steps(window)?.round() as usize;
            let [before, at, after] =
                [nearest - 1, nearest, nearest + 1].map(|lag| window.left.get(lag).copied());
            let (before, at, after) = (before?, at?, after?);
            let (slope, curvature) = (0.5 * (after - before), after - 2.0 * at + before);
            // a window without curvature has no minimum, and no weight
            if curvature > 0.0 {
                let least = nearest as f64 - LAGS as f64 - (slope / curvature).clamp(-10.0, 10.0);
                points.push((window.from_middle_s, least * STEP_S, curvature));
            }
        }
        let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(of).sum::<f64>();
        let weight = sum(&|(_, _, w)| *w);
        let (t, x) = (sum(&|(t, _, w)| w * t) / weight, sum(&|(_, x, w)| w * x) / weight);
        let spread = sum(&|(at, _, w)| w * (at - t).powi(2));
        let slope = sum(&|(at, offset, w)| w * (at - t) * (offset - x)) / spread;
        let drift = if constant || !slope.is_finite() { 0.0 } else { slope };
        if points.len() < MIN_WINDOWS {
            return None;
        }
        // with few points the scatter is underestimated
        let more = points.len() as f64 / (points.len() as f64 - 2.0);
        let off = |(at, offset, w): &(f64, f64, f64)| w * (offset - x - drift * (at - t));
        let drift_error = (more * sum(&|point| (off(point) * (point.0 - t)).powi(2))).sqrt() / spread;
        let level_error = (more * sum(&|point| off(point).powi(2))).sqrt() / weight;
        let offset_error_s = if constant { level_error } else { level_error.hypot(t * drift_error) };
        let drift_error = match (constant, drift_error.is_finite()) {
            (true, _) => f64::INFINITY,
            (false, true) => drift_error,
            (false, false) => f64::MAX,
        };
        Some(Self { offset_s: x - drift * t, offset_error_s, drift, drift_error })
    }
}

impl Clocks {
    /// Returns true if the timestamps are corrected.
    pub(super) fn is_applied(&self) -> bool {
        matches!(self, Self::Apart(apart) if apart.applied)
    }

    /// The same with the sign for the other stream.
    pub(super) fn negated(self) -> Self {
        match self {
            Self::Apart(apart) => {
                Self::Apart(Apart { offset_s: -apart.offset_s, drift: -apart.drift, ..apart })
            }
            other => other,
        }
    }
}

impl Apart {
    pub(super) fn add_to(&self, stamps_ns: &mut [i64]) {
        for stamp in stamps_ns {
            let from_middle_ns = stamp.saturating_sub(self.middle_ns) as f64;
            *stamp = stamp.saturating_add((self.offset_s * 1e9 + self.drift * from_middle_ns).round() as i64);
        }
    }
}

impl fmt::Display for Clocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMotion => f.write_str("no motion tells whether its clock is off, and it is taken as right"),
            Self::Unlike => f.write_str(
                "its motion and that of the lead do not tell whether its clock is off, and it is taken as right",
            ),
            Self::Apart(apart) => {
                write!(f, "its timestamps lack {:.2} ± {:.2} ms", 1e3 * apart.offset_s, 1e3 * apart.offset_error_s)?;
                if apart.drift != 0.0 {
                    write!(
                        f,
                        " in the middle of the log and {:.1} ± {:.1} µs more every second",
                        1e6 * apart.drift,
                        1e6 * apart.drift_error
                    )?;
                }
                f.write_str(" by what both see of the motion, ")?;
                f.write_str(if apart.applied { "which was added" } else { "too little to be added" })?;
                match apart.repeats_s {
                    None => Ok(()),
                    Some(repeats_s) => write!(
                        f,
                        "; the motion repeats every {repeats_s:.2} s, so the offset is known up to multiples of that: the one \
                         nearest to zero was taken. Turn the device irregularly for 10 s to determine it"
                    ),
                }
            }
        }
    }
}

/// Linear interpolation between two values of a series.
fn between(values: &[f64], at: f64) -> f64 {
    let (low, part) = (at.floor() as usize, at.fract());
    let of = |index: usize| values.get(index).copied().unwrap_or(0.0);
    if part == 0.0 { of(low) } else { of(low) + part * (of(low + 1) - of(low)) }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
