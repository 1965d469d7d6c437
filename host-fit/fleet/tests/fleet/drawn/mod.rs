//! Random rows of units, without logs.

use fos_data::recording::LoadOptions;
use fos_fit::noise::NoiseLevels;
use fos_fleet::{Asked, AxisEstimate, AxisRow, Estimate, UnitRow};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Number of units per lot.
pub(crate) const A_LOT: usize = 200;

const AXES: [&str; 6] = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];

/// Standard deviations of bias (rad/s) and slope ((rad/s)/K): between units, between lots, of an estimate.
const UNITS: [f64; 2] = [4e-3, 2e-4];
const LOTS: [f64; 2] = [2e-3, 0.0];
const ERRORS: [f64; 2] = [2e-4, 1e-4];

pub(crate) fn asked() -> Asked {
    Asked { regressors: vec!["temp_c".to_owned()], diagnosed: false, read: LoadOptions::default() }
}

/// Row of unit number `unit` of a part; deterministic.
pub(crate) fn row(unit: usize) -> UnitRow {
    let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
    let (mut of_lot, mut of_unit) = (
        ChaCha8Rng::seed_from_u64((unit / A_LOT) as u64),
        ChaCha8Rng::seed_from_u64(1_000_000 + unit as u64),
    );
    let axis = |column: &str| {
        let length = 0.5 + 1.5 * of_unit.random::<f64>();
        let errors = ERRORS.map(|error| error * length);
        let mut value = |place: usize| {
            LOTS[place] * normal(&mut of_lot)
                + UNITS[place] * normal(&mut of_unit)
                + errors[place] * normal(&mut of_unit)
        };
        let values = vec![value(0), value(1)];
        let covariance = vec![vec![errors[0].powi(2), 0.0], vec![0.0, errors[1].powi(2)]];
        let noise = NoiseLevels {
            white: 1e-4 * (0.1 * normal(&mut of_unit)).exp(),
            flicker: 1e-5,
            walk: 1e-7,
            gauss_markov: None,
        };
        let names = ["bias", "temp_c"].map(str::to_owned).to_vec();
        let coefficients = Estimate { names, values, covariance };
        AxisRow {
            estimate: AxisEstimate { column: column.to_owned(), coefficients, noise, seconds: 240.0 },
            diagnosis: None,
        }
    };
    UnitRow {
        unit: format!("u{unit:08}"),
        part: "imu".to_owned(),
        lot: Some(format!("lot{}", unit / A_LOT)),
        program: "drawn".to_owned(),
        asked: asked(),
        sha256: format!("{unit:064x}"),
        log: None,
        axes: AXES.map(axis).into(),
        failed: Vec::new(),
    }
}
