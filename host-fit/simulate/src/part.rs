//! Phone-class parts by their data sheets, and devices drawn from them.

use serde::Serialize;

use super::axis::Axis;
use super::coloured::{AxisNoise, Colour};
use super::random::{Random, between, log_normal, normal};
use fos_data::unit::{MG_MPS2, STANDARD_GRAVITY_MPS2};

/// One degree, rad.
pub(super) const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Figures of a part from its data sheet.
///
/// Sources. Looked up in the data sheets: BMI270, BST-BMI270-DS000-07 (0.007 °/s/√Hz, 160 µg/√Hz); ICM-42688-P, first
/// page (2.8 mdps/√Hz, 70 µg/√Hz); MPU-6050, PS-MPU-6000A-00 3.4, tables 6.1 and 6.2 (0.005 °/s/√Hz, 400 µg/√Hz, ±35 mg
/// over 70 K, ±20 °/s over 125 K). At second hand, not checked against a data sheet: the ICM's 0.005 dps/K
/// (github.com/xioTechnologies/Fusion, issue 191); the LSM6DSO's 3.8 mdps/√Hz, 0.01 dps/K and 0.1 mg/K (from tables of
/// the LSM6DSO32); the BMI160 and the coefficients of the BMI270 (as stated in the examples of the case format).
/// Working figures: all bias instabilities, the LSM6DSO's 80 µg/√Hz, the ICM's 0.15 mg/K.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Part {
    /// Name, in lower case.
    pub name: &'static str,
    /// Noise density of the gyros, °/s/√Hz.
    pub gyro_noise_density_dps_rthz: f64,
    /// Noise density of the accelerometers, µg/√Hz.
    pub accel_noise_density_ug_rthz: f64,
    /// Bias instability of the gyros, °/h: flat of the Allan deviation over 0.664.
    pub gyro_bias_instability_dph: f64,
    /// Bias instability of the accelerometers, µg.
    pub accel_bias_instability_ug: f64,
    /// Temperature coefficient of the gyros' offset, °/s/K.
    pub gyro_tco_dps_per_k: f64,
    /// Temperature coefficient of the accelerometers' offset, mg/K.
    pub accel_tco_mg_per_k: f64,
    /// Configured full scale of the gyros, °/s.
    pub gyro_full_scale_dps: f64,
    /// Configured full scale of the accelerometers, g.
    pub accel_full_scale_g: f64,
}

/// Parts available for simulation, all set to ±250 °/s and ±4 g in 16 bits.
pub const PARTS: [Part; 5] = [
    part("bmi160", [0.007, 180.0, 9.0, 55.0, 0.05, 1.0]),
    part("bmi270", [0.007, 160.0, 7.0, 45.0, 0.02, 0.25]),
    part("lsm6dso", [0.0038, 80.0, 5.0, 35.0, 0.01, 0.1]),
    part("icm42688", [0.0028, 70.0, 4.0, 30.0, 0.005, 0.15]),
    part("mpu6050", [0.005, 400.0, 12.0, 100.0, 0.16, 0.5]),
];

const fn part(name: &'static str, figures: [f64; 6]) -> Part {
    Part {
        name,
        gyro_noise_density_dps_rthz: figures[0],
        accel_noise_density_ug_rthz: figures[1],
        gyro_bias_instability_dph: figures[2],
        accel_bias_instability_ug: figures[3],
        gyro_tco_dps_per_k: figures[4],
        accel_tco_mg_per_k: figures[5],
        gyro_full_scale_dps: 250.0,
        accel_full_scale_g: 4.0,
    }
}

/// Logarithmic spread of white level, flicker and random walk between devices of a part.
const SPREAD: [f64; 3] = [0.2, 0.35, 0.7];

/// Ratio of the median random walk per √s to the bias instability: meets the flat of the flicker after 1.3 h,
/// √(3 τ⁻¹) · 0.664 · 60 = 1.
const WALK_OF_FLICKER: f64 = 1.0 / 60.0;

impl Part {
    pub fn named(name: &str) -> Option<Self> {
        PARTS.iter().copied().find(|part| part.name == name)
    }

    /// Full scale of an axis, m/s² or rad/s.
    pub fn full_scale(&self, axis: Axis) -> f64 {
        if axis.is_gyro() {
            self.gyro_full_scale_dps * DEGREE
        } else {
            self.accel_full_scale_g * STANDARD_GRAVITY_MPS2
        }
    }

    /// Least significant bit of an axis, m/s² or rad/s: 16 bits over the full scale.
    pub fn lsb(&self, axis: Axis) -> f64 {
        self.full_scale(axis) / 32768.0
    }

    /// Noise density of an axis, m/s²/√Hz or rad/s/√Hz.
    pub fn noise_density(&self, axis: Axis) -> f64 {
        if axis.is_gyro() {
            self.gyro_noise_density_dps_rthz * DEGREE
        } else {
            self.accel_noise_density_ug_rthz * 1e-3 * MG_MPS2
        }
    }

    /// Bias instability of an axis, m/s² or rad/s.
    pub fn bias_instability(&self, axis: Axis) -> f64 {
        if axis.is_gyro() {
            self.gyro_bias_instability_dph / 3600.0 * DEGREE
        } else {
            self.accel_bias_instability_ug * 1e-3 * MG_MPS2
        }
    }

    /// Draws the noise of one axis of a device at `rate_hz`.
    pub(super) fn draw_noise(&self, axis: Axis, rate_hz: f64, random: &mut Random) -> AxisNoise {
        let density = log_normal(random, self.noise_density(axis), SPREAD[0]);
        let flicker = log_normal(random, self.bias_instability(axis), SPREAD[1]);
        let random_walk = log_normal(random, flicker * WALK_OF_FLICKER, SPREAD[2]);
        let colour = Colour::draw(random);
        AxisNoise::new(density, flicker, random_walk, colour, rate_hz)
    }

    /// Draws the bias of one axis of a device, in the axis' unit: typical values after soldering.
    pub(super) fn draw_bias(&self, axis: Axis, random: &mut Random) -> f64 {
        if axis.is_gyro() { 0.5 * DEGREE * normal(random) } else { 20.0 * MG_MPS2 * normal(random) }
    }
}

/// True sampling rate of a device, Hz, for a nominal one: off by up to 1.5 %.
pub(super) fn true_rate(nominal_hz: f64, random: &mut Random) -> f64 {
    nominal_hz * (1.0 + between(random, -0.015, 0.015))
}
