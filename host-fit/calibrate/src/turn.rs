//! Integration of a turn: the direction of gravity in the frame of the device, from one rest to the next.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// Derivatives of a direction by the nine entries of the gyro matrix, row by row.
pub(crate) type ByMatrix = nalgebra::SMatrix<f64, 3, 9>;

/// Values of the gyro between two rests, without its bias, in the unit of the log.
#[derive(Debug, Clone)]
pub(crate) struct Rates {
    pub(crate) values: Vec<Vector3<f64>>,
    pub(crate) period_s: f64,
}

impl Rates {
    /// The direction `up` after the turn, for ω = G·rate.
    pub(crate) fn turned(&self, matrix: &Matrix3<f64>, up: Vector3<f64>) -> Vector3<f64> {
        self.values.windows(2).fold(up, |up, pair| rotation(-self.step(matrix, pair)) * up)
    }

    /// The same and its derivatives by the entries of G.
    ///
    /// A direction fixed in space obeys u̇ = −ω × u in the frame of the device, so a step with the rotation vector φ takes u to
    /// Exp(−φ)u. For rates that are linear between samples φ = dt(ω₀ + ω₁)/2 + dt²(ω₀ × ω₁)/12 (Bortz 1971, equation 22, to
    /// second order). The derivative of Exp(−φ)u is [Exp(−φ)u]ₓ J_l(−φ) (Solà 2017, equations 143 and 145).
    pub(crate) fn turned_with_derivatives(
        &self,
        matrix: &Matrix3<f64>,
        up: Vector3<f64>,
    ) -> (Vector3<f64>, ByMatrix) {
        let (mut u, mut by_matrix) = (up, ByMatrix::zeros());
        for pair in self.values.windows(2) {
            let step = self.step(matrix, pair);
            let turn = rotation(-step);
            u = turn * u;
            let lever = u.cross_matrix() * left_jacobian(-step);
            by_matrix = turn * by_matrix + lever * self.step_by_matrix(matrix, pair);
        }
        (u, by_matrix)
    }

    /// The rotation vector of one step, rad.
    fn step(&self, matrix: &Matrix3<f64>, pair: &[Vector3<f64>]) -> Vector3<f64> {
        let (first, second) = (matrix * pair[0], matrix * pair[1]);
        (first + second) * (0.5 * self.period_s) + first.cross(&second) * (self.period_s.powi(2) / 12.0)
    }

    fn step_by_matrix(&self, matrix: &Matrix3<f64>, pair: &[Vector3<f64>]) -> ByMatrix {
        let (first, second) = (matrix * pair[0], matrix * pair[1]);
        let mean = (pair[0] + pair[1]) * (0.5 * self.period_s);
        let cone = self.period_s.powi(2) / 12.0;
        let mut derivatives = ByMatrix::zeros();
        for row in 0..3 {
            let axis = Vector3::ith(row, 1.0);
            for column in 0..3 {
                let by_cone =
                    (axis * pair[0][column]).cross(&second) + first.cross(&(axis * pair[1][column]));
                derivatives.set_column(3 * row + column, &(axis * mean[column] + by_cone * cone));
            }
        }
        derivatives
    }

    /// The angle that was turned through in all, in the unit of the log times seconds.
    pub(crate) fn angle(&self) -> f64 {
        self.values.iter().map(|rate| rate.norm()).sum::<f64>() * self.period_s
    }

    /// Duration, s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.values.len().saturating_sub(1) as f64 * self.period_s
    }
}

/// One turn, ready to be integrated.
pub(crate) struct Prepared {
    pub(crate) rates: Rates,
    /// Directions of gravity at the rests before and after.
    pub(crate) up: [Vector3<f64>; 2],
    /// Variance of one component of the direction after the turn, rad², by noise; times the scale of the log for the gyro.
    pub(crate) direction: f64,
    /// Variance of the integrated noise, in the unit of the log.
    pub(crate) integrated: f64,
    /// Index among the turns.
    pub(crate) turn: usize,
}

/// The angle by which each turn ends off, rad.
pub(crate) fn angles(prepared: &[Prepared], matrix: &Matrix3<f64>) -> Vec<f64> {
    let off = |turn: &Prepared| {
        2.0 * (0.5 * (turn.rates.turned(matrix, turn.up[0]) - turn.up[1]).norm()).min(1.0).asin()
    };
    prepared.iter().map(off).collect()
}

/// Exp of a rotation vector (Rodrigues' formula).
pub(crate) fn rotation(vector: Vector3<f64>) -> Matrix3<f64> {
    let square = vector.norm_squared();
    let (a, b) = if square < 1e-8 {
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        let angle = square.sqrt();
        (angle.sin() / angle, (1.0 - angle.cos()) / square)
    };
    let cross = vector.cross_matrix();
    Matrix3::identity() + cross * a + cross * cross * b
}

/// The left Jacobian of the rotation group: Exp(v + δ) = Exp(J_l(v)δ) Exp(v) to first order.
fn left_jacobian(vector: Vector3<f64>) -> Matrix3<f64> {
    let square = vector.norm_squared();
    let (a, b) = if square < 1e-8 {
        (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
    } else {
        let angle = square.sqrt();
        ((1.0 - angle.cos()) / square, (angle - angle.sin()) / (square * angle))
    };
    let cross = vector.cross_matrix();
    Matrix3::identity() + cross * a + cross * cross * b
}

/// Two unit vectors at right angles to `up` and to each other, as rows.
pub(crate) fn tangents(up: &Vector3<f64>) -> DMatrix<f64> {
    let axis = Vector3::ith(up.iamin(), 1.0);
    let first = up.cross(&axis).normalize();
    let second = up.cross(&first);
    DMatrix::from_fn(2, 3, |row, column| if row == 0 { first[column] } else { second[column] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates() -> Rates {
        let at = |n: usize| {
            let t = n as f64 * 0.01;
            Vector3::new(1.5 * (2.0 * t).sin(), -0.8 * (3.0 * t).cos(), 2.0 * (1.3 * t).sin().powi(2))
        };
        Rates { values: (0..300).map(at).collect(), period_s: 0.01 }
    }

    fn matrix() -> Matrix3<f64> {
        Matrix3::new(1.02, 0.01, -0.02, 0.005, 0.98, 0.01, 0.0, -0.03, 1.01)
    }

    #[test]
    fn derivatives_of_a_turn_are_exact() {
        let up = Vector3::new(0.3, -0.5, 0.8).normalize();
        let (turned, derivatives) = rates().turned_with_derivatives(&matrix(), up);
        assert!((turned - rates().turned(&matrix(), up)).norm() < 1e-14);
        for entry in 0..9 {
            let moved = |by: f64| {
                let mut moved = matrix();
                moved[(entry / 3, entry % 3)] += by;
                rates().turned(&moved, up)
            };
            let numerical = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((numerical - derivatives.column(entry)).norm() < 1e-7, "{entry}");
        }
    }

    /// The brute-force twin: Runge–Kutta of fourth order with steps of a hundredth, as imu_tk integrates.
    #[test]
    fn turns_agree_with_runge_kutta() {
        let (rates, matrix) = (rates(), matrix());
        let up = Vector3::new(0.3, -0.5, 0.8).normalize();
        let mut u = up;
        for pair in rates.values.windows(2) {
            let dt = rates.period_s / 100.0;
            let slope = |u: Vector3<f64>, share: f64| {
                -(matrix * (pair[0] * (1.0 - share) + pair[1] * share)).cross(&u)
            };
            for part in 0..100 {
                let s = part as f64 / 100.0;
                let k1 = slope(u, s);
                let k2 = slope(u + k1 * (0.5 * dt), s + 0.005);
                let k3 = slope(u + k2 * (0.5 * dt), s + 0.005);
                let k4 = slope(u + k3 * dt, s + 0.01);
                u += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (dt / 6.0);
            }
        }
        // third order in a step of 0.02 rad, over 300 steps
        assert!((u - rates.turned(&matrix, up)).norm() < 1e-6, "{}", (u - rates.turned(&matrix, up)).norm());
    }

    #[test]
    fn tangents_are_at_right_angles() {
        for up in [Vector3::z(), -Vector3::x(), Vector3::new(0.6, 0.0, 0.8)] {
            let rows = tangents(&up);
            let product = &rows * rows.transpose();
            assert!((product - DMatrix::identity(2, 2)).norm() < 1e-12);
            assert!((rows * DMatrix::from_column_slice(3, 1, up.as_slice())).norm() < 1e-12);
        }
    }
}
