//! Mountings of a sensor or board by number: ArduPilot's AHRS_ORIENTATION (`AP_Math/rotations.h`) and PX4's `rotation`
//! (`lib/conversion/rotation.h`). A rotation is yaw after pitch after roll.

/// Rows of a matrix that rotates a vector of the sensor or board into the frame of its mounting.
pub(super) type Matrix = [[f64; 3]; 3];

/// Names of the numbers from 0 that both autopilots share, without decimals: axes and degrees.
const SHARED: &str = "\
    NONE YAW_45 YAW_90 YAW_135 YAW_180 YAW_225 YAW_270 YAW_315 ROLL_180 ROLL_180_YAW_45 ROLL_180_YAW_90 \
    ROLL_180_YAW_135 PITCH_180 ROLL_180_YAW_225 ROLL_180_YAW_270 ROLL_180_YAW_315 ROLL_90 ROLL_90_YAW_45 \
    ROLL_90_YAW_90 ROLL_90_YAW_135 ROLL_270 ROLL_270_YAW_45 ROLL_270_YAW_90 ROLL_270_YAW_135 PITCH_90 \
    PITCH_270 PITCH_180_YAW_90 PITCH_180_YAW_270 ROLL_90_PITCH_90 ROLL_180_PITCH_90 ROLL_270_PITCH_90 \
    ROLL_90_PITCH_180 ROLL_270_PITCH_180 ROLL_90_PITCH_270 ROLL_180_PITCH_270 ROLL_270_PITCH_270 \
    ROLL_90_PITCH_180_YAW_90 ROLL_90_YAW_270 ROLL_90_PITCH_68_YAW_293 PITCH_315 ROLL_90_PITCH_315";

/// Number of the mounting of 68 and 293 degrees by its name; the autopilots differ in the digits that the name omits.
#[cfg(feature = "dataflash")]
const PITCH_68: usize = 38;

/// Names of ArduPilot's numbers from 41.
#[cfg(feature = "dataflash")]
const OF_ARDUPILOT: &str = "PITCH_7 ROLL_45 ROLL_315";

/// Names of PX4's numbers from 41.
#[cfg(feature = "ulog")]
const OF_PX4: &str = "\
    ROLL_270_YAW_180 ROLL_270_YAW_270 PITCH_90_YAW_180 PITCH_9_YAW_180 PITCH_45 ROLL_270_YAW_225 \
    ROLL_270_YAW_315";

/// Mounting of an AHRS_ORIENTATION number; `None` for a number outside the table, such as a custom one.
#[cfg(feature = "dataflash")]
pub(super) fn of_ardupilot(number: f64) -> Option<Matrix> {
    let index = (number >= 0.0 && number.fract() == 0.0).then_some(number as usize)?;
    match index {
        PITCH_68 => Some(of_angles([90.0, 68.8, 293.3])),
        _ => name(OF_ARDUPILOT, index).map(angles).map(of_angles),
    }
}

/// Mounting of a PX4 number; `None` for a number outside the table.
#[cfg(feature = "ulog")]
pub(super) fn of_px4(number: u8) -> Option<Matrix> {
    name(OF_PX4, usize::from(number)).map(angles).map(of_angles)
}

/// Name of a number in the shared list continued by `own`.
fn name(own: &'static str, number: usize) -> Option<&'static str> {
    SHARED.split_ascii_whitespace().chain(own.split_ascii_whitespace()).nth(number)
}

/// Roll, pitch and yaw in a name, degrees.
fn angles(name: &str) -> [f64; 3] {
    ["ROLL", "PITCH", "YAW"].map(|about| {
        let degrees = name.split('_').skip_while(|word| *word != about).nth(1);
        degrees.and_then(|degrees| degrees.parse().ok()).unwrap_or(0.0)
    })
}

/// Matrix of roll, pitch and yaw, degrees: yaw after pitch after roll.
pub(super) fn of_angles(degrees: [f64; 3]) -> Matrix {
    let [(sr, cr), (sp, cp), (sy, cy)] = degrees.map(sine_and_cosine);
    [
        [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
        [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
        [-sp, sr * cp, cr * cp],
    ]
}

#[cfg(feature = "ulog")]
pub(super) fn turned(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| (0..3).map(|axis| row[axis] * vector[axis]).sum())
}

/// Rotates a vector back, by the transpose.
#[cfg(feature = "dataflash")]
pub(super) fn turned_back(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (0..3).map(|row| matrix[row][axis] * vector[row]).sum())
}

/// Sine and cosine, exact at right angles, so that the samples of most boards keep their digits.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    // 0.5 degrees are no right angle
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => degrees.to_radians().sin_cos(),
    }
}

#[cfg(all(test, feature = "dataflash", feature = "ulog"))]
mod tests {
    use super::*;

    /// A vector rotated about one axis after the other, as the autopilots' names are read: about x, then y, then z.
    fn by_steps([roll, pitch, yaw]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let about = |degrees: f64, a: f64, b: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            (cosine * a - sine * b, sine * a + cosine * b)
        };
        let (y, z) = about(roll, y, z);
        let (z, x) = about(pitch, z, x);
        let (x, y) = about(yaw, x, y);
        [x, y, z]
    }

    /// Largest difference between a mounting and the rotation by these angles, over three vectors.
    fn off(matrix: &Matrix, angles: [f64; 3]) -> f64 {
        let vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.5, 0.8]];
        let differences = vectors.into_iter().flat_map(|vector| {
            let (found, expected) = (turned(matrix, vector), by_steps(angles, vector));
            (0..3).map(move |axis| (found[axis] - expected[axis]).abs())
        });
        differences.fold(0.0, f64::max)
    }

    #[test]
    fn mountings_are_the_rotations_in_their_names() {
        for number in 0..44 {
            // the name of this one omits its decimals
            let angles = match number {
                PITCH_68 => [90.0, 68.8, 293.3],
                _ => angles(name(OF_ARDUPILOT, number).unwrap()),
            };
            assert!(off(&of_ardupilot(number as f64).unwrap(), angles) < 1e-14, "{number}");
        }
        for number in 0..48 {
            let angles = angles(name(OF_PX4, number).unwrap());
            assert!(off(&of_px4(number as u8).unwrap(), angles) < 1e-14, "{number}");
        }
        // ArduPilot's own numbers of this one, to the digits of its source
        let written = [
            [0.143_038_972, 0.368_776_487, -0.918_446_381],
            [-0.332_132_778, -0.856_289_421, -0.395_545_503],
            [-0.932_323_801, 0.361_624_570, 0.0],
        ];
        for (found, written) in of_ardupilot(38.0).unwrap().iter().flatten().zip(written.iter().flatten()) {
            assert!((found - written).abs() < 1e-9, "{found} {written}");
        }
        for number in [44.0, 100.0, 101.0, -1.0, 2.5, f64::NAN] {
            assert!(of_ardupilot(number).is_none(), "{number}");
        }
        assert!(of_px4(48).is_none() && of_px4(255).is_none());
    }

    #[test]
    fn numbers_are_those_of_the_autopilots() {
        for (number, angles) in [
            (0, [0.0, 0.0, 0.0]),
            (12, [0.0, 180.0, 0.0]),
            (13, [180.0, 0.0, 225.0]),
            (25, [0.0, 270.0, 0.0]),
            (36, [90.0, 180.0, 90.0]),
            (40, [90.0, 315.0, 0.0]),
        ] {
            assert!(off(&of_ardupilot(f64::from(number)).unwrap(), angles) < 1e-14, "{number}");
            assert!(off(&of_px4(number).unwrap(), angles) < 1e-14, "{number}");
        }
        assert!(off(&of_ardupilot(41.0).unwrap(), [0.0, 7.0, 0.0]) < 1e-14);
        assert!(off(&of_ardupilot(43.0).unwrap(), [315.0, 0.0, 0.0]) < 1e-14);
        assert!(off(&of_px4(38).unwrap(), [90.0, 68.0, 293.0]) < 1e-14);
        assert!(off(&of_px4(44).unwrap(), [0.0, 9.0, 180.0]) < 1e-14);
        assert!(off(&of_px4(47).unwrap(), [270.0, 0.0, 315.0]) < 1e-14);
    }

    #[test]
    fn detects_a_wrong_rotation() {
        // pitch after yaw after roll, another convention, is another rotation where two angles meet
        let swapped = of_angles([90.0, 0.0, 90.0]);
        assert!(off(&swapped, [90.0, 90.0, 0.0]) > 0.1);
        // a transposed matrix turns the other way
        let [x, y, z] = of_angles([0.0, 0.0, 45.0]);
        let transposed = [0, 1, 2].map(|axis| [x[axis], y[axis], z[axis]]);
        assert!(off(&transposed, [0.0, 0.0, 45.0]) > 0.1);
    }

    #[test]
    fn rotations_keep_lengths_and_handedness() {
        let custom = [[0.5, -0.25, 90.5], [-90.0, 450.0, 1e3]].map(of_angles);
        let all = (0..44).map(|number| of_ardupilot(f64::from(number)).unwrap());
        for m in all.chain((0..48).map(|number| of_px4(number).unwrap())).chain(custom) {
            for i in 0..3 {
                for j in 0..3 {
                    let dot: f64 = (0..3).map(|k| m[i][k] * m[j][k]).sum();
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-15, "{m:?}");
                }
            }
            let [a, b, c] = m;
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let determinant: f64 = (0..3).map(|k| cross[k] * c[k]).sum();
            assert!((determinant - 1.0).abs() < 1e-14, "{m:?}");
            let vector = [0.3, -0.5, 0.8];
            let back = turned_back(&m, turned(&m, vector));
            assert!((0..3).all(|axis| (back[axis] - vector[axis]).abs() < 1e-15));
        }
        // half a degree is no right angle
        assert!(off(&of_angles([0.0, 0.0, 90.5]), [0.0, 0.0, 90.0]) > 0.008);
    }
}
