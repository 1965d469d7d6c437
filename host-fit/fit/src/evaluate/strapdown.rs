//! Heading and position errors after a time without aiding: the residuals of six axes, through a strapdown.
//!
//! The device is at rest, so a perfect strapdown would stay where it is. With residuals ω of the gyros and r of the
//! accelerometers, held for one period Δt each, attitude C, velocity v and position p from C = I, v = p = 0 (Titterton and
//! Weston 2004, sections 3.5 and 11.2):
//!
//! a = C·(f + r) − f,  p ← p + v·Δt + a·Δt²/2,  v ← v + a·Δt,  C ← C·exp(\[ω×\]Δt),
//!
//! where f, the specific force that carries the device, is the mean of the accelerometers at the start of the window. So
//! an attitude error tilts gravity into the horizontal axes: a constant gyro residual b gives g·b·t³/6. Without
//! latitude and rotation of the earth. All vectors are in the axes of the device.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::model::UnitModel;
use fos_data::column::{ACCELEROMETERS, GYROS};

/// Places of the accelerometers and gyros x, y, z among the axes of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SixAxes {
    pub(super) accelerometers: [usize; 3],
    gyros: [usize; 3],
}

impl SixAxes {
    /// Returns none unless the model has all six axes.
    pub(super) fn of(model: &UnitModel) -> Option<Self> {
        let place = |column: &str| model.axes.iter().position(|axis| axis.column == column);
        let places = |columns: [&str; 3]| -> Option<[usize; 3]> {
            let [x, y, z] = columns.map(place);
            Some([x?, y?, z?])
        };
        Some(Self { accelerometers: places(ACCELEROMETERS)?, gyros: places(GYROS)? })
    }
}

/// Error at the end of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrapdownEnd {
    /// Rotation about the vertical, rad.
    pub heading_rad: f64,
    /// Displacement along the axes of the device, m.
    pub position_m: [f64; 3],
}

impl StrapdownEnd {
    pub(super) fn is_finite(&self) -> bool {
        self.heading_rad.is_finite() && self.position_m.iter().all(|position| position.is_finite())
    }
}

/// State of a strapdown in one window.
#[derive(Debug, Clone)]
pub(super) struct Strapdown {
    axes: SixAxes,
    period_s: f64,
    /// Specific force at rest, m/s².
    force: Vector3<f64>,
    attitude: Quaternion<f64>,
    velocity: Vector3<f64>,
    position: Vector3<f64>,
}

impl Strapdown {
    /// Starts a window with the specific force `force` at rest, m/s², x, y, z.
    pub(super) fn new(axes: SixAxes, force: [f64; 3], period_s: f64) -> Self {
        Self {
            axes,
            period_s,
            force: force.into(),
            attitude: Quaternion::identity(),
            velocity: Vector3::zeros(),
            position: Vector3::zeros(),
        }
    }

    /// Advances by one sample with the residuals of all axes of the model, m/s² and rad/s.
    #[inline]
    pub(super) fn step(&mut self, residuals: &[f64]) {
        let of = |places: [usize; 3]| Vector3::from(places.map(|place| residuals[place]));
        let acceleration = rotated(&self.attitude, &(self.force + of(self.axes.accelerometers))) - self.force;
        self.position += (self.velocity + acceleration * (0.5 * self.period_s)) * self.period_s;
        self.velocity += acceleration * self.period_s;
        // a residual turns by far less than a milliradian within a sample: the next term is below rounding
        let half = of(self.axes.gyros) * (0.5 * self.period_s);
        self.attitude *= Quaternion::from_parts(1.0 - 0.5 * half.norm_squared(), half);
    }

    /// Error after the samples so far.
    pub(super) fn end(&self) -> StrapdownEnd {
        let turned = UnitQuaternion::from_quaternion(self.attitude).scaled_axis();
        StrapdownEnd {
            heading_rad: turned.dot(&self.force) / self.force.norm(),
            position_m: self.position.into(),
        }
    }
}

/// Vector rotated by a quaternion of unit length: v + 2u×(u×v + w·v).
#[inline]
fn rotated(by: &Quaternion<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    let axis = by.vector();
    vector + 2.0 * axis.cross(&(axis.cross(vector) + by.w * vector))
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: SixAxes = SixAxes { accelerometers: [0, 1, 2], gyros: [3, 4, 5] };
    const G: f64 = 9.81;

    /// Error after `seconds` at 100 Hz with constant residuals, standing on z.
    fn after(seconds: f64, residuals: [f64; 6]) -> StrapdownEnd {
        let mut strapdown = Strapdown::new(AXES, [0.0, 0.0, G], 0.01);
        (0..(seconds * 100.0) as usize).for_each(|_| strapdown.step(&residuals));
        strapdown.end()
    }

    #[test]
    fn a_constant_gyro_residual_tilts_gravity_into_the_position() {
        let b = 1e-5;
        let end = after(60.0, [0.0, 0.0, 0.0, 0.0, b, 0.0]);
        // tilt b·t about y, position g·b·t³/6 along x; the first samples of 6000 are not tilted yet
        let expected = G * b * 60.0_f64.powi(3) / 6.0;
        assert!((end.position_m[0] / expected - 1.0).abs() < 1e-3, "{end:?}");
        assert!(end.position_m[1] == 0.0 && end.heading_rad == 0.0);
    }

    #[test]
    fn a_constant_accelerometer_residual_is_integrated_twice() {
        let end = after(10.0, [0.0, 2e-3, 0.0, 0.0, 0.0, 0.0]);
        assert!((end.position_m[1] - 0.5 * 2e-3 * 100.0).abs() < 1e-12, "{end:?}");
    }

    #[test]
    fn rotation_about_the_vertical_is_heading_alone() {
        // far beyond small angles
        let end = after(600.0, [0.0, 0.0, 0.0, 0.0, 0.0, 0.005]);
        assert!((end.heading_rad - 3.0).abs() < 1e-5, "{end:?}");
        assert!(end.position_m.iter().all(|position| position.abs() < 1e-6), "{end:?}");
    }
}
