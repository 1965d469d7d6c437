// host-fit 0.1.0
// data mpu6050_static_10min_100hz.csv.gz, sha256 88a509b9ef63cc76514748a4a73b3fab1f61669d21d7bddaf4eaee1917f999aa
// fitted to 32558 of 65067 rows at 99.321 Hz
#[allow(unused_imports)]
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Input, Model, Quantity,
    Range, Source, StillnessLimits, Term, Transform, u, y,
};

static INPUTS: [Input<f32>; 5] = [
    Input { source: Source::Quantity(0), transform: Transform::Identity, centre: 25.30672, scale: 0.07090345, source_range: Range::new(-100.0, 100.0), range: Range::new(-2.325985, 4.3112097) },
    Input { source: Source::Remainder(0), transform: Transform::LowPass { tau_s: 0.1 }, centre: 0.0, scale: 1.0, source_range: Range::new(-4.1660366, 4.1950116), range: Range::new(-0.8267238, 0.8533912) },
    Input { source: Source::Remainder(1), transform: Transform::LowPass { tau_s: 10.0 }, centre: 0.0, scale: 1.0, source_range: Range::new(-3.9594092, 4.254184), range: Range::new(-0.13383132, 0.074818395) },
    Input { source: Source::Remainder(3), transform: Transform::LowPass { tau_s: 1.0 }, centre: 0.0, scale: 1.0, source_range: Range::new(-4.1650877, 4.0746026), range: Range::new(-0.29654977, 0.26915476) },
    Input { source: Source::Remainder(5), transform: Transform::LowPass { tau_s: 0.1 }, centre: 0.0, scale: 1.0, source_range: Range::new(-3.9810238, 3.911494), range: Range::new(-0.7861993, 0.7605048) },
];

static PHYSICAL_0: [Term<f32>; 1] = [
    Term::new(0.0047441702, &[u(0, 0)]),
];

static STOCHASTIC_0: [Term<f32>; 7] = [
    Term::new(0.032704595, &[y(5)]),
    Term::new(-0.055167694, &[y(6)]),
    Term::new(-0.05733296, &[y(4)]),
    Term::new(-0.059678193, &[y(1)]),
    Term::new(0.03325095, &[y(10)]),
    Term::new(-0.03524494, &[y(9)]),
    Term::new(0.17532724, &[u(1, 0)]),
];

static PHYSICAL_1: [Term<f32>; 1] = [
    Term::new(0.034993913, &[u(0, 0)]),
];

static STOCHASTIC_1: [Term<f32>; 1] = [
    Term::new(0.73868495, &[u(2, 0)]),
];

static PHYSICAL_2: [Term<f32>; 1] = [
    Term::new(0.018648168, &[u(0, 0)]),
];

static STOCHASTIC_2: [Term<f32>; 0] = [
];

static PHYSICAL_3: [Term<f32>; 1] = [
    Term::new(0.009874421, &[u(0, 0)]),
];

static STOCHASTIC_3: [Term<f32>; 1] = [
    Term::new(0.38080525, &[u(3, 0)]),
];

static PHYSICAL_4: [Term<f32>; 1] = [
    Term::new(-0.0057004485, &[u(0, 0)]),
];

static STOCHASTIC_4: [Term<f32>; 0] = [
];

static PHYSICAL_5: [Term<f32>; 1] = [
    Term::new(-0.0010433333, &[u(0, 0)]),
];

static STOCHASTIC_5: [Term<f32>; 10] = [
    Term::new(-0.112783745, &[y(8)]),
    Term::new(0.15600517, &[y(3)]),
    Term::new(-0.09435414, &[y(5)]),
    Term::new(0.12510653, &[y(6)]),
    Term::new(-0.064774424, &[y(2)]),
    Term::new(0.08443872, &[y(9)]),
    Term::new(0.08982546, &[y(10)]),
    Term::new(-0.02768722, &[y(1)]),
    Term::new(0.051778447, &[y(7)]),
    Term::new(-0.3725895, &[u(4, 0)]),
];

static AXES: [AxisModel<'static, f32>; 6] = [
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Ax,
            reference: 0.40044138,
            offset: 0.0,
            scale: 0.030616643,
            constant: -0.002364336,
            range: Range::new(-4.1660366, 4.1950116),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 60.0,
            innovation: InnovationStatistics {
                mean: 1.6664359e-5,
                variance: 0.98674405,
                lag_1_correlation: 0.0020726817,
            },
        },
        physical: &PHYSICAL_0,
        stochastic: &STOCHASTIC_0,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Ay,
            reference: 0.6461358,
            offset: 0.0,
            scale: 0.030606825,
            constant: -0.0065605063,
            range: Range::new(-3.9594092, 4.254184),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 60.0,
            innovation: InnovationStatistics {
                mean: 0.00013963736,
                variance: 0.9979416,
                lag_1_correlation: -0.00087684667,
            },
        },
        physical: &PHYSICAL_1,
        stochastic: &STOCHASTIC_1,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Az,
            reference: -10.140514,
            offset: 0.0,
            scale: 0.049157865,
            constant: -0.009784285,
            range: Range::new(-4.0755157, 3.9599183),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 60.0,
            innovation: InnovationStatistics {
                mean: 0.00021589982,
                variance: 0.9996749,
                lag_1_correlation: -0.00271308,
            },
        },
        physical: &PHYSICAL_2,
        stochastic: &STOCHASTIC_2,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gx,
            reference: 0.0,
            offset: 0.07923172,
            scale: 0.002199045,
            constant: -0.0033500951,
            range: Range::new(-4.1650877, 4.0746026),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics {
                mean: 7.180608e-5,
                variance: 0.99873877,
                lag_1_correlation: 0.009628311,
            },
        },
        physical: &PHYSICAL_3,
        stochastic: &STOCHASTIC_3,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gy,
            reference: 0.0,
            offset: 0.0007798958,
            scale: 0.0015953077,
            constant: 0.0029002205,
            range: Range::new(-4.4956903, 3.8633168),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 60.0,
            innovation: InnovationStatistics {
                mean: 2.4682695e-5,
                variance: 0.9999721,
                lag_1_correlation: -0.0017905182,
            },
        },
        physical: &PHYSICAL_4,
        stochastic: &STOCHASTIC_4,
    },
    AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gz,
            reference: 0.0,
            offset: 0.019587714,
            scale: 0.0019750416,
            constant: 0.0006056486,
            range: Range::new(-3.9810238, 3.911494),
            full_scale: 0.0,
            stuck_after: 20,
            gap_limit: 10,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics {
                mean: 8.865913e-6,
                variance: 0.8352951,
                lag_1_correlation: 0.006474962,
            },
        },
        physical: &PHYSICAL_5,
        stochastic: &STOCHASTIC_5,
    },
];

/// The fitted model: inputs, terms and scaling of 6 axes.
pub static MODEL: Model<'static, f32> = Model {
    period_s: 0.01006835450158301,
    fitted_on: FittedOn::Raw,
    stillness: Some(StillnessLimits { window: 50, accel_variance: 0.031325, gyro_variance: 8.469996e-5, gyro_at_rest: [0.079160675, 0.0008340276, 0.019584993], gyro_deviation: 0.013353054 }),
    quantities: &[Quantity::Temperature],
    inputs: &INPUTS,
    axes: &AXES,
};
