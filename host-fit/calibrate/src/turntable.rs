//! Sensitivity of a gyro from plateaus of constant rate on a turntable: |ω| equals the stated rate.
//!
//! The same estimator as for the accelerometer (`triad.rs`), with the length of each vector given by the turntable. The bias
//! comes from rests in the same log; without rests it is estimated with the rest, and needs plateaus in both directions of
//! rotation.

use std::ops::Range;

use fos_data::statistics::median_of;
use serde::Serialize;

use crate::error::{CalibrateError, FEWEST_DEGREES};
use crate::imu::{Axes, Imu, Scale};
use crate::least_squares::{rms, student};
use crate::length_fit::{self, Known, LengthFit, Vector, sphere};
use crate::parameter::{AXES, Determined, LEVEL, Parameter, correlations};
use crate::quiet::{FEWEST_ROWS, WINDOW_S, Windows};
use crate::rests::mean;
use crate::triad::{PAIRS, TriadModel, UNKNOWNS};
use crate::vector::{distance, norm, unit};

/// Shortest plateau between its margins, s.
const SHORTEST_S: f64 = 1.0;

/// A rate is constant where the standard deviation within a window is below this share of it: a belt drive wobbles by 1 %.
const CONSTANT_SHARE: f64 = 0.02;

/// It is also constant where it varies by less than this many standard deviations of the noise.
const CONSTANT_NOISE: f64 = 3.0;

/// A plateau belongs to the stated rate that its own is within this share of: sensitivity errors are below it.
const SAME_RATE: f64 = 0.12;

/// Rates below this share of the slowest stated rate are rests.
const REST_SHARE: f64 = 0.1;

/// Parameters of the cosines count as estimated with fewer directions than this: 2° of cross-axis is their spread in parts of this kind.
const COSINE: f64 = 0.03;

/// Standard error of a sensitivity, relative, above which it is not determined.
const NOT_DETERMINED: f64 = 0.02;

/// Largest share of the plateaus that may be outliers.
const MAX_OUTLIERS: f64 = 0.2;

/// A stretch of constant rate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plateau {
    /// Start by the time of the log, s.
    pub start_s: f64,
    pub duration_s: f64,
    /// Mean of the gyro, in the unit of the log.
    pub mean: [f64; 3],
    /// The stated rate that it belongs to, rad/s.
    pub rate_rads: f64,
    /// Direction of the rotation in the frame of the gyro.
    pub axis: [f64; 3],
    /// Corrected |ω| over the stated rate, minus 1.
    pub residual: f64,
    /// True if its residual is improbably large against the others.
    pub excluded: bool,
}

/// Calibration of a gyro on a turntable.
#[derive(Debug, Clone, Serialize)]
pub struct Turntable {
    pub model: TriadModel,
    pub scale: Scale,
    /// Stated rates, rad/s.
    pub rates_rads: Vec<f64>,
    pub parameters: Vec<Parameter>,
    pub correlations: Vec<Vec<f64>>,
    pub plateaus: Vec<Plateau>,
    /// Rests that the bias comes from; 0 if it was estimated from the plateaus.
    pub rests: usize,
    pub degrees_of_freedom: f64,
    /// RMS of |ω| over the stated rate − 1: corrected, and as logged without the bias (`None` for counts).
    pub rms: [Option<f64>; 2],
}

/// Calibrates the gyro of a log that was recorded on a turntable at these rates, rad/s.
pub fn calibrate_on_turntable(imu: &Imu, rates_rads: &[f64]) -> Result<Turntable, CalibrateError> {
    let axes = imu.gyro.as_ref().ok_or(CalibrateError::NoGyro)?;
    let rates: Vec<f64> = rates_rads.iter().map(|rate| rate.abs()).collect();
    if let Some(&rate) = rates.iter().find(|rate| !rate.is_finite() || **rate == 0.0) {
        return Err(CalibrateError::BadRate { rate });
    }
    if let Some((column, value)) = axes.stuck() {
        return Err(CalibrateError::StuckAxis { column: column.to_owned(), value });
    }
    let window = imu.rows_in(WINDOW_S, FEWEST_ROWS);
    let windows: Vec<Windows> =
        axes.values.iter().map(|values| Windows::of(values, &imu.segments, window)).collect();
    let stretches = constant(imu, axes, &windows);
    let means: Vec<[f64; 3]> = stretches.iter().map(|rows| mean(axes, std::slice::from_ref(rows))).collect();
    let slowest = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let (start, scale, is_bias_known) = start(axes, &means, &stretches, &rates)?;
    let rate_of = |raw: &[f64; 3]| norm(start.corrected(*raw, start.reference_c));
    let nearest = |rate: f64| {
        let off = |stated: &&f64| (rate / **stated - 1.0).abs();
        rates
            .iter()
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .copied()
            .filter(|stated| off(&stated) < SAME_RATE)
    };
    let rests: Vec<usize> = (0..means.len()).filter(|&i| rate_of(&means[i]) < REST_SHARE * slowest).collect();
    let mut chosen: Vec<(usize, f64)> =
        (0..means.len()).filter_map(|i| Some((i, nearest(rate_of(&means[i]))?))).collect();
    let no_plateau = || {
        let mut found: Vec<f64> =
            means.iter().map(rate_of).filter(|rate| *rate >= REST_SHARE * slowest).collect();
        found.truncate(10);
        CalibrateError::NoPlateau { stated: rates.clone(), found, shortest_s: SHORTEST_S }
    };
    if chosen.is_empty() {
        return Err(no_plateau());
    }
    let (start, mut known) = with_bias(start, &means, &rests, is_bias_known);
    known.extend((6..9).map(|index| (index, 0.0, COSINE)));
    let excluded_at_most = (MAX_OUTLIERS * chosen.len() as f64) as usize;
    let mut excluded: Vec<(usize, f64)> = Vec::new();
    let fitted = loop {
        let vectors: Vec<Vector> = chosen
            .iter()
            .map(|&(index, length)| {
                let of_axis = |i: usize| windows[i].noise / start.sensitivity[i].powi(2);
                let variance = (0..3).map(of_axis).sum::<f64>() / 3.0 / stretches[index].len() as f64;
                Vector { raw: means[index], kelvin: 0.0, length, variance }
            })
            .collect();
        let few = |degrees_of_freedom: f64| CalibrateError::FewPlateaus {
            plateaus: vectors.len(),
            degrees_of_freedom,
            more: (FEWEST_DEGREES as f64 - degrees_of_freedom).ceil().max(1.0) as usize,
            has_rest: is_bias_known,
        };
        if vectors.len() + known.len() < UNKNOWNS + FEWEST_DEGREES {
            return Err(few((vectors.len() + known.len()) as f64 - UNKNOWNS as f64));
        }
        let fitted = length_fit::fit(&vectors, &start, UNKNOWNS, &known).ok_or_else(no_plateau)?;
        if fitted.degrees_of_freedom < FEWEST_DEGREES as f64 {
            return Err(few(fitted.degrees_of_freedom));
        }
        match fitted.outlying(FEWEST_DEGREES as f64).first().filter(|_| excluded.len() < excluded_at_most) {
            Some(&(worst, _)) => excluded.push(chosen.remove(worst)),
            None => break fitted,
        }
    };
    let undetermined: Vec<usize> = (0..3)
        .filter(|&axis| {
            let s = fitted.model.sensitivity[axis].abs();
            let error = fitted.covariance[(3 + axis, 3 + axis)].sqrt() / s;
            error.is_nan() || error > NOT_DETERMINED
        })
        .collect();
    if !undetermined.is_empty() {
        let parameters =
            undetermined.iter().map(|&axis| format!("gyro {} sensitivity", AXES[axis])).collect();
        let axis = AXES[undetermined[0]];
        let next =
            format!("a plateau in each direction of rotation with {axis} along the axis of the turntable");
        return Err(CalibrateError::NotIdentifiable { parameters, next });
    }
    let shown = |&(index, rate): &(usize, f64), excluded: bool| {
        let corrected = fitted.model.corrected(means[index], fitted.model.reference_c);
        Plateau {
            start_s: imu.time_s[stretches[index].start],
            duration_s: stretches[index].len() as f64 * imu.period_s,
            mean: means[index],
            rate_rads: rate,
            axis: unit(corrected),
            residual: norm(corrected) / rate - 1.0,
            excluded,
        }
    };
    let mut plateaus: Vec<Plateau> = chosen.iter().map(|one| shown(one, false)).collect();
    plateaus.extend(excluded.iter().map(|one| shown(one, true)));
    plateaus.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let bias = fitted.model.bias;
    let before = chosen.iter().map(|&(index, rate)| distance(means[index], bias) / rate - 1.0);
    Ok(Turntable {
        model: fitted.model,
        scale,
        parameters: parameters(&fitted, scale),
        correlations: correlations(&fitted.covariance),
        rests: if is_bias_known { rests.len() } else { 0 },
        degrees_of_freedom: fitted.degrees_of_freedom,
        rms: [
            rms(plateaus.iter().filter(|one| !one.excluded).map(|one| one.residual)),
            if scale == Scale::Si { rms(before) } else { None },
        ],
        plateaus,
        rates_rads: rates,
    })
}

/// Stretches in which every axis of the gyro is constant to within its noise or a share of the rate.
fn constant(imu: &Imu, axes: &Axes, windows: &[Windows]) -> Vec<Range<usize>> {
    let rests: Vec<f64> = axes.values.iter().map(|values| quiet_level(values, windows)).collect();
    let is_constant = |row: usize| {
        let raw = axes.at(row);
        let rate = (0..3).map(|i| (raw[i] - rests[i]).powi(2)).sum::<f64>();
        windows.iter().all(|axis| {
            let limit =
                (CONSTANT_SHARE * CONSTANT_SHARE * rate).max(CONSTANT_NOISE * CONSTANT_NOISE * axis.noise);
            axis.variance[row] <= limit
        })
    };
    let shortest = imu.rows_in(SHORTEST_S, 8);
    let found =
        imu.segments.iter().flat_map(|segment| fos_data::recording::runs(segment.clone(), is_constant));
    let halves =
        found.filter(|rows| rows.len() >= shortest).flat_map(|rows| steady_pieces(axes, rows, shortest));
    halves.collect()
}

/// A stretch cut where its rate changes: where a turntable is slowed by hand the change is slow, and no window shows it.
fn steady_pieces(axes: &Axes, rows: Range<usize>, shortest: usize) -> Vec<Range<usize>> {
    let means: Vec<[f64; 3]> = rows
        .clone()
        .step_by(shortest)
        .map(|start| mean(axes, std::slice::from_ref(&(start..(start + shortest).min(rows.end)))))
        .collect();
    let mut pieces = Vec::new();
    let mut begin = 0;
    for at in 1..=means.len() {
        let ends = at == means.len() || {
            let first = &means[begin];
            distance(means[at], *first) > 2.0 * CONSTANT_SHARE * norm(*first).max(norm(means[at]))
        };
        if ends {
            let piece = rows.start + begin * shortest..(rows.start + at * shortest).min(rows.end);
            if piece.len() >= shortest {
                pieces.push(piece);
            }
            begin = at;
        }
    }
    pieces
}

/// The level of an axis where all are quietest: its bias if the log has a rest; near 0 for values in rad/s.
fn quiet_level(values: &[f64], windows: &[Windows]) -> f64 {
    let quiet =
        (0..values.len()).filter(|&row| windows.iter().all(|axis| axis.variance[row] <= 4.0 * axis.noise));
    let level = median_of(quiet.map(|row| values[row]).filter(|value| value.is_finite())).unwrap_or(0.0);
    // in rad/s a bias is small: a larger level is a plateau
    if level.abs() < 0.5 || level.abs() > 300.0 { level } else { 0.0 }
}

/// Stretches at rest of a gyro in rad/s with any bias: relative to a rest, every other stretch is a rest or turns at a stated rate.
/// Relative to a plateau, the rests turn at its rate, but few of the other plateaus do at a stated one.
fn resting(means: &[[f64; 3]], rates: &[f64]) -> Vec<usize> {
    let slowest = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let turns = |rate: f64| rates.iter().any(|stated| (rate / stated - 1.0).abs() < SAME_RATE);
    let near = |centre: &[f64; 3]| -> Vec<usize> {
        (0..means.len()).filter(|&i| distance(means[i], *centre) < REST_SHARE * slowest).collect()
    };
    let explained = |centre: &[f64; 3]| {
        let at_rate = means.iter().filter(|mean| turns(distance(**mean, *centre))).count();
        (at_rate, at_rate + near(centre).len())
    };
    let best = means
        .iter()
        .max_by(|a, b| explained(a).1.cmp(&explained(b).1).then_with(|| norm(**b).total_cmp(&norm(**a))));
    best.filter(|centre| {
        let (at_rate, all) = explained(centre);
        at_rate > 0 && 2 * all > means.len()
    })
    .map_or_else(Vec::new, near)
}

fn start(
    axes: &Axes,
    means: &[[f64; 3]],
    stretches: &[Range<usize>],
    rates: &[f64],
) -> Result<(TriadModel, Scale, bool), CalibrateError> {
    let slowest = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let fastest = rates.iter().copied().fold(0.0, f64::max);
    match axes.scale {
        Scale::Si => {
            let rests = resting(means, rates);
            let bias = [0, 1, 2].map(|i| median_of(rests.iter().map(|&rest| means[rest][i])).unwrap_or(0.0));
            Ok((TriadModel { bias, ..TriadModel::default() }, Scale::Si, !rests.is_empty()))
        }
        Scale::Counts => {
            // the longest stretch at rest is that of the least spread; the fastest plateaus lie on a sphere about it
            let none = || CalibrateError::NoPlateau {
                stated: vec![slowest],
                found: Vec::new(),
                shortest_s: SHORTEST_S,
            };
            let (centre, _) = sphere(means).ok_or_else(none)?;
            let longest = means.iter().map(|mean| distance(*mean, centre)).fold(0.0, f64::max);
            let rests: Vec<&[f64; 3]> =
                means.iter().filter(|mean| distance(**mean, centre) < 0.3 * longest).collect();
            let bias = [0, 1, 2].map(|i| median_of(rests.iter().map(|mean| mean[i])).unwrap_or(centre[i]));
            let outer: Vec<[f64; 3]> =
                means.iter().copied().filter(|mean| distance(*mean, bias) > 0.85 * longest).collect();
            let radius = median_of(outer.iter().map(|mean| distance(*mean, bias)));
            let radius = radius.filter(|_| !stretches.is_empty()).ok_or_else(none)?;
            Ok((
                TriadModel { bias, sensitivity: [radius / fastest; 3], ..TriadModel::default() },
                Scale::Counts,
                !rests.is_empty(),
            ))
        }
    }
}

/// The bias by the rests with its uncertainty, as known before the fit.
fn with_bias(
    start: TriadModel,
    means: &[[f64; 3]],
    rests: &[usize],
    is_known: bool,
) -> (TriadModel, Vec<Known>) {
    if !is_known || rests.is_empty() {
        return (start, Vec::new());
    }
    let count = rests.len() as f64;
    let mut bias = start.bias;
    let mut known = Vec::new();
    for axis in 0..3 {
        let average = rests.iter().map(|&i| means[i][axis]).sum::<f64>() / count;
        let squares: f64 = rests.iter().map(|&i| (means[i][axis] - average).powi(2)).sum();
        // A single rest does not show its scatter: 0.03 °/s is that of consumer parts between rests.
        let floor = 5e-4 * start.sensitivity[axis];
        let deviation = if rests.len() > 1 { (squares / (count - 1.0) / count).sqrt() } else { 0.0 };
        bias[axis] = average;
        known.push((axis, average, deviation.max(floor / count.sqrt())));
    }
    (TriadModel { bias, ..start }, known)
}

fn parameters(fitted: &LengthFit, scale: Scale) -> Vec<Parameter> {
    let quantile = student(LEVEL, fitted.degrees_of_freedom);
    let (log, per) = match scale {
        Scale::Si => ("rad/s", ""),
        Scale::Counts => ("counts", "counts/(rad/s)"),
    };
    let make = |index: usize| {
        let (axis, value) = (index % 3, fitted.model.parameters()[index]);
        let deviation = fitted.covariance[(index, index)].sqrt();
        let half = quantile * deviation;
        let (i, j) = PAIRS[axis];
        let name = AXES[axis];
        let pair = format!("{}{}", AXES[i], AXES[j]);
        let (id, label, value, half_width, unit) = match index / 3 {
            0 => (format!("bias.{name}"), format!("{name} bias"), value, half, log),
            1 => (format!("sensitivity.{name}"), format!("{name} sensitivity"), value, half, per),
            _ => {
                let angle = value.clamp(-1.0, 1.0).acos();
                (
                    format!("angle.{pair}"),
                    format!("angle {pair}"),
                    angle.to_degrees(),
                    (half / angle.sin()).to_degrees(),
                    "°",
                )
            }
        };
        let is_open = index >= 6 && deviation > 0.5 * COSINE;
        Parameter {
            id: format!("gyro.{id}"),
            label: format!("gyro {label}"),
            value,
            half_width,
            unit: unit.to_owned(),
            determined: if is_open { Determined::NotByThisLog } else { Determined::Well },
        }
    };
    (0..9).map(make).collect()
}
