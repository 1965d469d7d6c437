//! Files for the devices of a part: one image, and a short record for each unit.
//!
//! The image has the mean of the population. A record has the estimate of its unit, from the unit's own log and the population. A unit
//! without a record runs on the image of its part.

use std::collections::BTreeMap;

use fos_core::image::{UnitError, encode_unit, for_unit};
use fos_core::{AxisParameters, Channel, FittedOn, Image, InnovationStatistics, Range, StillnessLimits};
use fos_data::column::Column;
use fos_data::statistics::median_of;
use fos_data::unit::Unit;
use fos_diagnose::effects::Regressor;
use fos_diagnose::refine::factors;
use fos_fit::export::{UnusableImage, image};
use fos_fit::fit::InputSpec;
use fos_fit::model::{FittedAxis, FittedTerm, UnitModel};

use crate::estimate::{BIAS, Estimate, REFERENCE_C};
use crate::fleet::{AxisSummary, PartSummary};
use crate::population::Population;
use crate::row::UnitRow;

/// Deviation of a unit from the mean of its part, in standard deviations, up to which the image admits its physical part.
const REACH: f64 = 5.0;

/// Gap that is bridged, s: one or two missing samples.
const GAP_LIMIT_S: f64 = 0.1;

/// Range of the remainder, in standard deviations of white noise: nothing is predicted from it.
const REMAINDER: Range<f64> = Range { low: -6.0, high: 6.0 };

/// Limit of a coast, s. The model has no stochastic part whose prediction could fade.
const COAST_LIMIT_S: f64 = 1.0;

/// Files for the devices of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Shipment {
    /// Model of the part.
    pub model: UnitModel,
    pub image: Vec<u8>,
    /// Records of all units with at least one estimated axis, in the order of the rows.
    pub units: Vec<ShippedUnit>,
    /// Units without an estimate; they run on the image of the part.
    pub without: Vec<String>,
}

/// A unit and its record.
#[derive(Debug, Clone, PartialEq)]
pub struct ShippedUnit {
    pub unit: String,
    pub lot: Option<String>,
    /// The unit does not belong to its population, so its own estimates are used where it has them.
    pub odd: bool,
    /// Record as defined in docs/MODEL_FORMAT.md.
    pub record: Vec<u8>,
}

/// A part cannot be shipped.
#[derive(Debug, thiserror::Error)]
pub enum ShipError {
    #[error(
        "{}no axis of this part has a population\nhelp: a fleet of at least three devices, at rest for some minutes while the temperature changes", named(.0)
    )]
    NoPopulation(String),
    /// A row lacks what the image needs.
    #[error(
        "{}the rows have no range of {input}\nhelp: make the population again: these are rows of an earlier version", named(.part)
    )]
    NotSeen { part: String, input: String },
    #[error(transparent)]
    Image(#[from] UnusableImage),
    #[error("{unit}: {error}\nhelp: a shorter name, of at most 65535 bytes")]
    Unit { unit: String, error: UnitError },
}

fn named(part: &str) -> String {
    if part.is_empty() { String::new() } else { format!("{part}: ") }
}

impl Shipment {
    /// Makes the files of a part from its summary and rows. `values` states the kind of sensor values the model applies to; `sensor`
    /// and `provenance` are stored in the image.
    pub fn of(
        part: &PartSummary,
        rows: &[UnitRow],
        values: FittedOn,
        sensor: &str,
        provenance: &str,
    ) -> Result<Self, ShipError> {
        let axes: Vec<(&AxisSummary, &Population)> =
            part.axes.iter().filter_map(|axis| Some((axis, axis.population.as_ref()?))).collect();
        if axes.is_empty() {
            return Err(ShipError::NoPopulation(part.part.clone()));
        }
        let rows: Vec<&UnitRow> = rows.iter().filter(|row| row.part == part.part).collect();
        let model = model_of(part, &axes, &rows, values)?;
        let image = image(&model, sensor, provenance)?;
        let (mut units, mut without) = (Vec::new(), Vec::new());
        for row in rows {
            if row.axes.is_empty() {
                without.push(row.unit.clone());
                continue;
            }
            let odd = part.odd.iter().any(|odd| odd.unit == row.unit);
            let known: Vec<Estimate> =
                axes.iter().map(|(axis, population)| known_of(row, &axis.column, population, odd)).collect();
            let failed = |error| ShipError::Unit { unit: row.unit.clone(), error };
            units.push(ShippedUnit {
                unit: row.unit.clone(),
                lot: row.lot.clone(),
                odd,
                record: record(&image, &model, &row.unit, &known).map_err(failed)?,
            });
        }
        Ok(Self { model, image, units, without })
    }
}

/// Estimate of all coefficients of an axis of a unit: its own log combined with the population. For an odd unit, which does not belong to
/// the population, its own estimates where it has them.
pub fn known_of(row: &UnitRow, column: &str, population: &Population, odd: bool) -> Estimate {
    let lot = row.lot.as_deref();
    let own = row.axis(column).map(|axis| &axis.estimate.coefficients);
    if let (Some(own), false) = (own, odd) {
        return population.of_member(own, lot);
    }
    let (values, covariance) = population.prior(lot);
    let mut known = Estimate { names: population.names.clone(), values, covariance };
    let Some(own) = own else { return known };
    let places: Vec<Option<usize>> = population.names.iter().map(|name| own.place(name)).collect();
    for (first, of_first) in places.iter().enumerate() {
        if let Some(of_first) = of_first {
            known.values[first] = own.values[*of_first];
        }
        for (second, of_second) in places.iter().enumerate() {
            // what its own log says is independent of the population
            known.covariance[first][second] = match (of_first, of_second) {
                (Some(of_first), Some(of_second)) => own.covariance[*of_first][*of_second],
                (None, None) => known.covariance[first][second],
                _ => 0.0,
            };
        }
    }
    known
}

/// Makes the record of a unit and checks that it applies to the image.
fn record(part: &[u8], model: &UnitModel, unit: &str, known: &[Estimate]) -> Result<Vec<u8>, UnitError> {
    let mut values = Vec::new();
    for (axis, known) in model.axes.iter().zip(known) {
        let scale = axis.parameters.scale;
        values.push(known.place(BIAS).map_or(0.0, |place| known.values[place]) as f32);
        for (name, value) in known.names.iter().zip(&known.values).filter(|(name, _)| *name != BIAS) {
            // All products of a regressor share its coefficient.
            let products = Regressor::parse(name).map_or(0, |regressor| regressor.products.len());
            values.extend(std::iter::repeat_n((value / scale) as f32, products));
        }
    }
    let mut buffer = vec![0; fos_core::image::UNIT_HEADER_LENGTH + unit.len() + 4 * values.len()];
    let record = encode_unit(part, unit, values.iter().copied(), &mut buffer)?.to_vec();
    let mut own = vec![0; part.len()];
    let own = for_unit(part, &record, &mut own)?;
    Image::parse(own).map_err(UnitError::Part)?;
    Ok(record)
}

fn model_of(
    part: &PartSummary,
    axes: &[(&AxisSummary, &Population)],
    rows: &[&UnitRow],
    values: FittedOn,
) -> Result<UnitModel, ShipError> {
    let logs = || rows.iter().filter_map(|row| row.log.as_ref());
    let rate_hz =
        median_of(logs().map(|log| log.rate_hz)).ok_or_else(|| ShipError::NoPopulation(part.part.clone()))?;
    let mut seen: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (name, [low, high]) in logs().flat_map(|log| &log.inputs) {
        let all = seen.entry(name.clone()).or_insert([*low, *high]);
        *all = [all[0].min(*low), all[1].max(*high)];
    }
    let regressors: Vec<Regressor> = axes
        .iter()
        .flat_map(|(_, population)| &population.names)
        .filter_map(|name| Regressor::parse(name).ok().filter(|_| name != BIAS))
        .collect();
    // A linear term extrapolates safely, so only inputs of powers are limited to the observed range.
    let limits = regressors.iter().flat_map(Regressor::powers).filter_map(|input| {
        let name = input.to_string();
        seen.get(&name).map(|seen| (name, *seen))
    });
    let limits: BTreeMap<String, [f64; 2]> = limits.collect();
    let mut model = UnitModel {
        period_s: 1.0 / rate_hz,
        fitted_on: values,
        stillness: stillness(logs().filter_map(|log| log.stillness).collect()),
        calibration: None,
        quantities: Vec::new(),
        inputs: Vec::new(),
        axes: Vec::new(),
    };
    for (axis, population) in axes {
        let scale = scale(axis, rate_hz);
        let mut physical = Vec::new();
        let mut reach = [0.0; 2];
        for (place, name) in population.names.iter().enumerate().filter(|(_, name)| *name != BIAS) {
            // All names were parsed for the estimates, so this cannot fail.
            let Ok(Regressor { products }) = Regressor::parse(name) else { continue };
            let deviation = deviation(population, place);
            for product in &products {
                let of_seen = |spec: &InputSpec| {
                    let input = spec.to_string();
                    let seen =
                        seen.get(&input).copied().or_else(|| spec.column.is_none().then_some([0.0; 2]));
                    seen.ok_or_else(|| ShipError::NotSeen { part: part.part.clone(), input })
                };
                let factors = factors(model.inputs_mut(), product, centre, &limits, of_seen)?;
                let mean = population.mean[place] / scale;
                let most = (mean.abs() + REACH * deviation / scale)
                    * factors.iter().map(|factor| largest(&model, factor.channel)).product::<f64>();
                reach = [reach[0] - most, reach[1] + most];
                physical.push(FittedTerm {
                    coefficient: mean,
                    standard_error: Some(population.mean_covariance[place][place].sqrt() / scale),
                    factors,
                });
            }
        }
        model.axes.push(FittedAxis {
            column: axis.column.clone(),
            parameters: AxisParameters {
                axis: Column::named(&axis.column).axis(),
                // Unknown for an accelerometer: it depends on the orientation of the unit.
                reference: 0.0,
                offset: bias_of(population),
                scale,
                constant: 0.0,
                range: REMAINDER,
                physical_range: Range::new(reach[0], reach[1]),
                full_scale: 0.0,
                stuck_after_repeats: 0,
                gap_limit_samples: (GAP_LIMIT_S * rate_hz).round().clamp(1.0, 255.0) as u8,
                coast_limit_s: COAST_LIMIT_S,
                innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
            },
            physical,
            stochastic: Vec::new(),
            plain: None,
        });
    }
    Ok(model)
}

/// White noise of a sample, median over the units, in the axis' unit.
fn scale(axis: &AxisSummary, rate_hz: f64) -> f64 {
    let white = axis.median_noise[0] * rate_hz.sqrt();
    // Constant output has no noise.
    white.max(f64::from(f32::EPSILON))
}

fn bias_of(population: &Population) -> f64 {
    population.names.iter().position(|name| name == BIAS).map_or(0.0, |place| population.mean[place])
}

/// Standard deviation of a coefficient about the mean of the part, between lots and units.
fn deviation(population: &Population, place: usize) -> f64 {
    (population.between_lots[place][place] + population.between_units[place][place]).sqrt()
}

/// Value subtracted from a column, the same as in the estimates.
fn centre(column: &str) -> f64 {
    if Column::named(column).unit() == Unit::Celsius { REFERENCE_C } else { 0.0 }
}

/// Largest magnitude of an input within its limits.
fn largest(model: &UnitModel, channel: Channel) -> f64 {
    match channel {
        Channel::Input(input) => {
            let Range { low, high } = model.inputs[usize::from(input)].input.limits();
            low.abs().max(high.abs())
        }
        Channel::Output => 0.0,
    }
}

/// Median limits of the units, centred on the median rate at rest, with a deviation wide enough for every unit at rest.
fn stillness(of_units: Vec<StillnessLimits<f64>>) -> Option<StillnessLimits<f64>> {
    let median = |of: &dyn Fn(&StillnessLimits<f64>) -> f64| median_of(of_units.iter().map(of));
    let mut gyro_at_rest = [0.0; 3];
    for (axis, at_rest) in gyro_at_rest.iter_mut().enumerate() {
        *at_rest = median(&|limits| limits.gyro_at_rest[axis])?;
    }
    let reach = |limits: &StillnessLimits<f64>| {
        let off = limits.gyro_at_rest.iter().zip(&gyro_at_rest).map(|(own, all)| (own - all).powi(2));
        off.sum::<f64>().sqrt() + limits.gyro_deviation
    };
    Some(StillnessLimits {
        window: median(&|limits| f64::from(limits.window))?.round() as u16,
        accel_variance: median(&|limits| limits.accel_variance)?,
        gyro_variance: median(&|limits| limits.gyro_variance)?,
        gyro_at_rest,
        gyro_deviation: of_units.iter().map(reach).reduce(f64::max)?,
    })
}
