//! Local gravity: the length that every calibrated accelerometer reading has at rest.

use fos_data::unit::STANDARD_GRAVITY_MPS2;
use serde::Serialize;

/// Standard deviation of the free-air anomaly, m/s²: 30 mGal, the global RMS of EGM2008 (Pavlis et al. 2012) over land
/// away from high mountains.
const ANOMALY_MPS2: f64 = 3e-4;

/// Gravity on the ellipsoid lies between these, m/s² (equator, pole).
const RANGE_MPS2: [f64; 2] = [9.7803, 9.8322];

/// Gravity where the log was recorded, and how it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gravity {
    /// m/s².
    pub mps2: f64,
    /// Standard uncertainty, m/s²; part of the interval of every accelerometer sensitivity.
    pub uncertainty_mps2: f64,
    pub source: GravitySource,
}

/// Origin of the value of gravity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "by")]
pub enum GravitySource {
    /// Standard gravity, because no place was stated. The sensitivities scale with it.
    Assumed,
    /// Normal gravity of WGS84 at this place.
    Place { latitude_deg: f64, height_m: f64 },
    /// A value that the caller states.
    Stated,
}

impl Gravity {
    /// Standard gravity, for a log whose place is not known. It is up to 0.27 % from the gravity of a place on Earth, which is
    /// not part of the intervals: see [`Gravity::unknown_share`].
    pub fn assumed() -> Self {
        Self { mps2: STANDARD_GRAVITY_MPS2, uncertainty_mps2: 0.0, source: GravitySource::Assumed }
    }

    /// A stated value, m/s², with its standard uncertainty, m/s².
    pub fn stated(mps2: f64, uncertainty_mps2: f64) -> Self {
        Self { mps2, uncertainty_mps2, source: GravitySource::Stated }
    }

    /// Normal gravity at a geodetic latitude, °, and a height above the ellipsoid, m.
    ///
    /// Somigliana's formula and its second-order continuation in height (NIMA TR8350.2, third edition, equations 4-1 and 4-3).
    /// The height above sea level differs by the geoid, at most 107 m or 0.33 mm/s².
    ///
    /// ```
    /// use fos_calibrate::Gravity;
    /// // TR8350.2, table 3.4: at the equator and at the poles
    /// assert!((Gravity::at(0.0, 0.0).mps2 - 9.7803253359).abs() < 1e-10);
    /// assert!((Gravity::at(90.0, 0.0).mps2 - 9.8321849378).abs() < 1e-9);
    /// ```
    pub fn at(latitude_deg: f64, height_m: f64) -> Self {
        const EQUATOR: f64 = 9.780_325_335_9;
        const K: f64 = 0.001_931_852_652_41;
        const E2: f64 = 0.006_694_379_990_14;
        // semi-major axis, m; flattening; ω²a²b/GM
        const A: f64 = 6_378_137.0;
        const F: f64 = 1.0 / 298.257_223_563;
        const M: f64 = 0.003_449_786_506_84;
        let sin2 = latitude_deg.to_radians().sin().powi(2);
        let on_ellipsoid = EQUATOR * (1.0 + K * sin2) / (1.0 - E2 * sin2).sqrt();
        let h = height_m / A;
        let mps2 = on_ellipsoid * (1.0 - 2.0 * (1.0 + F + M - 2.0 * F * sin2) * h + 3.0 * h * h);
        Self { mps2, uncertainty_mps2: ANOMALY_MPS2, source: GravitySource::Place { latitude_deg, height_m } }
    }

    /// The largest relative error of the value because the place is not known; `None` where it is. All three sensitivities
    /// of an accelerometer are wrong by the same share.
    pub fn unknown_share(&self) -> Option<f64> {
        let furthest = RANGE_MPS2.map(|mps2| (mps2 / self.mps2 - 1.0).abs());
        (self.source == GravitySource::Assumed).then(|| furthest[0].max(furthest[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_gravity_agrees_with_published_values() {
        // normal gravity at 45° (TR8350.2), and the free-air gradient of 3.086 µm/s² per metre
        assert!((Gravity::at(45.0, 0.0).mps2 - 9.806_197_77).abs() < 1e-6);
        let gradient = (Gravity::at(45.0, 1000.0).mps2 - Gravity::at(45.0, 0.0).mps2) / 1000.0;
        assert!((gradient + 3.086e-6).abs() < 3e-9, "{gradient}");
        assert_eq!(Gravity::at(-30.0, 10.0).mps2, Gravity::at(30.0, 10.0).mps2);
    }

    #[test]
    fn only_an_assumed_value_has_an_unknown_share() {
        let share = Gravity::assumed().unknown_share().expect("assumed");
        assert!((0.0025..0.0028).contains(&share), "{share}");
        assert_eq!(Gravity::at(45.4, 12.0).unknown_share(), None);
    }
}
