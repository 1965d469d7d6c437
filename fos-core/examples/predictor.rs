//! A predictor in a few lines: it tracks the error while the gyro is still and predicts it during a rotation.
//!
//! ```text
//! cargo run -p fos-core --example predictor
//! ```

use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, ModelError, Predictor, Range,
    Sample, Term, y,
};

/// A slowly varying error around an offset of 0.01 rad/s: r(n) = 0.98 r(n − 1) + noise.
static GYRO_Z: AxisModel<'_, f32> = AxisModel {
    parameters: AxisParameters {
        axis: Axis::Gz,
        reference: 0.0,
        offset: 0.01,
        scale: 0.002,
        constant: 0.0,
        range: Range::new(-4.0, 4.0),
        physical_range: Range::new(0.0, 0.0),
        full_scale: 8.7,
        stuck_after_repeats: 0,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.04, lag_1_correlation: 0.0 },
    },
    physical: &[],
    stochastic: &[Term::new(0.98, &[y(1)])],
};

static MODEL: Model<'_, f32> = Model {
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: None,
    calibration: None,
    quantities: &[],
    inputs: &[],
    axes: &[GYRO_Z],
};

fn main() -> Result<(), ModelError> {
    // 1 axis, no input, 1 term, 2 values of history
    let mut predictor = Predictor::<f32, 1, 0, 1, 2>::new(&MODEL)?;
    let error = 0.015;
    for _ in 0..100 {
        // at rest the true rate is 0, so the error is measured
        let still = predictor.track(&Sample { measured: &[error], quantities: &[] });
        assert!(still[0].corrected.abs() < error.abs());
    }
    for rate in [0.1, 0.2, 0.3] {
        // in motion the true rate is unknown: the model runs on its own output
        let moving = predictor.coast(&Sample { measured: &[rate + error], quantities: &[] });
        println!(
            "measured {:.4} rad/s, corrected {:.4}: {:?}",
            rate + error,
            moving[0].corrected,
            moving[0].validity
        );
        assert!((moving[0].corrected - rate).abs() < 0.0005);
    }
    Ok(())
}
