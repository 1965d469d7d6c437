//! Bias, sensitivity and cross-axis of an accelerometer from rests: at rest |a| = g.
//!
//! The estimator is weighted least squares on the lengths (Tedaldi, Pretto and Menegatti 2014, equation 10, in the frame-free
//! form of `triad.rs`). The variance of each length is that of its mean plus a variance from rest to rest, which is estimated
//! from the residuals and in practice larger: the device settles, the table is not rigid, the sensor is not linear. Intervals
//! use the scale of the residuals and Student's t with the remaining degrees of freedom.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use fos_data::statistics::median_of;

use crate::error::CalibrateError;
use crate::gravity::Gravity;
use crate::imu::{Axes, Imu, Scale};
use crate::least_squares::{rms, student};
use crate::length_fit::{self, Known, LengthFit, Vector, gradient, sphere};
use crate::orientation::{Orientation, candidates, count_distinct, furthest, in_words, spread_deg, unseen};
use crate::parameter::{AXES, Determined, LEVEL, Parameter, correlations};
use crate::quiet::Windows;
use crate::rests::{Exclusion, Rest, Rests, SHORTEST_WITH_MARGINS_S, find};
use crate::triad::{PAIRS, PARAMETERS, TriadModel, UNKNOWNS};
use crate::vector::{norm, unit};

/// Limits of the variance at rest over that of the noise. The log decides: a hand shakes more than a table. imu_tk tries 2 … 10
/// times the standard deviation of a rest of 30 s to 50 s.
const RATIOS: [f64; 4] = [9.0, 36.0, 144.0, 576.0];

/// A wider limit must make the intervals narrower by this factor.
const WORTHWHILE: f64 = 0.8;

/// Smallest angular spread of all rests, °; with less, nothing is determined.
const FEWEST_SPREAD_DEG: f64 = 20.0;

/// Orientations that give usable intervals: three more than unknowns.
const ENOUGH_ORIENTATIONS: usize = UNKNOWNS + 3;

/// Standard deviations of parts of this kind (data sheets of consumer MEMS: zero-g level ± 50 mg, sensitivity ± 3 %, cross-axis
/// ± 2 %, 0.5 mg/K, 0.02 %/K), by which a parameter counts as determined or not: m/s², relative, cosine, m/s²/K, 1/K.
const PLAUSIBLE: [f64; 5] = [0.5, 0.05, 0.03, 5e-3, 2e-4];

/// A parameter whose standard error is above this share of the plausible value is not determined by the log.
const NOT_DETERMINED: f64 = 0.3;

/// A parameter is weakly determined if its half-width is above both this, m/s² at 1 g (1 mg), and `WEAK_TIMES` times the median.
const WEAK_MPS2: f64 = 0.01;
const WEAK_TIMES: f64 = 2.0;

/// It is weakly determined in any case if its half-width is above this, m/s² at 1 g (20 mg): all may be equally bad.
const SURELY_WEAK_MPS2: f64 = 0.2;

/// Fewest distinct orientations: bias and sensitivity are six unknowns, and repetitions of an orientation add no information.
const FEWEST_ORIENTATIONS: usize = 6;

/// Temperatures at rest that span less than this, K, say nothing about slopes.
const LEAST_SPAN_K: f64 = 3.0;

/// Fewest degrees of freedom to look for outliers: with fewer, a residual far from the others may be the only right one.
const FEWEST_FOR_OUTLIERS: f64 = 5.0;

/// Largest share of the rests that may be outliers.
const MAX_OUTLIERS: f64 = 0.25;

/// At rest, values in m/s² lie within this share of gravity, or are in another unit.
const GRAVITY_WITHIN: f64 = 0.3;

/// Values in m/s² of more than this are counts.
const SURELY_COUNTS: f64 = 300.0;

/// Length of an assumed further dwell, s.
const DWELL_S: f64 = 3.0;

/// Most dwells that are planned ahead.
const MAX_PLANNED: usize = 12;

/// Requirements of a calibration by hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub gravity: Gravity,
    /// Largest half-width of an interval that is accurate enough, m/s² at 1 g.
    pub accuracy_mps2: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { gravity: Gravity::assumed(), accuracy_mps2: None }
    }
}

/// A rest and how well it fits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RestResidual {
    #[serde(flatten)]
    pub rest: Rest,
    /// Direction that pointed up.
    pub up: [f64; 3],
    /// Corrected |a| − g, m/s².
    pub residual_mps2: f64,
    /// Expected standard deviation of the residual, m/s².
    pub deviation_mps2: f64,
}

/// The dwell to record next.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Next {
    pub orientation: Orientation,
    /// Spelled for people: "one dwell with y pointing up".
    pub instruction: String,
    /// The widest half-width now and after this dwell of 3 s, m/s² at 1 g.
    pub worst_mps2: [f64; 2],
    /// The parameter with the widest interval now.
    pub parameter: String,
}

/// Calibration of an accelerometer.
#[derive(Debug, Clone, Serialize)]
pub struct Accelerometer {
    pub model: TriadModel,
    pub scale: Scale,
    pub gravity: Gravity,
    pub parameters: Vec<Parameter>,
    /// Correlations of the parameters, row by row.
    pub correlations: Vec<Vec<f64>>,
    pub rests: Vec<RestResidual>,
    /// Distinct orientations among the rests that are not excluded. With no more than nine the residual shows how well rests
    /// repeat, not how well the model fits.
    pub orientations: usize,
    pub degrees_of_freedom: f64,
    /// RMS of |a| − g over these rests, m/s²: corrected, and before with the nominal scale (`None` for counts).
    pub rms_mps2: [Option<f64>; 2],
    /// Scatter from rest to rest beyond the noise of the samples, m/s².
    pub scatter_mps2: f64,
    /// Noise of the mean of a dwell of 3 s, m/s².
    pub noise_mps2: f64,
    /// Lowest and highest temperature at rest, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// The largest half-width of bias, sensitivity and cross-axis at 1 g, m/s².
    pub worst_mps2: f64,
    /// Faces that no rest comes near to: "y pointing up".
    pub unseen: Vec<String>,
    pub next: Next,
    /// Further dwells until the requested accuracy is reached: empty if it is, or if none was requested; `None` if more than
    /// 12.
    pub plan: Option<Vec<String>>,
    /// Requested accuracy, m/s², and `true` if the intervals are within it.
    pub accuracy: Option<(f64, bool)>,
    /// Covariance of bias, sensitivity and cosines, for the gyro's intervals.
    #[serde(skip)]
    pub(crate) covariance9: DMatrix<f64>,
}

impl Accelerometer {
    /// The rests that the estimate uses.
    pub fn used(&self) -> impl Iterator<Item = &RestResidual> {
        self.rests.iter().filter(|one| one.rest.excluded.is_none())
    }
}

/// The calibration and the rests that it stands on.
pub(crate) struct Found {
    pub(crate) accelerometer: Accelerometer,
    pub(crate) rests: Rests,
}

/// Calibrates at the limit of stillness that gives the narrowest intervals.
///
/// An error is that at the limit with the most distinct orientations.
pub(crate) fn calibrate(imu: &Imu, windows: &[Windows], options: &Options) -> Result<Found, CalibrateError> {
    let axes = imu.accelerometer.as_ref().ok_or(CalibrateError::NoAccelerometer)?;
    let mut best: Option<Found> = None;
    let mut refused: Option<(usize, CalibrateError)> = None;
    for ratio in RATIOS {
        let rests = find(imu, axes, windows, ratio);
        let count = rests.rests.iter().filter(|rest| rest.excluded.is_none()).count();
        match attempt(imu, axes, rests, options) {
            Ok(found) => {
                let worst = found.accelerometer.worst_mps2;
                if best.as_ref().is_none_or(|best| worst < WORTHWHILE * best.accelerometer.worst_mps2) {
                    best = Some(found);
                }
            }
            Err(error) => {
                if refused.as_ref().is_none_or(|(most, _)| count > *most) {
                    refused = Some((count, error));
                }
            }
        }
    }
    match (best, refused) {
        (Some(found), _) => Ok(found),
        (None, Some((_, error))) => Err(error),
        (None, None) => Err(no_rest(imu)),
    }
}

fn no_rest(imu: &Imu) -> CalibrateError {
    let duration_s = imu.time_s.len() as f64 * imu.period_s;
    CalibrateError::NoRest { shortest_s: SHORTEST_WITH_MARGINS_S, duration_s }
}

fn attempt(imu: &Imu, axes: &Axes, mut rests: Rests, options: &Options) -> Result<Found, CalibrateError> {
    let used = |rests: &Rests| -> Vec<usize> {
        (0..rests.rests.len()).filter(|&index| rests.rests[index].excluded.is_none()).collect()
    };
    let mut kept = used(&rests);
    if kept.is_empty() && rests.rests.is_empty() {
        return Err(no_rest(imu));
    }
    let (start, scale) = start(axes, &rests, &kept, options)?;
    let directions = |rests: &Rests, kept: &[usize], model: &TriadModel| -> Vec<[f64; 3]> {
        kept.iter()
            .map(|&index| unit(model.corrected(rests.rests[index].accelerometer, model.reference_c)))
            .collect()
    };
    let seen = directions(&rests, &kept, &start);
    let spread = spread_deg(&seen);
    if spread < FEWEST_SPREAD_DEG {
        let next = in_words(&furthest(&seen, 3));
        return Err(CalibrateError::OneOrientation { rests: kept.len(), spread_deg: spread, next });
    }
    if kept.len() <= UNKNOWNS {
        let orientations = count_distinct(&seen);
        let more = ENOUGH_ORIENTATIONS.saturating_sub(orientations).max(3);
        return Err(no_redundancy(&rests, orientations, more, &furthest(&seen, more)));
    }
    let temperatures: Vec<Option<f64>> = kept.iter().map(|&index| rests.rests[index].temperature_c).collect();
    let span = temperatures.iter().flatten().fold(None, |span: Option<[f64; 2]>, &t| match span {
        Some([low, high]) => Some([low.min(t), high.max(t)]),
        None => Some([t, t]),
    });
    let has_slopes = temperatures.iter().all(Option::is_some)
        && span.is_some_and(|[low, high]| high - low >= LEAST_SPAN_K)
        && kept.len() > UNKNOWNS + 6;
    let reference_c = median_of(temperatures.iter().flatten().copied()).unwrap_or(start.reference_c);
    let mut start = TriadModel { reference_c, ..start };
    let n = if has_slopes { PARAMETERS } else { UNKNOWNS };
    let g = options.gravity.mps2;
    let vector = |rests: &Rests, index: usize, model: &TriadModel| {
        let rest = &rests.rests[index];
        let noise = rests.accelerometer_variance(rest.duration_s);
        // seen along gravity: the mean over directions
        let variance = (0..3).map(|i| noise[i] / model.sensitivity[i].powi(2)).sum::<f64>() / 3.0;
        let kelvin = if has_slopes { rest.temperature_c.map_or(0.0, |t| t - reference_c) } else { 0.0 };
        Vector { raw: rest.accelerometer, kelvin, length: g, variance }
    };
    let most_outliers = (MAX_OUTLIERS * kept.len() as f64) as usize;
    let mut outliers = 0;
    let fitted = loop {
        let vectors: Vec<Vector> = kept.iter().map(|&index| vector(&rests, index, &start)).collect();
        let known = known(&start, has_slopes);
        let fitted = length_fit::fit(&vectors, &start, n, &known)
            .filter(|fitted| fitted.model.sensitivity.iter().all(|s| s.is_finite() && *s != 0.0));
        let Some(fitted) = fitted else {
            return Err(CalibrateError::NoFit { iterations: 0, residual_mps2: f64::NAN });
        };
        let found = fitted.outlying(FEWEST_FOR_OUTLIERS);
        let room = most_outliers.saturating_sub(outliers).min(kept.len() / 50 + 1);
        let found: Vec<(usize, f64)> = found.into_iter().take(room).collect();
        let remaining: Vec<usize> =
            (0..kept.len()).filter(|at| found.iter().all(|(out, _)| out != at)).collect();
        let left: Vec<usize> = remaining.iter().map(|&at| kept[at]).collect();
        if found.is_empty() || left.len() <= UNKNOWNS {
            break fitted;
        }
        outliers += found.len();
        for (at, deviations) in found {
            rests.rests[kept[at]].excluded = Some(Exclusion::Outlier { deviations });
        }
        kept = left;
        start = fitted.model;
    };
    check_gravity(&fitted, g)?;
    let seen = directions(&rests, &kept, &fitted.model);
    let undetermined = undetermined(&fitted);
    let orientations = count_distinct(&seen);
    if orientations < FEWEST_ORIENTATIONS {
        let more = ENOUGH_ORIENTATIONS - orientations;
        return Err(no_redundancy(&rests, orientations, more, &furthest(&seen, more)));
    }
    if undetermined.iter().any(|&index| index < 6) {
        let parameters = undetermined.iter().map(|&index| label(index)).collect();
        return Err(CalibrateError::NotIdentifiable {
            parameters,
            next: in_words(&furthest(&seen, undetermined.len().clamp(2, 6))),
        });
    }
    let accelerometer = report(&fitted, &rests, &kept, scale, options, &undetermined, span, &seen);
    Ok(Found { accelerometer, rests })
}

/// Knowledge of parts of this kind before the log: cosines near 0, small slopes.
fn known(start: &TriadModel, has_slopes: bool) -> Vec<Known> {
    let mut known: Vec<Known> = (6..9).map(|index| (index, 0.0, PLAUSIBLE[2])).collect();
    if has_slopes {
        known.extend((0..3).map(|i| (9 + i, 0.0, PLAUSIBLE[3] * start.sensitivity[i].abs())));
        known.extend((12..15).map(|index| (index, 0.0, PLAUSIBLE[4])));
    }
    known
}

fn no_redundancy(rests: &Rests, orientations: usize, more: usize, next: &[Orientation]) -> CalibrateError {
    let (next, excluded) = (in_words(next), excluded_in_words(rests));
    CalibrateError::NoRedundancy { orientations, more, next, excluded }
}

fn excluded_in_words(rests: &Rests) -> String {
    let count = |is: fn(&Exclusion) -> bool| {
        rests.rests.iter().filter(|r| r.excluded.as_ref().is_some_and(is)).count()
    };
    let moves = count(|e| matches!(e, Exclusion::Moves { .. }));
    let clips = count(|e| matches!(e, Exclusion::Clips { .. }));
    match (moves, clips) {
        (0, 0) => String::new(),
        (moves, 0) => format!(" ({moves} rests that move are excluded)"),
        (0, clips) => format!(" ({clips} rests at which an axis clips are excluded)"),
        (moves, clips) => {
            format!(" ({moves} rests that move and {clips} at which an axis clips are excluded)")
        }
    }
}

/// Start of the iteration: the nominal scale, or for counts the nearest sphere.
fn start(
    axes: &Axes,
    rests: &Rests,
    kept: &[usize],
    options: &Options,
) -> Result<(TriadModel, Scale), CalibrateError> {
    let raw: Vec<[f64; 3]> = kept.iter().map(|&index| rests.rests[index].accelerometer).collect();
    let g = options.gravity.mps2;
    let typical = median_of(raw.iter().copied().map(norm)).unwrap_or(f64::NAN);
    let scale = if axes.scale == Scale::Si && typical > SURELY_COUNTS { Scale::Counts } else { axes.scale };
    if scale == Scale::Si {
        if raw.is_empty() {
            return Err(no_redundancy(rests, 0, ENOUGH_ORIENTATIONS, &candidates()[..3]));
        }
        if (typical / g - 1.0).abs() > GRAVITY_WITHIN {
            let excluded = excluded_in_words(rests);
            return Err(CalibrateError::NotGravity { found: typical, gravity: g, excluded });
        }
        return Ok((TriadModel::default(), scale));
    }
    let next = &candidates()[..3];
    match sphere(&raw) {
        Some((centre, radius)) => {
            Ok((TriadModel { bias: centre, sensitivity: [radius / g; 3], ..TriadModel::default() }, scale))
        }
        None if raw.len() > UNKNOWNS => {
            let (spread_deg, next) = (FEWEST_SPREAD_DEG, in_words(next));
            Err(CalibrateError::OneOrientation { rests: raw.len(), spread_deg, next })
        }
        None => {
            let more = ENOUGH_ORIENTATIONS.saturating_sub(raw.len()).max(3);
            Err(no_redundancy(rests, raw.len(), more, next))
        }
    }
}

/// A residual beyond this share of gravity is no calibration.
fn check_gravity(fitted: &LengthFit, g: f64) -> Result<(), CalibrateError> {
    let squares: f64 = fitted.residuals.iter().map(|r| r * r).sum();
    let rms = (squares / fitted.residuals.len() as f64).sqrt();
    if rms.is_finite() && rms < 0.1 * g {
        return Ok(());
    }
    Err(CalibrateError::NoFit { iterations: fitted.iterations, residual_mps2: rms })
}

/// Plausible standard deviation of a parameter, in its unit.
fn plausible(model: &TriadModel, index: usize) -> f64 {
    let axis = index % 3;
    let s = model.sensitivity[axis].abs();
    match index / 3 {
        0 => PLAUSIBLE[0] * s,
        1 => PLAUSIBLE[1] * s,
        3 => PLAUSIBLE[3] * s,
        group => PLAUSIBLE[group],
    }
}

/// Parameters that take part in a direction which the rests do not determine: right singular vectors of the whitened
/// Jacobian in plausible units, with a singular value so small that the standard error is above [`NOT_DETERMINED`].
fn undetermined(fitted: &LengthFit) -> Vec<usize> {
    let mut scaled = fitted.jacobian.clone();
    for index in 0..scaled.ncols() {
        scaled.column_mut(index).scale_mut(plausible(&fitted.model, index));
    }
    let svd = scaled.svd(false, true);
    let Some(v_t) = svd.v_t else { return Vec::new() };
    let mut found: Vec<usize> = Vec::new();
    for (row, singular) in svd.singular_values.iter().enumerate() {
        if 1.0 / singular.max(f64::MIN_POSITIVE) < NOT_DETERMINED {
            continue;
        }
        for index in 0..v_t.ncols() {
            if v_t[(row, index)].abs() > 0.4 && !found.contains(&index) {
                found.push(index);
            }
        }
    }
    found.sort_unstable();
    found
}

fn label(index: usize) -> String {
    let axis = AXES[index % 3];
    let (i, j) = PAIRS[index % 3];
    match index / 3 {
        0 => format!("accelerometer {axis} bias"),
        1 => format!("accelerometer {axis} sensitivity"),
        2 => format!("accelerometer angle {}{}", AXES[i], AXES[j]),
        3 => format!("accelerometer {axis} bias per K"),
        _ => format!("accelerometer {axis} sensitivity per K"),
    }
}

/// Half-width of a parameter as an error of the acceleration at 1 g, m/s²; `None` for slopes.
fn at_one_g(model: &TriadModel, g: f64, index: usize, half_width: f64) -> Option<f64> {
    let s = model.sensitivity[index % 3].abs();
    match index / 3 {
        0 => Some(half_width / s),
        1 => Some(half_width / s * g),
        2 => Some(half_width * g),
        _ => None,
    }
}

#[allow(clippy::too_many_arguments)] // one caller, one result
fn report(
    fitted: &LengthFit,
    rests: &Rests,
    kept: &[usize],
    scale: Scale,
    options: &Options,
    undetermined: &[usize],
    temperature_c: Option<[f64; 2]>,
    seen: &[[f64; 3]],
) -> Accelerometer {
    let model = fitted.model;
    let g = options.gravity.mps2;
    let mut covariance = fitted.covariance.clone();
    // an error of g is an error of all three sensitivities
    let share = options.gravity.uncertainty_mps2 / g;
    for i in 0..3 {
        for j in 0..3 {
            covariance[(3 + i, 3 + j)] += model.sensitivity[i] * model.sensitivity[j] * share * share;
        }
    }
    let quantile = student(LEVEL, fitted.degrees_of_freedom);
    let half = |index: usize| quantile * covariance[(index, index)].sqrt();
    let n = covariance.nrows();
    let mut sizes: Vec<f64> = (0..n).filter_map(|index| at_one_g(&model, g, index, half(index))).collect();
    let worst_mps2 = sizes.iter().copied().fold(0.0, f64::max);
    let typical = fos_data::statistics::median(&mut sizes);
    let parameters = (0..n).map(|index| {
        let size = at_one_g(&model, g, index, half(index));
        let is_slope_unknown =
            index >= 9 && covariance[(index, index)].sqrt() > 0.5 * plausible(&model, index);
        let determined = match size {
            _ if undetermined.contains(&index) || is_slope_unknown => Determined::NotByThisLog,
            Some(size) if size > SURELY_WEAK_MPS2 => Determined::Weakly,
            Some(size) if size > WEAK_MPS2 && size > WEAK_TIMES * typical => Determined::Weakly,
            _ => Determined::Well,
        };
        parameter(&model, scale, index, half(index), determined)
    });
    let parameters: Vec<Parameter> = parameters.collect();
    // An angle decreases while its cosine increases: correlations apply to the shown value.
    let sign = |index: usize| if index / 3 == 2 { -1.0 } else { 1.0 };
    let mut correlations = correlations(&covariance);
    for (i, row) in correlations.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value *= sign(i) * sign(j);
        }
    }
    let typical_deviation = median_of(fitted.deviations.iter().copied()).unwrap_or(0.0);
    let shown = rests.rests.iter().enumerate().map(|(index, rest)| {
        let temperature = rest.temperature_c.unwrap_or(model.reference_c);
        let corrected = model.corrected(rest.accelerometer, temperature);
        let at = kept.iter().position(|&kept| kept == index);
        RestResidual {
            rest: rest.clone(),
            up: unit(corrected),
            residual_mps2: norm(corrected) - g,
            deviation_mps2: at.map_or(typical_deviation, |at| fitted.deviations[at]),
        }
    });
    let shown: Vec<RestResidual> = shown.collect();
    let before = kept.iter().map(|&index| norm(rests.rests[index].accelerometer) - g);
    let noise = rests.accelerometer_variance(DWELL_S);
    let noise_variance = (0..3).map(|i| noise[i] / model.sensitivity[i].powi(2)).sum::<f64>() / 3.0;
    let mut plan = Planner::of(fitted, covariance.clone(), noise_variance, g);
    let next = plan.next();
    let accuracy = options.accuracy_mps2.map(|accuracy| (accuracy, worst_mps2 <= accuracy));
    let plan = options.accuracy_mps2.map_or(Some(Vec::new()), |accuracy| plan.until(accuracy));
    Accelerometer {
        model,
        scale,
        gravity: options.gravity,
        parameters,
        correlations,
        orientations: count_distinct(seen),
        degrees_of_freedom: fitted.degrees_of_freedom,
        rms_mps2: [
            rms(fitted.residuals.iter().copied()),
            if scale == Scale::Si { rms(before) } else { None },
        ],
        scatter_mps2: fitted.excess.sqrt(),
        noise_mps2: noise_variance.sqrt(),
        temperature_c,
        worst_mps2,
        unseen: unseen(seen).iter().map(Orientation::describe).collect(),
        next,
        plan,
        accuracy,
        rests: shown,
        covariance9: covariance.view((0, 0), (9, 9)).into_owned(),
    }
}

fn parameter(model: &TriadModel, scale: Scale, index: usize, half: f64, determined: Determined) -> Parameter {
    let axis = index % 3;
    let (i, j) = PAIRS[axis];
    let name = AXES[axis];
    let (log, per) = match scale {
        Scale::Si => ("m/s²", ""),
        Scale::Counts => ("counts", "counts/(m/s²)"),
    };
    let value = model.parameters()[index];
    let (id, value, half_width, unit) = match index / 3 {
        0 => (format!("bias.{name}"), value, half, log.to_owned()),
        1 => (format!("sensitivity.{name}"), value, half, per.to_owned()),
        2 => {
            // d arccos(γ) = −dγ/√(1 − γ²)
            let angle = value.clamp(-1.0, 1.0).acos();
            let id = format!("angle.{}{}", AXES[i], AXES[j]);
            (id, angle.to_degrees(), (half / angle.sin()).to_degrees(), "°".to_owned())
        }
        3 => (format!("bias_per_k.{name}"), value, half, format!("{log}/K")),
        _ => (format!("sensitivity_per_k.{name}"), value, half, "1/K".to_owned()),
    };
    Parameter { id: format!("accelerometer.{id}"), label: label(index), value, half_width, unit, determined }
}

/// Expected intervals after further dwells.
struct Planner<'a> {
    fitted: &'a LengthFit,
    covariance: DMatrix<f64>,
    degrees_of_freedom: f64,
    /// Variance of the length that a further dwell measures.
    variance: f64,
    g: f64,
}

impl<'a> Planner<'a> {
    fn of(fitted: &'a LengthFit, covariance: DMatrix<f64>, noise_variance: f64, g: f64) -> Self {
        Self {
            fitted,
            covariance,
            degrees_of_freedom: fitted.degrees_of_freedom,
            variance: (fitted.excess + noise_variance).max(1e-12),
            g,
        }
    }

    /// The widest half-width at 1 g and its parameter, of this covariance.
    fn worst(&self, covariance: &DMatrix<f64>, degrees: f64) -> (f64, usize) {
        let quantile = student(LEVEL, degrees);
        let sizes = (0..covariance.nrows()).filter_map(|index| {
            let half = quantile * covariance[(index, index)].max(0.0).sqrt();
            Some((at_one_g(&self.fitted.model, self.g, index, half)?, index))
        });
        sizes.fold((0.0, 0), |worst, one| if one.0 > worst.0 { one } else { worst })
    }

    /// Covariance after a dwell in this orientation (Sherman and Morrison 1950).
    fn after(&self, orientation: &Orientation) -> DMatrix<f64> {
        let model = &self.fitted.model;
        let raw = model.measured(orientation.up.map(|part| part * self.g), model.reference_c);
        let row: DVector<f64> = gradient(model, &raw, 0.0, self.covariance.nrows());
        let seen = &self.covariance * &row;
        let gain = 1.0 / (self.variance + row.dot(&seen));
        &self.covariance - &seen * seen.transpose() * gain
    }

    /// The dwell that makes the widest interval narrowest.
    fn best(&self) -> (Orientation, DMatrix<f64>, f64) {
        let tried = candidates().into_iter().map(|orientation| {
            let covariance = self.after(&orientation);
            let (worst, _) = self.worst(&covariance, self.degrees_of_freedom + 1.0);
            (orientation, covariance, worst)
        });
        let narrowest = tried.reduce(|best, one| if one.2 < 0.999 * best.2 { one } else { best });
        narrowest.unwrap_or((Orientation { up: [0.0, 0.0, 1.0] }, self.covariance.clone(), f64::INFINITY))
    }

    fn next(&self) -> Next {
        let (now, index) = self.worst(&self.covariance, self.degrees_of_freedom);
        let (orientation, _, then) = self.best();
        let instruction = format!("one dwell with {}", orientation.describe());
        Next { orientation, instruction, worst_mps2: [now, then], parameter: label(index) }
    }

    /// Dwells until all intervals are within `accuracy`; `None` if [`MAX_PLANNED`] are not enough.
    fn until(&mut self, accuracy: f64) -> Option<Vec<String>> {
        let mut dwells = Vec::new();
        let (mut worst, _) = self.worst(&self.covariance, self.degrees_of_freedom);
        while worst > accuracy {
            if dwells.len() == MAX_PLANNED {
                return None;
            }
            let (orientation, covariance, then) = self.best();
            dwells.push(orientation.describe());
            self.covariance = covariance;
            self.degrees_of_freedom += 1.0;
            worst = then;
        }
        Some(dwells)
    }
}
