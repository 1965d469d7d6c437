//! Kalibr's and OpenVINS's intrinsics of an IMU: the scale-misalignment model.
//!
//! Kalibr models the raw values as M·a + b for the accelerometer, M lower triangular, and M·C·ω + A·C·a + b for the gyro, M lower
//! triangular and C a rotation from the frame of the IMU to that of the gyro
//! (kalibr_imu_camera_calibration/IccSensors.py, `IccScaledMisalignedImu`). To correct: a = M⁻¹(raw − b), then
//! ω = C⁻¹M⁻¹(raw − b − A·C·a). The frame of the IMU is the one in which the accelerometer's M is lower triangular: its x axis is
//! the accelerometer's. It is turned by up to the cross-axis angles against the frame of the certificate.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};

use super::in_comment;
use crate::Calibration;

/// Intrinsics in Kalibr's form.
#[derive(Debug, Clone, PartialEq)]
pub struct Kalibr {
    pub accelerometer_m: Matrix3<f64>,
    pub accelerometer_bias: Vector3<f64>,
    pub gyro: Option<KalibrGyro>,
    /// From the frame of the certificate to that of the IMU.
    pub rotation: Matrix3<f64>,
}

/// The gyro's.
#[derive(Debug, Clone, PartialEq)]
pub struct KalibrGyro {
    pub m: Matrix3<f64>,
    pub c: Matrix3<f64>,
    pub a: Matrix3<f64>,
    pub bias: Vector3<f64>,
}

impl Kalibr {
    pub fn of(calibration: &Calibration) -> Self {
        let model = &calibration.accelerometer.model;
        let sensor = Matrix3::from_diagonal(&Vector3::from(model.sensitivity)) * model.axes();
        let (accelerometer_m, rotation) = lower(&sensor);
        let gyro = calibration.gyro.as_ref().and_then(|gyro| {
            let matrix = gyro.matrix?;
            let sensor = Matrix3::from_fn(|i, j| matrix[i][j]).try_inverse()?;
            let (m, c) = lower(&(sensor * rotation.transpose()));
            let by_g = gyro.g_sensitivity.filter(|_| gyro.is_g_sensitive).unwrap_or([[0.0; 3]; 3]);
            let a = Matrix3::from_fn(|i, j| by_g[i][j]) * rotation.transpose() * c.transpose();
            Some(KalibrGyro { m, c, a, bias: Vector3::from(gyro.bias) })
        });
        Self { accelerometer_m, accelerometer_bias: Vector3::from(model.bias), gyro, rotation }
    }

    /// The file `imu.yaml`'s intrinsics, with the formula that applies them.
    pub fn file(&self, log: &str) -> String {
        let mut text = format!(
            "# Intrinsics of an IMU, from {}, by fos\n\
             # Raw values are M a + b (accelerometer) and M C_gyro_i w + A C_gyro_i a + b (gyro), so that\n\
             #   a = inv(M_accel) (raw - b_accel)\n\
             #   w = inv(C_gyro_i) inv(M_gyro) (raw - b_gyro - A C_gyro_i a)\n\
             # in the frame of the IMU, whose x axis is that of the accelerometer.\n\
             model: scale-misalignment\n\
             accelerometers:\n",
            in_comment(log)
        );
        let _ = write!(text, "  M:\n{}", rows(&self.accelerometer_m));
        let _ = writeln!(text, "  b: {}", row(self.accelerometer_bias.as_slice()));
        if let Some(gyro) = &self.gyro {
            let _ = write!(text, "gyroscopes:\n  M:\n{}  A:\n{}", rows(&gyro.m), rows(&gyro.a));
            let _ = write!(text, "  C_gyro_i:\n{}", rows(&gyro.c));
            let _ = writeln!(text, "  b: {}", row(gyro.bias.as_slice()));
        }
        text
    }
}

/// A lower triangular matrix with a positive diagonal and a rotation (or reflection) whose product is `matrix`.
fn lower(matrix: &Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    // matrixᵀ = Q·R gives matrix = Rᵀ·Qᵀ
    let qr = matrix.transpose().qr();
    let (q, r) = (qr.q(), qr.r());
    let signs = Matrix3::from_diagonal(&r.diagonal().map(|entry| if entry < 0.0 { -1.0 } else { 1.0 }));
    ((signs * r).transpose(), (q * signs).transpose())
}

fn row(values: &[f64]) -> String {
    let listed: Vec<String> = values.iter().map(|value| format!("{value:.10e}")).collect();
    format!("[{}]", listed.join(", "))
}

fn rows(matrix: &Matrix3<f64>) -> String {
    (0..3).map(|i| format!("  - {}\n", row(&[matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lower_factor_and_rotation_give_the_matrix() {
        let matrix = Matrix3::new(1.02, 0.01, -0.02, 0.03, -0.97, 0.01, 0.0, -0.03, 1.01);
        let (m, c) = lower(&matrix);
        assert!((m * c - matrix).norm() < 1e-14);
        assert!((c * c.transpose() - Matrix3::identity()).norm() < 1e-14);
        assert!(
            m.upper_triangle().iter().filter(|x| **x != 0.0).count() <= 3
                || (m[(0, 1)].abs() + m[(0, 2)].abs() + m[(1, 2)].abs()) < 1e-14
        );
        assert!(m.diagonal().iter().all(|entry| *entry > 0.0));
    }
}
