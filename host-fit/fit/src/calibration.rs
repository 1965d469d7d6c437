//! Calibration of a device's triads as part of its model, and the form in which a hub applies it.

use fos_core::{Axis, Calibration, Channel, Image, Quantity, Range, Source, Transform, TriadCalibration};
use fos_data::column::AXES;
use fos_data::recording::Recording;

use crate::model::{FittedAxis, UnitModel};
pub use crate::unit_calibration::UnitCalibration;

/// The axes of a hub, in its order.
const SIX: [Axis; 6] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

/// Distance from the fitted range of an input up to which its error is extrapolated, in widths of the range.
const EXTRAPOLATED: f64 = 1.0;

impl UnitModel {
    /// Returns the calibration for values from which a hub has subtracted the predicted error: each bias without the
    /// error that the model predicts for the temperature of the calibration.
    pub fn device_calibration(&self) -> Option<Calibration<f64>> {
        let found = self.calibration.as_ref()?;
        let axis_of = |axis: Axis| self.axes.iter().find(|fitted| fitted.parameters.axis == axis);
        let (mut accel, mut gyro) = (found.accel, found.gyro.unwrap_or(TriadCalibration::IDENTITY));
        let [ax, ay, az, gx, gy, gz] = SIX;
        for (bias, axis) in accel.bias.iter_mut().zip([ax, ay, az]) {
            *bias -= axis_of(axis).map_or(0.0, |fitted| self.steady_error(fitted, found.temperature_c));
        }
        for (bias, axis) in gyro.bias.iter_mut().zip([gx, gy, gz]) {
            // the model of a gyro contains its whole bias, and follows it at rest
            *bias = if axis_of(axis).is_some() { 0.0 } else { *bias };
        }
        Some(Calibration { accel, gyro })
    }

    /// Error that the physical part predicts after a long time at a temperature, °C, and the mean of everything else,
    /// in the axis' unit; at the mean temperature of the fit if it is unknown.
    fn steady_error(&self, axis: &FittedAxis, temperature_c: Option<f64>) -> f64 {
        let value = |index: u8| -> f64 {
            let Some(named) = self.inputs.get(usize::from(index)) else { return 0.0 };
            let input = &named.input;
            let Source::Quantity(quantity) = input.source else { return 0.0 };
            let logged = self.quantities.get(usize::from(quantity));
            let is_temperature = logged.is_some_and(|logged| logged.quantity == Quantity::Temperature);
            let follows = matches!(input.transform, Transform::Identity | Transform::LowPass { .. });
            let temperature_c = temperature_c.filter(|_| is_temperature && follows);
            temperature_c.map_or(0.0, |temperature_c| {
                // a bias that is right in the fitted range needs the error where it was measured, also somewhat beyond it
                let Range { low, high } = input.range;
                let margin = EXTRAPOLATED * (high - low);
                ((temperature_c - input.centre) / input.scale).clamp(low - margin, high + margin)
            })
        };
        let physical: f64 = axis
            .physical
            .iter()
            .map(|term| {
                let factors = term.factors.iter().map(|factor| match factor.channel {
                    Channel::Input(index) => value(index),
                    Channel::Output => 0.0,
                });
                term.coefficient * factors.product::<f64>()
            })
            .sum();
        axis.parameters.offset + axis.parameters.scale * physical
    }
}

/// Calibrates the corrected values of a model's axes, as a hub does.
#[derive(Debug, Clone)]
pub struct Calibrated {
    calibration: Calibration<f32>,
    /// Index in the model of each axis of a hub.
    places: [Option<usize>; 6],
    /// Latest values of a hub's axes.
    values: [f32; 6],
}

impl Calibrated {
    /// None if the image has no calibration.
    pub fn of(image: &Image<'_>) -> Option<Self> {
        let calibration = image.calibration()?;
        let axes: Vec<Axis> = image.axes().map(|axis| axis.parameters.axis).collect();
        let places = SIX.map(|axis| axes.iter().position(|other| *other == axis));
        Some(Self { calibration, places, values: [0.0; 6] })
    }

    /// Replaces the corrected values of a row, one for each axis of the model, by calibrated ones. `others` returns the
    /// measured value of an axis of a hub that the model does not have; without one, its triad remains as it is.
    pub fn apply(&mut self, corrected: &mut [f32], others: impl Fn(usize) -> Option<f32>) {
        let mut is_known = [true; 6];
        let channels = self.places.iter().zip(&mut is_known).zip(&mut self.values);
        for (channel, ((place, is_known), latest)) in channels.enumerate() {
            let value = match place {
                Some(place) => Some(corrected[*place]),
                None => others(channel),
            };
            *is_known = value.is_some();
            // a hub repeats the last finite value
            *latest = value.filter(|value| value.is_finite()).unwrap_or(*latest);
        }
        for (channel, value) in self.calibration.apply(&self.values).into_iter().enumerate() {
            let triad = channel / 3 * 3;
            if let Some(place) = self.places[channel].filter(|_| is_known[triad..triad + 3] == [true; 3]) {
                corrected[place] = value;
            }
        }
    }
}

/// Columns of a log by axis of a hub, for [`Calibrated::apply`].
pub fn hub_columns(log: &Recording) -> [Option<&[f64]>; 6] {
    AXES.map(|column| log.channel(column).ok().map(|channel| &channel.values[..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{FittedTerm, LoggedQuantity, NamedInput};
    use fos_core::{AxisParameters, FittedOn, InnovationStatistics, Input, Term, u, y};

    fn axis(axis: Axis, offset: f64, physical: Term<f64>) -> FittedAxis {
        let (range, physical_range) = (Range::new(-4.0, 4.0), Range::unlimited());
        let innovation = InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 };
        let parameters = AxisParameters {
            axis,
            reference: 0.0,
            offset,
            scale: 0.5,
            constant: 0.0,
            range,
            physical_range,
            full_scale: 0.0,
            stuck_after_repeats: 0,
            gap_limit_samples: 1,
            coast_limit_s: 10.0,
            innovation,
        };
        let term = |term: Term<f64>| FittedTerm {
            coefficient: term.coefficient,
            standard_error: None,
            factors: term.factors().to_vec(),
        };
        let (physical, stochastic) = (vec![term(physical)], vec![term(Term::new(0.5, &[y(1)]))]);
        FittedAxis { column: String::new(), parameters, physical, stochastic, plain: None }
    }

    fn model(temperature_c: Option<f64>) -> UnitModel {
        let range = Range::new(-2.0, 2.0);
        let input = |transform| NamedInput {
            name: String::new(),
            input: Input {
                source: Source::Quantity(0),
                transform,
                centre: 30.0,
                scale: 10.0,
                source_range: range,
                range,
            },
        };
        let triad = TriadCalibration { bias: [0.1, 0.2, 0.3], ..TriadCalibration::IDENTITY };
        UnitModel {
            period_s: 0.01,
            fitted_on: FittedOn::Raw,
            stillness: None,
            calibration: Some(UnitCalibration {
                sources: Vec::new(),
                rests: 12,
                gravity_residual_mps2: [0.2, 0.01],
                temperature_c,
                accel: triad,
                gyro: Some(triad),
            }),
            quantities: vec![LoggedQuantity { column: "temp_c".to_owned(), quantity: Quantity::Temperature }],
            inputs: vec![input(Transform::LowPass { tau_s: 60.0 }), input(Transform::Rate { tau_s: 10.0 })],
            axes: vec![
                axis(Axis::Ay, 0.05, Term::new(0.4, &[u(0, 0), u(0, 0)])),
                axis(Axis::Az, 0.0, Term::new(0.4, &[u(1, 0)])),
                axis(Axis::Gx, 0.1, Term::new(0.4, &[u(0, 0)])),
            ],
        }
    }

    /// At 45 °C the lagged temperature is 1.5 scaled units above its centre: 0.05 + 0.5·0.4·1.5² = 0.5.
    #[test]
    fn bias_is_without_the_error_that_the_model_predicts() {
        let bias = |temperature_c| {
            let found = model(temperature_c).device_calibration().expect("a calibration");
            [found.accel.bias, found.gyro.bias]
        };
        let is = |found: [[f64; 3]; 2], expected: [[f64; 3]; 2]| {
            let pairs = found.iter().flatten().zip(expected.iter().flatten());
            assert!(pairs.into_iter().all(|(one, other)| (one - other).abs() < 1e-12), "{found:?}");
        };
        is(bias(Some(45.0)), [[0.1, 0.2 - 0.5, 0.3], [0.0, 0.2, 0.3]]);
        is(bias(None), [[0.1, 0.2 - 0.05, 0.3], [0.0, 0.2, 0.3]]);
        // far beyond the fitted range of ±2, at 6: 0.05 + 0.5·0.4·6²
        is(bias(Some(120.0)), [[0.1, 0.2 - 0.05 - 7.2, 0.3], [0.0, 0.2, 0.3]]);
    }
}
