//! Bias, sensitivity and cross-axis of the two triads, applied to values from which the predicted error is subtracted.

use serde::{Deserialize, Serialize};

use crate::Scalar;

/// Calibration of three axes that measure one vector: corrected = matrix · (value − bias).
///
/// It follows the model, because a drifting bias adds to each axis as it lies in the sensor, and because saturation,
/// repeated codes and rest show in the values of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TriadCalibration<R> {
    /// Inverse of sensitivity and cross-axis, row by row; magnitudes at most 4.
    pub matrix: [[R; 3]; 3],
    /// Value without acceleration or rotation, after the predicted error is subtracted, m/s² or rad/s.
    pub bias: [R; 3],
}

/// Calibration of accelerometers and gyros.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Calibration<R> {
    /// Specific force, m/s².
    pub accel: TriadCalibration<R>,
    /// Angular rate, rad/s.
    pub gyro: TriadCalibration<R>,
}

impl<R: Scalar> TriadCalibration<R> {
    /// The calibration that changes nothing.
    pub const IDENTITY: Self = Self {
        matrix: [[R::ONE, R::ZERO, R::ZERO], [R::ZERO, R::ONE, R::ZERO], [R::ZERO, R::ZERO, R::ONE]],
        bias: [R::ZERO; 3],
    };

    /// The calibrated vector; finite if `values` are.
    #[inline]
    pub fn apply(&self, values: [R; 3]) -> [R; 3] {
        let [x, y, z] = values;
        let [bx, by, bz] = self.bias;
        let (x, y, z) = (x - bx, y - by, z - bz);
        self.matrix.map(|[along_x, along_y, along_z]| {
            let sum = R::add_product(R::NOTHING, along_x, x);
            let sum = R::add_product(R::add_product(sum, along_y, y), along_z, z);
            // values near the largest one overflow
            R::end(sum).limit(-R::MAX, R::MAX)
        })
    }

    /// The same calibration in another scalar.
    pub fn convert<S: Scalar>(&self) -> TriadCalibration<S> {
        let convert = |value: R| crate::real::scalar(value);
        TriadCalibration { matrix: self.matrix.map(|row| row.map(convert)), bias: self.bias.map(convert) }
    }
}

impl<R: Scalar> Calibration<R> {
    /// The calibrated values: accelerometers x, y, z, then gyros x, y, z.
    #[inline]
    pub fn apply(&self, values: &[R; 6]) -> [R; 6] {
        let [ax, ay, az, gx, gy, gz] = *values;
        let ([ax, ay, az], [gx, gy, gz]) = (self.accel.apply([ax, ay, az]), self.gyro.apply([gx, gy, gz]));
        [ax, ay, az, gx, gy, gz]
    }

    /// The same calibration in another scalar.
    pub fn convert<S: Scalar>(&self) -> Calibration<S> {
        Calibration { accel: self.accel.convert(), gyro: self.gyro.convert() }
    }
}
