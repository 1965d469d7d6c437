//! Codes that a part plays.

/// Codes of one tick: axes x, y, z at ±4 g and ±500 °/s, and the thermometer in the scale of the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// Accelerometers.
    pub accel: [i16; 3],
    /// Gyros.
    pub gyro: [i16; 3],
    /// Thermometer.
    pub temperature: i16,
}

/// Source of the codes. At another range they are scaled, and clipped at full scale.
#[derive(Debug, Clone)]
pub enum Codes {
    /// Codes of [`generated`], at a constant temperature one or two degrees from the zero of its scale.
    Generated,
    /// A log, repeated from its beginning when it ends; must not be empty.
    Log(Vec<Sample>),
}

/// Means of the [`generated`] codes: accelerometers x, y, z, gyros x, y, z.
pub const BIAS: [f64; 6] = [60.0, -40.0, 8192.0, 25.0, -35.0, 10.0];

/// Accelerometer and gyro codes at tick `n`, independent of all other ticks: [`BIAS`] and noise of 8 codes.
pub fn generated(n: u64) -> ([i16; 3], [i16; 3]) {
    let code = |axis: u64| {
        let mut noise = 0.0;
        for draw in 0..12 {
            let mut hash = (n * 6 + axis) * 12 + draw + 1;
            for _ in 0..2 {
                hash = (hash ^ (hash >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            }
            noise += (hash >> 40) as f64 / 16_777_216.0 - 0.5;
        }
        (BIAS[axis as usize] + 8.0 * noise).round() as i16
    };
    ([code(0), code(1), code(2)], [code(3), code(4), code(5)])
}

impl Codes {
    /// Codes at tick `n`; `temperature` is that of the generated ones.
    pub(crate) fn at(&self, n: u64, temperature: i16) -> Sample {
        match self {
            Self::Generated => {
                let (accel, gyro) = generated(n);
                Sample { accel, gyro, temperature }
            }
            Self::Log(rows) => rows[(n % rows.len() as u64) as usize],
        }
    }
}

/// Converts codes from the range of the source to another one, `ratio` times as sensitive.
pub(crate) fn at_range(codes: [i16; 3], ratio: f64) -> [i16; 3] {
    // the conversion to an integer saturates, as the converter of the part
    codes.map(|code| (f64::from(code) * ratio).round() as i16)
}
