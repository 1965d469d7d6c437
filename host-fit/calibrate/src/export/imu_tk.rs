//! imu_tk's form: a file for each sensor with the matrices T (misalignment) and K (scale) and the bias b, row by row.
//!
//! imu_tk computes T·K·(raw − b), with ones on the diagonal of T; that of the accelerometer is upper triangular
//! (include/imu_tk/calibration.h, `CalibratedTriad_::load`, `unbiasNormalize`). Its frame has the accelerometer's z axis as its own.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};

use crate::Calibration;

/// T, K, b of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuTkTriad {
    pub misalignment: Matrix3<f64>,
    pub scale: Matrix3<f64>,
    pub bias: Vector3<f64>,
}

/// Both sensors in imu_tk's form.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuTk {
    pub accelerometer: ImuTkTriad,
    pub gyro: Option<ImuTkTriad>,
    /// From the frame of the certificate to imu_tk's.
    pub rotation: Matrix3<f64>,
}

impl ImuTk {
    pub fn of(calibration: &Calibration) -> Self {
        let model = &calibration.accelerometer.model;
        let (matrix, bias) = model.correction(model.reference_c);
        // M = Q·R: R is M in the frame turned by Qᵀ.
        let qr = Matrix3::from_fn(|i, j| matrix[i][j]).qr();
        let signs =
            Matrix3::from_diagonal(&qr.r().diagonal().map(|entry| if entry < 0.0 { -1.0 } else { 1.0 }));
        let rotation = signs * qr.q().transpose();
        let triad = |matrix: Matrix3<f64>, bias: [f64; 3]| {
            let scale = Matrix3::from_diagonal(&matrix.diagonal());
            // divided column by column: T·K is the matrix
            let misalignment = Matrix3::from_fn(|i, j| matrix[(i, j)] / matrix[(j, j)]);
            ImuTkTriad { misalignment, scale, bias: Vector3::from(bias) }
        };
        let gyro = calibration.gyro.as_ref().and_then(|gyro| {
            let entries = gyro.matrix?;
            Some(triad(rotation * Matrix3::from_fn(|i, j| entries[i][j]), gyro.bias))
        });
        Self { accelerometer: triad(signs * qr.r(), bias), gyro, rotation }
    }
}

impl ImuTkTriad {
    /// The file that `CalibratedTriad_::load` reads.
    pub fn file(&self) -> String {
        let mut text = String::new();
        for matrix in [&self.misalignment, &self.scale] {
            for i in 0..3 {
                // writing to a string does not fail
                let _ =
                    writeln!(text, "{:.12e} {:.12e} {:.12e}", matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]);
            }
            text.push('\n');
        }
        for value in self.bias.iter() {
            let _ = writeln!(text, "{value:.12e}");
        }
        text
    }
}
