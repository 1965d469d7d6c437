//! The paper's position error after an hour: a formula of the MSE, not a navigation run.

use fos_data::column::{Column, Triad};

/// Standard gravity as the paper rounds it, m/s², and the hour over which it extrapolates, s.
const PAPER_GRAVITY: f64 = 9.81;
const PAPER_TIME_S: f64 = 3600.0;

/// The paper's position error after an hour: ½·√MSE·t² for an accelerometer (m/s²), g·√MSE·t³/6 for a gyro (rad/s).
/// A formula of the MSE, not a navigation run.
pub(super) fn position_error_m(column: &str, mse: f64) -> Option<f64> {
    let root = mse.sqrt();
    let (triad, _) = Column::named(column).place()?;
    Some(match triad {
        Triad::Accelerometers => 0.5 * root * PAPER_TIME_S.powi(2),
        Triad::Gyros => PAPER_GRAVITY * root * PAPER_TIME_S.powi(3) / 6.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_errors_are_the_papers() {
        // Tables 1 and 2: MSE in (m/s²)² and (deg/h)², position error in m, printed digits
        for (mse, metres) in
            [(5e-9, 458.0), (3e-11, 35.0), (1e-11, 20.0), (2e-12, 9.0), (3e-14, 1.0), (2e-16, 0.09)]
        {
            let computed = position_error_m("ay_mps2", mse).unwrap();
            assert!((computed / metres - 1.0).abs() < 0.13, "{mse}: {computed} for {metres}");
        }
        let degree_per_hour = std::f64::consts::PI / 180.0 / 3600.0;
        for (mse, metres) in [
            (7e-6, 978.0),
            (5e-6, 826.0),
            (1e-6, 369.0),
            (2e-6, 523.0),
            (2e-7, 165.0),
            (4e-10, 7.0),
            (3e-11, 2.0),
        ] {
            let computed = position_error_m("gy_rads", mse * degree_per_hour.powi(2)).unwrap();
            assert!((computed / metres - 1.0).abs() < 0.06, "{mse}: {computed} for {metres}");
        }
    }
}
