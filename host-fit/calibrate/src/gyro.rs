//! Bias of a gyro from its rests; sensitivity and cross-axis from the turns between them.
//!
//! Gravity is fixed in space. Integrating the corrected rates from one rest to the next must turn the direction of gravity of
//! the first into that of the second (Tedaldi, Pretto and Menegatti 2014, equation 13). Each turn gives two equations; a
//! rotation about the vertical is not seen. The matrix refers to the frame of the accelerometer's corrected values.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF as _, FisherSnedecor};

use fos_data::statistics::{MAD_TO_SD, median_of};

use crate::accelerometer::Accelerometer;
use crate::gyro_start::start;
use crate::imu::{Axes, Imu, Scale};
use crate::least_squares::{
    CONVERGED, Linearised, NEARLY, OUTLIER_CHANCE, covariance, excess_variance, leverages, minimise, rms,
    student,
};
use crate::parameter::{AXES, Determined, LEVEL, Parameter, correlations};
use crate::rests::{Rests, has_clipped, range};
use crate::triad::{PAIRS, TriadModel};
use crate::turn::{Prepared, Rates, angles, tangents};
use crate::vector::unit;

/// Longer turns are not used, s: the bias drifts.
const LONGEST_TURN_S: f64 = 60.0;

/// Fewest turns: two equations each for nine unknowns, and three for the residual.
const FEWEST_TURNS: usize = 6;

/// Standard deviation of an entry of the matrix in parts of this kind, relative, and the share of it above which an entry
/// counts as not determined.
const PLAUSIBLE: f64 = 0.05;
const NOT_DETERMINED: f64 = 0.3;

/// Turns that end further off than this after the fit do not belong to this gyro, °.
const MAX_RESIDUAL_DEG: f64 = 20.0;

/// Largest share of the turns that may be outliers.
const MAX_OUTLIERS: f64 = 0.25;

/// Fewest rests for a bias that depends on the orientation (four unknowns per axis) and fewest for a slope.
const FEWEST_FOR_G: usize = 10;

/// Temperatures at rest must span this, K, for a slope of the bias.
const LEAST_SPAN_K: f64 = 3.0;

/// Chance below which the bias depends on specific force.
const SIGNIFICANT: f64 = 1e-3;

/// Deviation of a rest's gyro mean from the others, in standard deviations, above which the device turned slowly.
const TURNS_SLOWLY: f64 = 8.0;

/// Reason to exclude a turn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TurnExclusion {
    /// An axis of the gyro stays at the end of its range.
    Clips,
    /// It lasts longer than a minute, or samples are missing.
    TooLong,
    /// Its residual is improbably large against the others.
    Outlier,
}

/// A turn from one rest to the next.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Turn {
    /// Indices of the rests.
    pub rests: [usize; 2],
    /// Start by the time of the log, s.
    pub start_s: f64,
    pub duration_s: f64,
    /// Angle turned through, °.
    pub angle_deg: f64,
    /// Angle between the turned and the measured direction of gravity, °.
    pub residual_deg: f64,
    pub excluded: Option<TurnExclusion>,
}

/// Calibration of a gyro.
#[derive(Debug, Clone, Serialize)]
pub struct Gyro {
    pub scale: Scale,
    /// Bias at the reference temperature, in the unit of the log.
    pub bias: [f64; 3],
    /// Change of the bias, unit of the log per K; `None` where the log does not cover temperature.
    pub bias_per_k: Option<[f64; 3]>,
    pub reference_c: f64,
    /// Change of the bias per m/s² of specific force, a row for each axis of the gyro; `None` with fewer than 10 rests.
    pub g_sensitivity: Option<[[f64; 3]; 3]>,
    /// True where the dependence on specific force is significant (p < 0.001); the turns are then corrected for it.
    pub is_g_sensitive: bool,
    /// ω = G·(raw − bias), rad/s, in the frame of the accelerometer; `None` if it was not estimated.
    pub matrix: Option<[[f64; 3]; 3]>,
    /// Reason why there is no matrix. A gyro with a stuck axis has no parameters either.
    pub refused: Option<String>,
    /// Correspondence of the gyro's axes to those of the accelerometer, where it is not x to x, y to y, z to z.
    pub axis_order: Option<String>,
    pub parameters: Vec<Parameter>,
    /// Correlations of sensitivities and cross-axis angles, in their order among the parameters.
    pub correlations: Vec<Vec<f64>>,
    /// Angles between the axes of the gyro (xy, xz, yz) and of each to the axis of the accelerometer of the same name.
    pub derived: Vec<Parameter>,
    pub turns: Vec<Turn>,
    pub degrees_of_freedom: f64,
    /// RMS angle between turned and measured direction, °: with the matrix, and with the nominal scale (`None` for counts).
    pub rms_deg: [Option<f64>; 2],
}

/// Calibrates the gyro of a log with these rests.
pub(crate) fn calibrate(imu: &Imu, axes: &Axes, accelerometer: &Accelerometer, rests: &Rests) -> Gyro {
    let used: Vec<usize> =
        (0..rests.rests.len()).filter(|&index| rests.rests[index].excluded.is_none()).collect();
    let mut gyro = bias(axes, accelerometer, rests, &used);
    if let Some((column, value)) = axes.stuck() {
        gyro.parameters.clear();
        (gyro.g_sensitivity, gyro.bias_per_k, gyro.is_g_sensitive) = (None, None, false);
        gyro.refused = Some(format!("{column} repeats one value, {value:?}: stuck or not connected"));
        return gyro;
    }
    let (turns, prepared) = prepare(imu, axes, accelerometer, rests, &used, &gyro);
    gyro.turns = turns;
    let clipped = gyro.turns.iter().filter(|turn| turn.excluded == Some(TurnExclusion::Clips)).count();
    if prepared.len() < FEWEST_TURNS {
        gyro.refused = Some(match clipped {
            0 => format!(
                "{} turns between rests, {FEWEST_TURNS} are needed: record more orientations without a pause in the log",
                prepared.len()
            ),
            _ => format!(
                "in {clipped} of {} turns the gyro was turned faster than its full scale: turn slower, by hand in 1 s or more",
                gyro.turns.len()
            ),
        });
        return gyro;
    }
    if let Err(reason) = fit_matrix(&mut gyro, prepared, accelerometer) {
        gyro.refused = Some(reason);
    }
    gyro
}

/// The bias, its slopes and their intervals, by linear least squares over the rests.
fn bias(axes: &Axes, accelerometer: &Accelerometer, rests: &Rests, used: &[usize]) -> Gyro {
    let means: Vec<(usize, [f64; 3])> =
        used.iter().filter_map(|&index| Some((index, rests.rests[index].gyro?))).collect();
    // rests in which the device turned slowly, about the vertical: the accelerometer does not see it
    let middle = [0, 1, 2].map(|i| median_of(means.iter().map(|(_, mean)| mean[i])).unwrap_or(0.0));
    let spread = [0, 1, 2].map(|i| {
        MAD_TO_SD * median_of(means.iter().map(|(_, mean)| (mean[i] - middle[i]).abs())).unwrap_or(0.0)
    });
    let noise = rests.gyro_variance(1.0);
    let is_still = |mean: &[f64; 3]| {
        (0..3).all(|i| (mean[i] - middle[i]).abs() <= TURNS_SLOWLY * (spread[i].powi(2) + noise[i]).sqrt())
    };
    let means: Vec<(usize, [f64; 3])> = means.into_iter().filter(|(_, mean)| is_still(mean)).collect();
    let model = &accelerometer.model;
    let temperature = |index: usize| rests.rests[index].temperature_c;
    let has_temperature = means.iter().all(|(index, _)| temperature(*index).is_some());
    let span = accelerometer.temperature_c.map_or(0.0, |[low, high]| high - low);
    let has_slope = has_temperature && span >= LEAST_SPAN_K && means.len() >= FEWEST_FOR_G;
    let has_g = means.len() >= FEWEST_FOR_G;
    let row = |index: usize| {
        let rest = &rests.rests[index];
        let at = rest.temperature_c.unwrap_or(model.reference_c);
        let mut row = vec![1.0];
        if has_g {
            row.extend(model.corrected(rest.accelerometer, at));
        }
        if has_slope {
            row.push(at - model.reference_c);
        }
        row
    };
    let rows: Vec<Vec<f64>> = means.iter().map(|(index, _)| row(*index)).collect();
    let columns = rows.first().map_or(1, Vec::len);
    let design = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
    let unscaled = covariance(&design);
    let degrees = (rows.len() as f64 - columns as f64).max(1.0);
    let quantile = student(LEVEL, degrees);
    let (log, per_g) = match axes.scale {
        Scale::Si => ("rad/s", "(rad/s)/(m/s²)"),
        Scale::Counts => ("counts", "counts/(m/s²)"),
    };
    let mut gyro = Gyro {
        scale: axes.scale,
        bias: middle,
        bias_per_k: None,
        reference_c: model.reference_c,
        g_sensitivity: None,
        is_g_sensitive: false,
        matrix: None,
        refused: None,
        axis_order: None,
        parameters: Vec::new(),
        correlations: Vec::new(),
        derived: Vec::new(),
        turns: Vec::new(),
        degrees_of_freedom: 0.0,
        rms_deg: [None, None],
    };
    let (mut by_g, mut by_k) = ([[0.0; 3]; 3], [0.0; 3]);
    let mut parameters = [Vec::new(), Vec::new(), Vec::new()];
    let mut least_chance = 1.0_f64;
    for axis in 0..3 {
        let values = DVector::from_iterator(means.len(), means.iter().map(|(_, mean)| mean[axis]));
        let solution =
            unscaled.as_ref().and_then(|_| crate::least_squares::solve(design.clone(), values.clone()));
        let (Some(solution), Some(unscaled)) = (solution, &unscaled) else { continue };
        let squares = (&design * &solution - &values).norm_squared();
        let scale = squares / degrees;
        if has_g {
            least_chance = least_chance.min(chance_of_g(&design, &values, squares, degrees));
        }
        let half = |column: usize| quantile * (scale * unscaled[(column, column)]).sqrt();
        let name = AXES[axis];
        let make = |id: String, label: String, column: usize, unit: String| Parameter {
            id: format!("gyro.{id}"),
            label: format!("gyro {label}"),
            value: solution[column],
            half_width: half(column),
            unit,
            determined: Determined::Well,
        };
        gyro.bias[axis] = solution[0];
        parameters[0].push(make(format!("bias.{name}"), format!("{name} bias"), 0, log.to_owned()));
        if has_g {
            for force in 0..3 {
                by_g[axis][force] = solution[1 + force];
                let along = AXES[force];
                parameters[1].push(make(
                    format!("g_sensitivity.{name}{along}"),
                    format!("{name} bias per g along {along}"),
                    1 + force,
                    per_g.to_owned(),
                ));
            }
        }
        if has_slope {
            by_k[axis] = solution[columns - 1];
            parameters[2].push(make(
                format!("bias_per_k.{name}"),
                format!("{name} bias per K"),
                columns - 1,
                format!("{log}/K"),
            ));
        }
    }
    gyro.g_sensitivity = has_g.then_some(by_g);
    // of three axes
    gyro.is_g_sensitive = 3.0 * least_chance < SIGNIFICANT;
    gyro.bias_per_k = has_slope.then_some(by_k);
    gyro.parameters = parameters.into_iter().flatten().collect();
    gyro
}

/// Chance of a decrease of the squares as large as that by the three columns of specific force (F test), if the bias did not
/// depend on it.
fn chance_of_g(design: &DMatrix<f64>, values: &DVector<f64>, squares: f64, degrees: f64) -> f64 {
    let without = design.clone().remove_columns(1, 3);
    let Some(solution) = crate::least_squares::solve(without.clone(), values.clone()) else { return 1.0 };
    let before = (without * solution - values).norm_squared();
    let ratio = (before - squares) / 3.0 / (squares / degrees).max(f64::MIN_POSITIVE);
    FisherSnedecor::new(3.0, degrees).map_or(1.0, |f| f.sf(ratio.max(0.0)))
}

/// The turns between rests that follow each other, and those that can be integrated.
fn prepare(
    imu: &Imu,
    axes: &Axes,
    accelerometer: &Accelerometer,
    rests: &Rests,
    used: &[usize],
    gyro: &Gyro,
) -> (Vec<Turn>, Vec<Prepared>) {
    let ends = axes.values.each_ref().map(|values| range(values));
    let (mut turns, mut prepared) = (Vec::new(), Vec::new());
    let spread = accelerometer.scatter_mps2 / accelerometer.gravity.mps2;
    // a bias that depends on the specific force follows it through the turn
    let by_g =
        gyro.g_sensitivity.filter(|_| gyro.is_g_sensitive).map(|rows| Matrix3::from_fn(|i, j| rows[i][j]));
    let by_force = |raw: [f64; 3]| {
        by_g.map_or(Vector3::zeros(), |by_g| {
            by_g * Vector3::from(accelerometer.model.corrected(raw, accelerometer.model.reference_c))
        })
    };
    for pair in used.windows(2) {
        let (before, after) = (&rests.rests[pair[0]], &rests.rests[pair[1]]);
        let rows = before.rows.end.saturating_sub(1)..(after.rows.start + 1).min(imu.time_s.len());
        let together = imu.segments.iter().any(|s| s.start <= rows.start && rows.end <= s.end);
        let duration_s = rows.len() as f64 * imu.period_s;
        let mut turn = Turn {
            rests: [pair[0], pair[1]],
            start_s: imu.time_s[rows.start],
            duration_s,
            angle_deg: 0.0,
            residual_deg: 0.0,
            excluded: None,
        };
        // the bias of either side, linear in between: it holds the drift and most of the g-sensitivity
        let side = |rest: &crate::rests::Rest| {
            let near = rest.gyro.filter(|mean| is_near(mean, &gyro.bias, rests, rest.duration_s));
            Vector3::from(near.unwrap_or(gyro.bias)) - by_force(rest.accelerometer)
        };
        let (first, last) = (side(before), side(after));
        let count = rows.len().max(2) as f64 - 1.0;
        let values: Option<Vec<Vector3<f64>>> = rows
            .clone()
            .enumerate()
            .map(|(n, row)| {
                let share = n as f64 / count;
                let bias = first * (1.0 - share) + last * share;
                let force =
                    imu.accelerometer.as_ref().map_or(Vector3::zeros(), |axes| by_force(axes.at(row)));
                let force = if force.iter().all(|x| x.is_finite()) { force } else { Vector3::zeros() };
                value_near(axes, row).map(|raw| Vector3::from(raw) - bias - force)
            })
            .collect();
        turn.excluded = match &values {
            Some(_) if !together || duration_s > LONGEST_TURN_S => Some(TurnExclusion::TooLong),
            None => Some(TurnExclusion::TooLong),
            Some(_) if has_clipped(axes, &ends, &rows) => Some(TurnExclusion::Clips),
            Some(_) => None,
        };
        if let (Some(values), None) = (values, turn.excluded) {
            let rates = Rates { values, period_s: imu.period_s };
            let up = [before, after].map(|rest| {
                let at = rest.temperature_c.unwrap_or(accelerometer.model.reference_c);
                Vector3::from(unit(accelerometer.model.corrected(rest.accelerometer, at)))
            });
            let noise = |seconds: f64| {
                let axis = rests.accelerometer_variance(seconds);
                let s = accelerometer.model.sensitivity;
                (0..3).map(|i| axis[i] / s[i].powi(2)).sum::<f64>() / 3.0 / accelerometer.gravity.mps2.powi(2)
            };
            let direction = noise(before.duration_s) + noise(after.duration_s) + 2.0 * spread * spread;
            let mean_of = |variance: [f64; 3]| variance.iter().sum::<f64>() / 3.0;
            let t = rates.duration_s();
            // white noise grows with the time, the error of the bias with its square
            let integrated = mean_of(rests.gyro_variance(1.0)) * t
                + t * t / 3.0
                    * (mean_of(rests.gyro_variance(before.duration_s))
                        + mean_of(rests.gyro_variance(after.duration_s)));
            prepared.push(Prepared { rates, up, direction, integrated, turn: turns.len() });
        }
        turns.push(turn);
    }
    (turns, prepared)
}

/// True for the mean of a rest that did not turn.
fn is_near(mean: &[f64; 3], bias: &[f64; 3], rests: &Rests, seconds: f64) -> bool {
    let spread = [0, 1, 2].map(|i| {
        let away = rests.rests.iter().filter_map(|rest| rest.gyro).map(|gyro| (gyro[i] - bias[i]).abs());
        MAD_TO_SD * median_of(away).unwrap_or(0.0)
    });
    let noise = rests.gyro_variance(seconds);
    (0..3).all(|i| (mean[i] - bias[i]).abs() <= TURNS_SLOWLY * (spread[i].powi(2) + noise[i]).sqrt())
}

/// The values of a row; where one is missing, the mean of those within three rows on either side.
fn value_near(axes: &Axes, row: usize) -> Option<[f64; 3]> {
    let raw = axes.at(row);
    if raw.iter().all(|value| value.is_finite()) {
        return Some(raw);
    }
    let found = axes.values.each_ref().map(|values| {
        if values[row].is_finite() {
            return values[row];
        }
        let near =
            values[row.saturating_sub(3)..(row + 4).min(values.len())].iter().filter(|v| v.is_finite());
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / count
    });
    found.iter().all(|value| value.is_finite()).then_some(found)
}

/// Residuals of some turns: two components each, in radians.
fn residuals(prepared: &[Prepared], matrix: &Matrix3<f64>) -> DVector<f64> {
    let mut all = DVector::zeros(2 * prepared.len());
    for (index, turn) in prepared.iter().enumerate() {
        let difference = turn.rates.turned(matrix, turn.up[0]) - turn.up[1];
        let rows = tangents(&turn.up[1]);
        for row in 0..2 {
            all[2 * index + row] = (0..3).map(|i| rows[(row, i)] * difference[i]).sum();
        }
    }
    all
}

fn to_matrix(entries: &DVector<f64>, unit: f64) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| entries[3 * i + j] * unit)
}

/// Residuals and Jacobian of the entries of the matrix in units of `unit`, divided by the deviation of each turn.
fn linearise(prepared: &[Prepared], deviations: &[f64], entries: &DVector<f64>, unit: f64) -> Linearised {
    let matrix = to_matrix(entries, unit);
    let mut at = Linearised {
        residuals: DVector::zeros(2 * prepared.len()),
        jacobian: DMatrix::zeros(2 * prepared.len(), 9),
    };
    for (index, turn) in prepared.iter().enumerate() {
        let (turned, derivatives) = turn.rates.turned_with_derivatives(&matrix, turn.up[0]);
        let rows = tangents(&turn.up[1]);
        let difference = turned - turn.up[1];
        for row in 0..2 {
            let weight = 1.0 / deviations[index];
            let tangent = Vector3::new(rows[(row, 0)], rows[(row, 1)], rows[(row, 2)]);
            at.residuals[2 * index + row] = tangent.dot(&difference) * weight;
            for entry in 0..9 {
                at.jacobian[(2 * index + row, entry)] =
                    tangent.dot(&derivatives.column(entry)) * weight * unit;
            }
        }
    }
    at
}

/// Fits the matrix and writes it into `gyro`.
fn fit_matrix(
    gyro: &mut Gyro,
    mut prepared: Vec<Prepared>,
    accelerometer: &Accelerometer,
) -> Result<(), String> {
    let start = start(&prepared, gyro.scale).ok_or("no scale of the gyro explains the turns of gravity between rests: check that accelerometer and gyro are of one device and the log has the right sample rate")?;
    gyro.axis_order = start.axis_order();
    let unit = start.matrix.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let nominal = start.matrix;
    let mut entries = DVector::from_fn(9, |i, _| nominal[(i / 3, i % 3)] / unit);
    // far turns first count little (Cauchy's weights), then not at all
    for _ in 0..8 {
        let off = angles(&prepared, &to_matrix(&entries, unit));
        let scale = (MAD_TO_SD * median_of(off.iter().copied()).unwrap_or(0.1)).max(1e-3);
        let deviations: Vec<f64> =
            off.iter().map(|angle| (1.0 + (angle / (2.4 * scale)).powi(2)).sqrt()).collect();
        let found =
            minimise(entries.clone(), NEARLY, |entries| linearise(&prepared, &deviations, entries, unit));
        let Some(found) = found else { break };
        let moved = (&found.parameters - &entries).norm();
        entries = found.parameters;
        if moved < 1e-4 {
            break;
        }
    }
    let off = angles(&prepared, &to_matrix(&entries, unit));
    let scale = MAD_TO_SD * median_of(off.iter().copied()).unwrap_or(0.1);
    let limit = (10.0 * scale).max(0.01).min(MAX_RESIDUAL_DEG.to_radians());
    let mut most_outliers = (MAX_OUTLIERS * prepared.len() as f64) as usize;
    let far: Vec<usize> = (0..prepared.len()).filter(|&index| off[index] > limit).collect();
    if far.len() > most_outliers.max(1) {
        return Err(format!(
            "{} of {} turns end more than {:.1}° off: check that accelerometer and gyro are of one device, the order and signs of their axes, and the sample rate",
            far.len(),
            prepared.len(),
            limit.to_degrees()
        ));
    }
    for &index in far.iter().rev() {
        gyro.turns[prepared[index].turn].excluded = Some(TurnExclusion::Outlier);
        prepared.remove(index);
        most_outliers = most_outliers.saturating_sub(1);
    }
    loop {
        if prepared.len() < FEWEST_TURNS {
            return Err(format!("{} usable turns between rests, {FEWEST_TURNS} are needed", prepared.len()));
        }
        let fitted = weighted(&prepared, entries.clone(), unit).ok_or(
            "the turns between rests do not determine the gyro: turn the device about each of its axes",
        )?;
        entries.copy_from(&fitted.entries);
        if let Some(index) = outlying(&fitted, prepared.len()).filter(|_| most_outliers > 0) {
            most_outliers -= 1;
            gyro.turns[prepared[index].turn].excluded = Some(TurnExclusion::Outlier);
            prepared.remove(index);
            continue;
        }
        if let Some(axis) = fitted.undetermined() {
            return Err(format!(
                "gyro {} is not identifiable from these turns: turn the device about {0} by 90° or more, with {0} level",
                AXES[axis]
            ));
        }
        write(gyro, &fitted, &prepared, accelerometer, unit, &nominal);
        return Ok(());
    }
}

struct Fitted {
    entries: DVector<f64>,
    jacobian: DMatrix<f64>,
    /// Covariance of the entries for residuals of unit variance.
    unscaled: DMatrix<f64>,
    /// Variance of the whitened residuals.
    scale: f64,
    degrees_of_freedom: f64,
    whitened: DVector<f64>,
    deviations: Vec<f64>,
}

impl Fitted {
    /// The axis of the gyro with the largest part in a direction that the turns do not determine.
    fn undetermined(&self) -> Option<usize> {
        let svd = (&self.jacobian * PLAUSIBLE).svd(false, true);
        let v_t = svd.v_t?;
        let row = svd.singular_values.iter().position(|s| s * NOT_DETERMINED < self.scale.sqrt())?;
        let part = |column: usize| (0..3).map(|i| v_t[(row, 3 * i + column)].powi(2)).sum::<f64>();
        (0..3).max_by(|a, b| part(*a).total_cmp(&part(*b)))
    }
}

/// Weights by the noise of each turn and a variance common to all, which is estimated.
fn weighted(prepared: &[Prepared], mut entries: DVector<f64>, unit: f64) -> Option<Fitted> {
    let degrees = 2.0 * prepared.len() as f64 - 9.0;
    let mut excess = 0.0;
    let mut found = None;
    for round in 0..4 {
        let known: Vec<f64> =
            prepared.iter().map(|turn| turn.direction + turn.integrated * unit * unit).collect();
        let deviations: Vec<f64> =
            known.iter().map(|v| if round == 0 { 1.0 } else { (v + excess).max(1e-16).sqrt() }).collect();
        let minimum = minimise(entries.clone(), if round == 3 { CONVERGED } else { NEARLY }, |entries| {
            linearise(prepared, &deviations, entries, unit)
        })?;
        entries.copy_from(&minimum.parameters);
        let all = residuals(prepared, &to_matrix(&entries, unit));
        let twice: Vec<f64> = known.iter().flat_map(|v| [*v, *v]).collect();
        excess = excess_variance(all.as_slice(), &twice, degrees);
        found = Some((minimum, deviations));
    }
    let (minimum, deviations) = found?;
    let unscaled = covariance(&minimum.at.jacobian)?;
    Some(Fitted {
        entries,
        scale: minimum.at.residuals.norm_squared() / degrees,
        unscaled,
        degrees_of_freedom: degrees,
        jacobian: minimum.at.jacobian,
        whitened: minimum.at.residuals,
        deviations,
    })
}

/// The turn with the largest residual, if that is improbable: the two components are two degrees of freedom of a χ².
fn outlying(fitted: &Fitted, turns: usize) -> Option<usize> {
    let leverage = leverages(&fitted.jacobian, &fitted.unscaled);
    let limit = ChiSquared::new(2.0).ok()?.inverse_cdf(1.0 - OUTLIER_CHANCE / turns as f64);
    let size = |index: usize| -> f64 {
        [2 * index, 2 * index + 1]
            .iter()
            .map(|&row| fitted.whitened[row].powi(2) / (fitted.scale * (1.0 - leverage[row]).max(0.05)))
            .sum()
    };
    let worst = (0..turns).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
    (size(worst) > limit.max(20.0)).then_some(worst)
}

/// The figures of a matrix for people: sensitivities, cross-axis angles (°), angles between axes (°) and to the accelerometer's (°).
fn shown(matrix: &Matrix3<f64>, model: &TriadModel, pairing: &Matrix3<f64>) -> [f64; 15] {
    // Rows: response of each axis of the gyro to a rate in the frame of the accelerometer.
    let sensor = matrix.try_inverse().unwrap_or_else(|| Matrix3::from_element(f64::NAN));
    let accelerometer = model.axes();
    let mut all = [0.0; 15];
    // a gyro whose axes are named otherwise is compared with the axes that it belongs to
    let along: Matrix3<f64> = sensor * pairing;
    let rows: Vec<Vector3<f64>> = (0..3).map(|i| sensor.row(i).transpose().normalize()).collect();
    let mut cross = 3;
    for i in 0..3 {
        all[i] = sensor.row(i).norm();
        for j in (0..3).filter(|j| *j != i) {
            all[cross] = (along[(i, j)] / along.row(i).norm()).clamp(-1.0, 1.0).asin().to_degrees();
            cross += 1;
        }
    }
    for (pair, (i, j)) in PAIRS.into_iter().enumerate() {
        all[9 + pair] = rows[i].dot(&rows[j]).clamp(-1.0, 1.0).acos().to_degrees();
    }
    for i in 0..3 {
        let target = pairing * Vector3::ith(i, 1.0);
        let axis: Vector3<f64> =
            (0..3).map(|k| accelerometer.row(k).transpose() * target[k]).sum::<Vector3<f64>>();
        all[12 + i] = rows[i].cross(&axis).norm().clamp(0.0, 1.0).asin().to_degrees();
    }
    all
}

fn write(
    gyro: &mut Gyro,
    fitted: &Fitted,
    prepared: &[Prepared],
    accelerometer: &Accelerometer,
    unit: f64,
    nominal: &Matrix3<f64>,
) {
    let matrix = to_matrix(&fitted.entries, unit);
    let pairing = nominal.map(|entry| (entry / unit).round());
    let model = &accelerometer.model;
    let of_turns = &fitted.unscaled * fitted.scale.max(1e-30);
    let functions = |matrix: &Matrix3<f64>, model: &TriadModel| shown(matrix, model, &pairing);
    // Derivatives of the shown values by the entries of the matrix, and by the accelerometer's parameters, which turn the
    // directions of gravity and with them the matrix.
    let mut by_entry = DMatrix::zeros(15, 9);
    for entry in 0..9 {
        let moved = |by: f64| {
            let mut entries = fitted.entries.clone();
            entries[entry] += by;
            DVector::from_row_slice(&functions(&to_matrix(&entries, unit), model))
        };
        by_entry.set_column(entry, &((moved(1e-6) - moved(-1e-6)) / 2e-6));
    }
    let mut by_accelerometer = DMatrix::zeros(15, 9);
    let at_rest = residuals(prepared, &matrix);
    for index in 0..9 {
        let deviation = accelerometer.covariance9[(index, index)].sqrt();
        if deviation <= 0.0 || !deviation.is_finite() {
            continue;
        }
        let mut parameters = model.parameters();
        parameters[index] += deviation;
        let moved = TriadModel::of_parameters(&parameters, model.reference_c);
        let turned = |up: &Vector3<f64>| {
            let raw =
                model.measured([up.x, up.y, up.z].map(|x| x * accelerometer.gravity.mps2), model.reference_c);
            Vector3::from(crate::vector::unit(moved.corrected(raw, model.reference_c)))
        };
        let other: Vec<Prepared> = prepared
            .iter()
            .map(|turn| Prepared { rates: turn.rates.clone(), up: turn.up.map(|up| turned(&up)), ..*turn })
            .collect();
        let change = residuals(&other, &matrix) - &at_rest;
        let whitened = DVector::from_fn(change.len(), |row, _| change[row] / fitted.deviations[row / 2]);
        let entries = -&fitted.unscaled * fitted.jacobian.transpose() * whitened;
        let of_model = DVector::from_row_slice(&functions(&matrix, &moved))
            - DVector::from_row_slice(&functions(&matrix, model));
        by_accelerometer.set_column(index, &((&by_entry * entries + of_model) / deviation));
    }
    let covariance = &by_entry * of_turns * by_entry.transpose()
        + &by_accelerometer * &accelerometer.covariance9 * by_accelerometer.transpose();
    let values = functions(&matrix, model);
    let quantile = student(LEVEL, fitted.degrees_of_freedom);
    let per = match gyro.scale {
        Scale::Si => "",
        Scale::Counts => "counts/(rad/s)",
    };
    let cross = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
    let make = |index: usize| {
        let (id, label, unit) = match index {
            0..3 => (format!("sensitivity.{}", AXES[index]), format!("{} sensitivity", AXES[index]), per),
            3..9 => {
                let (i, j) = cross[index - 3];
                let names = format!("{}{}", AXES[i], AXES[j]);
                (format!("cross.{names}"), format!("{} cross-axis to {}", AXES[i], AXES[j]), "°")
            }
            9..12 => {
                let (i, j) = PAIRS[index - 9];
                let names = format!("{}{}", AXES[i], AXES[j]);
                (format!("angle.{names}"), format!("angle {names}"), "°")
            }
            _ => {
                let name = AXES[index - 12];
                (format!("to_accelerometer.{name}"), format!("{name} to accelerometer {name}"), "°")
            }
        };
        Parameter {
            id: format!("gyro.{id}"),
            label: format!("gyro {label}"),
            value: values[index],
            half_width: quantile * covariance[(index, index)].max(0.0).sqrt(),
            unit: unit.to_owned(),
            determined: Determined::Well,
        }
    };
    gyro.parameters.extend((0..9).map(make));
    gyro.derived = (9..15).map(make).collect();
    gyro.correlations = correlations(&covariance.view((0, 0), (9, 9)).into_owned());
    gyro.degrees_of_freedom = fitted.degrees_of_freedom;
    gyro.matrix = Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)])));
    let off = angles(prepared, &matrix);
    let rms_deg = |off: &[f64]| rms(off.iter().copied()).map(f64::to_degrees);
    gyro.rms_deg =
        [rms_deg(&off), (gyro.scale == Scale::Si).then(|| rms_deg(&angles(prepared, nominal))).flatten()];
    for (turn, off) in prepared.iter().zip(off) {
        let shown = &mut gyro.turns[turn.turn];
        shown.residual_deg = off.to_degrees();
        shown.angle_deg = (turn.rates.angle() * unit).to_degrees();
    }
}
