//! How a board may be mounted: the numbers of ArduPilot's AHRS_ORIENTATION (`AP_Math/rotations.h`).

/// Roll, pitch and yaw by number, degrees.
const ANGLES: [[f64; 3]; 44] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 45.0],
    [0.0, 0.0, 90.0],
    [0.0, 0.0, 135.0],
    [0.0, 0.0, 180.0],
    [0.0, 0.0, 225.0],
    [0.0, 0.0, 270.0],
    [0.0, 0.0, 315.0],
    [180.0, 0.0, 0.0],
    [180.0, 0.0, 45.0],
    [180.0, 0.0, 90.0],
    [180.0, 0.0, 135.0],
    [0.0, 180.0, 0.0],
    [180.0, 0.0, 225.0],
    [180.0, 0.0, 270.0],
    [180.0, 0.0, 315.0],
    [90.0, 0.0, 0.0],
    [90.0, 0.0, 45.0],
    [90.0, 0.0, 90.0],
    [90.0, 0.0, 135.0],
    [270.0, 0.0, 0.0],
    [270.0, 0.0, 45.0],
    [270.0, 0.0, 90.0],
    [270.0, 0.0, 135.0],
    [0.0, 90.0, 0.0],
    [0.0, 270.0, 0.0],
    [0.0, 180.0, 90.0],
    [0.0, 180.0, 270.0],
    [90.0, 90.0, 0.0],
    [180.0, 90.0, 0.0],
    [270.0, 90.0, 0.0],
    [90.0, 180.0, 0.0],
    [270.0, 180.0, 0.0],
    [90.0, 270.0, 0.0],
    [180.0, 270.0, 0.0],
    [270.0, 270.0, 0.0],
    [90.0, 180.0, 90.0],
    [90.0, 0.0, 270.0],
    [90.0, 68.8, 293.3],
    [0.0, 315.0, 0.0],
    [90.0, 315.0, 0.0],
    [0.0, 7.0, 0.0],
    [45.0, 0.0, 0.0],
    [315.0, 0.0, 0.0],
];

/// The matrix that turns what the board measures into the vehicle's frame, row by row; none of a number that is not in
/// the table.
pub(super) fn matrix(number: f64) -> Option<[[f64; 3]; 3]> {
    let index = (number >= 0.0 && number.fract() == 0.0).then_some(number as usize)?;
    let [roll, pitch, yaw] = ANGLES.get(index)?.map(sine_and_cosine);
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll, pitch, yaw);
    // yaw after pitch after roll
    Some([
        [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
        [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
        [-sp, sr * cp, cr * cp],
    ])
}

/// Exact at right angles, so that most boards' samples keep their digits.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    match degrees as i64 {
        0 => (0.0, 1.0),
        90 => (1.0, 0.0),
        180 => (0.0, -1.0),
        270 => (-1.0, 0.0),
        _ => degrees.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_turns_and_does_nothing_else() {
        for number in 0..ANGLES.len() {
            let m = matrix(number as f64).unwrap();
            for i in 0..3 {
                for j in 0..3 {
                    let dot: f64 = (0..3).map(|k| m[i][k] * m[j][k]).sum();
                    let identity = f64::from(u8::from(i == j));
                    assert!((dot - identity).abs() < 1e-15, "{number}: {i} {j}");
                }
            }
        }
        // a board turned right by 90 degrees: its x looks to the vehicle's y
        assert_eq!(matrix(2.0).unwrap().map(|row| row[0]), [0.0, 1.0, 0.0]);
        // upside down
        assert_eq!(matrix(8.0).unwrap().map(|row| row[2]), [0.0, 0.0, -1.0]);
        assert!(matrix(100.0).is_none() && matrix(-1.0).is_none() && matrix(f64::NAN).is_none());
    }
}
