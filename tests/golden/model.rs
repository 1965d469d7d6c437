// host-fit, a model for tests
#[allow(unused_imports)]
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Input, Model, Quantity,
    Range, Source, StillnessLimits, Term, Transform, u, y,
};

static INPUTS: [Input<f32>; 11] = [
    Input { source: Source::Quantity(0), transform: Transform::Identity, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::LowPass { tau_s: 61.5 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Rate { tau_s: 10.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Variance { tau_s: 2.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Backlash { half_width: 0.5 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Absolute, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Decay { tau_s: 120.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Time, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Sine { frequency_hz: 16.37 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Cosine { frequency_hz: 16.37 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Remainder(1), transform: Transform::LowPass { tau_s: 1.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
];

static PHYSICAL_0: [Term<f32>; 2] = [
    Term::new(0.3, &[u(0, 0)]),
    Term::new(-0.02, &[u(0, 0), u(1, 0)]),
];

static STOCHASTIC_0: [Term<f32>; 3] = [
    Term::new(0.6, &[y(1)]),
    Term::new(0.33333334, &[y(2)]),
    Term::new(1e-7, &[y(1), y(2), u(2, 1)]),
];

static PHYSICAL_1: [Term<f32>; 2] = [
    Term::new(0.3, &[u(0, 0)]),
    Term::new(-0.02, &[u(0, 0), u(1, 0)]),
];

static STOCHASTIC_1: [Term<f32>; 3] = [
    Term::new(0.6, &[y(1)]),
    Term::new(0.33333334, &[y(2)]),
    Term::new(1e-7, &[y(1), y(2), u(2, 1)]),
];

static AXES: [AxisModel<'static, f32>; 2] = [
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gx,
            reference: 0.0,
            offset: 0.0123,
            scale: 0.0021,
            constant: 0.01,
            range: Range::new(-4.5, 4.25),
            full_scale: 4.36,
            stuck_after: 40,
            gap_limit: 20,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics {
                mean: 0.0,
                variance: 0.8,
                lag_1_correlation: 0.01,
            },
        },
        physical: &PHYSICAL_0,
        stochastic: &STOCHASTIC_0,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gz,
            reference: 0.0,
            offset: 0.0123,
            scale: 0.0021,
            constant: 0.01,
            range: Range::new(-4.5, 4.25),
            full_scale: 4.36,
            stuck_after: 40,
            gap_limit: 20,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics {
                mean: 0.0,
                variance: 0.8,
                lag_1_correlation: 0.01,
            },
        },
        physical: &PHYSICAL_1,
        stochastic: &STOCHASTIC_1,
    },
];

/// The fitted model: inputs, terms and scaling of 2 axes.
pub static MODEL: Model<'static, f32> = Model {
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: Some(StillnessLimits { window: 100, accel_variance: 0.001, gyro_variance: 1e-5, gyro_at_rest: [0.01, -0.02, 0.0], gyro_deviation: 0.02 }),
    quantities: &[Quantity::Temperature],
    inputs: &INPUTS,
    axes: &AXES,
};
