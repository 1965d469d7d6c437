// host-fit, a model for tests
#[allow(unused_imports)]
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Input, Model, Quantity,
    Range, Source, StillnessLimits, Term, Transform, u, y,
};

static INPUTS: [Input<f32>; 13] = [
    Input { source: Source::Quantity(0), transform: Transform::Identity, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::LowPass { tau_s: 61.5 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Rate { tau_s: 10.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Variance { tau_s: 2.0 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Backlash { half_width: 0.5 }, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(0), transform: Transform::Absolute, centre: 25.0, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Decay { tau_s: 120.0 }, centre: 1.5, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Time, centre: 1.5, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Sine { frequency_hz: 16.37 }, centre: 1.5, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Clock, transform: Transform::Cosine { frequency_hz: 16.37 }, centre: 1.5, scale: 2.5, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Remainder(1), transform: Transform::LowPass { tau_s: 1.0 }, centre: 0.0, scale: 2.0, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(1), transform: Transform::Identity, centre: 3.3, scale: 0.05, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
    Input { source: Source::Quantity(2), transform: Transform::Identity, centre: 9.85, scale: 0.05, source_range: Range::new(-3.0, 3.0), range: Range::new(-3.0, 3.0) },
];

static PHYSICAL_0: [Term<f32>; 12] = [
    Term::new(0.3, &[u(0, 0)]),
    Term::new(-0.02, &[u(0, 0), u(1, 0)]),
    Term::new(0.1, &[u(2, 0)]),
    Term::new(0.1, &[u(3, 0)]),
    Term::new(0.1, &[u(4, 0)]),
    Term::new(0.1, &[u(5, 0)]),
    Term::new(0.1, &[u(6, 0)]),
    Term::new(0.1, &[u(7, 0)]),
    Term::new(0.1, &[u(8, 0)]),
    Term::new(0.1, &[u(9, 0)]),
    Term::new(0.1, &[u(11, 0)]),
    Term::new(0.1, &[u(12, 0)]),
];

static STOCHASTIC_0: [Term<f32>; 4] = [
    Term::new(0.6, &[y(1)]),
    Term::new(0.33333334, &[y(2)]),
    Term::new(1e-7, &[y(1), y(2), u(2, 1)]),
    Term::new(0.05, &[u(10, 0)]),
];

static PHYSICAL_1: [Term<f32>; 1] = [
    Term::new(0.3, &[u(0, 0)]),
];

static STOCHASTIC_1: [Term<f32>; 2] = [
    Term::new(0.6, &[y(1)]),
    Term::new(-0.2, &[y(2)]),
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
            physical_range: Range::new(-8.0, 7.5),
            full_scale: 4.36,
            stuck_after_repeats: 40,
            gap_limit_samples: 20,
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
            axis: Axis::Az,
            reference: 9.8,
            offset: 0.05,
            scale: 0.021,
            constant: 0.01,
            range: Range::new(-4.5, 4.25),
            physical_range: Range::new(-8.0, 7.5),
            full_scale: 39.2,
            stuck_after_repeats: 40,
            gap_limit_samples: 20,
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
    calibration: None,
    quantities: &[Quantity::Temperature, Quantity::Supply, Quantity::Measured(Axis::Az)],
    inputs: &INPUTS,
    axes: &AXES,
};

// From here on fos-embedded is needed; leave it out where only fos-core is used.

use fos_embedded::hub::{Hub, Motion::{Moving, Still}};
use fos_embedded::raw::Scales;
use fos_embedded::test_vector::{CheckError, Expected, TestSample, TestVector};

/// The smallest hub that takes the model: inputs, terms, values of history.
pub type ModelHub = Hub<13, 19, 64>;

/// Runs the test vector through a hub of its own, on the stack: at start-up, before the model
/// is trusted.
///
/// # Errors
///
/// Index of the first sample of which one bit deviates; or why the hub does not take the model.
pub fn check() -> Result<(), CheckError> {
    let mut hub = ModelHub::new(TEST_VECTOR.scales);
    hub.load_model(&MODEL)?;
    TEST_VECTOR.run(&mut hub).map_err(CheckError::Deviates)
}

#[cfg(test)]
#[test]
fn the_model_comes_to_the_bits_of_its_test_vector() {
    assert_eq!(check(), Ok(()));
}

/// Test vector: 66 samples, and the bits that a hub made of them on the host, in f32.
/// From power-on, at rest: until the history is full and 30 samples more; then one with everything below its fitted range and one
/// with everything above; each quantity absent once; all codes saturated once; each axis at its full scale once, where codes reach it;
/// 8 samples in motion; 3 missing; then more missing than any axis coasts over, and the history refilled.
/// The remainder of an axis is drawn evenly from its fitted range, a quantity wanders through its own in steps of 0.03 % to 30 %.
/// Random numbers: x = 1664525 x + 1013904223 modulo 2^32 from x = 1, the upper 24 bits.
/// Not shown: detection of stillness, stuck axes, coasting beyond its limit, the watch over the innovations.
/// A change of the last bit of a coefficient is noticed in 15 of 19 terms;
/// in gx_rads, term 4 (physical part first) from 1e-7 of it;
/// in gx_rads, term 5 (physical part first) from 3e-7 of it;
/// in gx_rads, term 15 (physical part first) from 4e-2 of it;
/// in gx_rads, term 16 (physical part first) from 5e-6 of it.
pub static TEST_VECTOR: TestVector<'static> = TestVector {
    scales: Scales {
        accel_mps2: 0.0013,
        gyro_rads: 0.00014,
        temperature_k: 0.0053,
        temperature_zero_c: 25.0,
        period_s: 0.005,
        values: FittedOn::Raw,
    },
    channels: &[3, 2],
    given: &[1],
    samples: &SAMPLES,
    given_bits: &GIVEN,
    expected: &EXPECTED,
};

static SAMPLES: [TestSample; 66] = [
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7574, 115, 0, 0], temperature: Some(-849) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7643, 51, 0, 0], temperature: Some(0) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7549, 32, 0, 0], temperature: Some(-1) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7538, 157, 0, 0], temperature: Some(848) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7614, 150, 0, 0], temperature: Some(933) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7538, 96, 0, 0], temperature: Some(934) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7518, 140, 0, 0], temperature: Some(942) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7599, 48, 0, 0], temperature: Some(858) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7568, 91, 0, 0], temperature: Some(858) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7619, 150, 0, 0], temperature: Some(867) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7561, 157, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7516, 80, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7563, 35, 0, 0], temperature: Some(883) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7600, 104, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7577, 120, 0, 0], temperature: Some(883) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7516, 109, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7617, 161, 0, 0], temperature: Some(866) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7596, 138, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7649, 43, 0, 0], temperature: Some(866) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7519, 56, 0, 0], temperature: Some(17) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7516, 116, 0, 0], temperature: Some(25) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7554, 114, 0, 0], temperature: Some(26) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7625, 66, 0, 0], temperature: Some(111) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7608, 74, 0, 0], temperature: Some(960) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7559, 113, 0, 0], temperature: Some(959) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7584, 111, 0, 0], temperature: Some(875) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7580, 96, 0, 0], temperature: Some(790) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7653, 52, 0, 0], temperature: Some(798) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7619, 151, 0, 0], temperature: Some(713) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7576, 69, 0, 0], temperature: Some(-136) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7582, 93, 0, 0], temperature: Some(-985) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7530, 82, 0, 0], temperature: Some(-984) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7331, -257, 0, 0], temperature: Some(-2264) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7610, 64, 0, 0], temperature: Some(-136) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7864, 406, 0, 0], temperature: Some(2264) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7575, 131, 0, 0], temperature: Some(-145) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7571, 137, 0, 0], temperature: None },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7573, 56, 0, 0], temperature: Some(-61) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7567, 106, 0, 0], temperature: Some(-70) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7606, 117, 0, 0], temperature: Some(-69) },
    TestSample { motion: Still, skipped: 0, codes: [32767, 32767, 32767, 32767, 32767, 32767], temperature: Some(-154) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7625, 53, 0, 0], temperature: Some(-155) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 30154, 31143, 0, 0], temperature: Some(-154) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7607, 72, 0, 0], temperature: Some(-69) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 4969, 1018, 0, 0], temperature: Some(-77) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 6604, 4056, 0, 0], temperature: Some(772) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 4128, 1633, 0, 0], temperature: Some(687) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 7677, 1152, 0, 0], temperature: Some(602) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 11061, 734, 0, 0], temperature: Some(593) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 8424, -572, 0, 0], temperature: Some(-256) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 10653, -1690, 0, 0], temperature: Some(-247) },
    TestSample { motion: Moving, skipped: 0, codes: [0, 0, 8967, 2798, 0, 0], temperature: Some(-246) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7524, 134, 0, 0], temperature: Some(-331) },
    TestSample { motion: Still, skipped: 3, codes: [0, 0, 7551, 119, 0, 0], temperature: Some(-323) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7546, 133, 0, 0], temperature: Some(-323) },
    TestSample { motion: Still, skipped: 1020, codes: [0, 0, 7628, 121, 0, 0], temperature: Some(-315) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7501, 68, 0, 0], temperature: Some(-1164) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7608, 75, 0, 0], temperature: Some(-1173) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7593, 124, 0, 0], temperature: Some(-1164) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7617, 69, 0, 0], temperature: Some(-1156) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7582, 64, 0, 0], temperature: Some(-1155) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7586, 103, 0, 0], temperature: Some(-1154) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7599, 122, 0, 0], temperature: Some(-1155) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7507, 139, 0, 0], temperature: Some(-1070) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7516, 67, 0, 0], temperature: Some(-1061) },
    TestSample { motion: Still, skipped: 0, codes: [0, 0, 7503, 50, 0, 0], temperature: Some(-1146) },
];

static GIVEN: [u32; 66] = [
    0x405341f2,
    0x4052ae7d,
    0x4052bd3c,
    0x4052ae7d,
    0x405341f2,
    0x404d7f63,
    0x404cebee,
    0x404c5879,
    0x40521b09,
    0x40520c4a,
    0x4051fd8b,
    0x4051ff04,
    0x40516b90,
    0x4050d81b,
    0x405044a6,
    0x40504620,
    0x404fb2ab,
    0x40504620,
    0x405608af,
    0x4055753a,
    0x4055667b,
    0x405557bc,
    0x40555936,
    0x404f96a7,
    0x404f952d,
    0x4049d29e,
    0x4049d124,
    0x404a6499,
    0x4049d124,
    0x4049dfe3,
    0x4049eea2,
    0x4049f01c,
    0x4043d70a,
    0x404a8217,
    0x40628f5c,
    0x404ba900,
    0x404b9a41,
    0x40515cd1,
    0x7fc00000,
    0x4050ba9d,
    0x4050abde,
    0x4050186a,
    0x40502728,
    0x4055e9b8,
    0x40567d2c,
    0x40566e6e,
    0x40565faf,
    0x40566e6e,
    0x40566fe7,
    0x40566128,
    0x405c23b8,
    0x40566128,
    0x40566fe7,
    0x405c3276,
    0x405cc5eb,
    0x405cc765,
    0x405704d5,
    0x4057064f,
    0x405704d5,
    0x405cc765,
    0x405704d5,
    0x4057064f,
    0x405143bf,
    0x40514246,
    0x404b7fb7,
    0x404c132b,
];

const fn bits(corrected: u32, innovation: u32, validity: u16) -> Expected {
    Expected { corrected, innovation, validity }
}

static EXPECTED: [Expected; 132] = [
    bits(0x3b908364, 0x7fc00000, 0x001), bits(0x411cebae, 0x7fc00000, 0x001),
    bits(0xbbbfd964, 0x7fc00000, 0x001), bits(0x411e2ca5, 0x7fc00000, 0x001),
    bits(0xbbc437ed, 0xbbc437ed, 0x000), bits(0x411c382b, 0x7fc00000, 0x001),
    bits(0x3c705fca, 0x3c705fca, 0x000), bits(0x411c6dd7, 0xbcbdeb7c, 0x000),
    bits(0x3b8e4948, 0x3b8e4949, 0x000), bits(0x411dd8ca, 0x3d85fe72, 0x000),
    bits(0xbbdbe27c, 0xbbdbe27d, 0x000), bits(0x411b3f07, 0xbdc6e30a, 0x000),
    bits(0x3b88e380, 0x3b88e380, 0x000), bits(0x411c16f1, 0xbd35db98, 0x000),
    bits(0xbc2cb985, 0xbc2cb986, 0x000), bits(0x411dba0f, 0x3d6d423a, 0x000),
    bits(0x3a807e48, 0x3a807e48, 0x000), bits(0x411bfa0f, 0xbd52bda0, 0x000),
    bits(0x3c1fc1f2, 0x3c1fc1f3, 0x000), bits(0x411dc35b, 0x3d768e6a, 0x000),
    bits(0x3b8a9a28, 0x3b8a9a27, 0x000), bits(0x411bca6c, 0xbd81309a, 0x000),
    bits(0xbc2063e1, 0xbc2063e1, 0x000), bits(0x411bca96, 0xbd811b96, 0x000),
    bits(0xbc2af87d, 0xbc2af87c, 0x000), bits(0x411d1654, 0x3c930def, 0x000),
    bits(0x3bd67f0e, 0x3bd67f0d, 0x000), bits(0x411d15f7, 0x3c92540f, 0x000),
    bits(0x3bb3e312, 0x3bb3e311, 0x000), bits(0x411c568c, 0xbcec8278, 0x000),
    bits(0xb95d1540, 0xb95d1526, 0x000), bits(0x411b8369, 0xbda4b22f, 0x000),
    bits(0x3bd7a340, 0x3bd7a341, 0x000), bits(0x411e47c0, 0x3dbd7952, 0x000),
    bits(0xb9451280, 0xb9451266, 0x000), bits(0x411c5395, 0xbcf26fa7, 0x000),
    bits(0xbc6d7ee2, 0xbc6d7ee2, 0x000), bits(0x411e1d56, 0x3da844a3, 0x000),
    bits(0xba6c9d60, 0xba6c9d5b, 0x000), bits(0x411ad779, 0xbdfaa9f6, 0x000),
    bits(0x3c1c9e42, 0x3c1c9e42, 0x000), bits(0x411c8311, 0xbc9377f1, 0x000),
    bits(0x3b25e2e4, 0x3b25e2e3, 0x000), bits(0x411cd60c, 0x3b13f736, 0x000),
    bits(0xbbef98ea, 0xbbef98e8, 0x000), bits(0x411dcece, 0x3d810086, 0x000),
    bits(0xbb3ff02c, 0xbb3ff02d, 0x000), bits(0x411c8e3f, 0xbc7a37f1, 0x000),
    bits(0x3bab3582, 0x3bab3581, 0x000), bits(0x411c2640, 0xbd268cd1, 0x000),
    bits(0x3afccd70, 0x3afccd6b, 0x000), bits(0x411d3117, 0x3cc89388, 0x000),
    bits(0xbafa08e0, 0xbafa08dc, 0x000), bits(0x411c99a3, 0xbc4ca842, 0x000),
    bits(0xbbee9a45, 0xbbee9a44, 0x000), bits(0x411e4372, 0x3dbb5244, 0x000),
    bits(0x3c3f24f8, 0x3c3f24f8, 0x000), bits(0x411ca6c2, 0xbc182d6f, 0x000),
    bits(0xbb8c87d6, 0xbb8c87d5, 0x000), bits(0x411ca7b9, 0xbc144efe, 0x000),
    bits(0x3a8a11c8, 0x3a8a11ca, 0x000), bits(0x411d405b, 0x3ce71b1e, 0x000),
    bits(0x39e9aa80, 0x39e9aa7f, 0x000), bits(0x411bd7de, 0xbd74ef12, 0x000),
    bits(0xbd3ee07c, 0xbd3ee07d, 0x018), bits(0x41188968, 0xbe886ca9, 0x018),
    bits(0x3c03a5fc, 0x3c03a5fc, 0x010), bits(0x411f2656, 0x3e166243, 0x000),
    bits(0x3d43ee8f, 0x3d43ee8f, 0x018), bits(0x41216898, 0x3e937957, 0x018),
    bits(0xbb6a67c8, 0xbb6a67cb, 0x010), bits(0x411b3136, 0xbdcdcb5f, 0x000),
    bits(0xbb36a398, 0xbb36a395, 0x040), bits(0x411d4a19, 0x3cfa980b, 0x040),
    bits(0xbc379a6e, 0xbc379a6f, 0x000), bits(0x411cc817, 0xba96c22b, 0x000),
    bits(0x3b2fa9f0, 0x3b2fa9ef, 0x040), bits(0x411ca0be, 0xbc303cbb, 0x000),
    bits(0x3b7c2218, 0x3b7c2218, 0x000), bits(0x411d8471, 0x3d37a381, 0x000),
    bits(0x40924823, 0x7fc00000, 0x092), bits(0x422a17e1, 0x7fc00000, 0x082),
    bits(0xbc04b372, 0xbc04b371, 0x002), bits(0x411db4a6, 0x7fc00000, 0x002),
    bits(0x408b2d37, 0x7fc00000, 0x092), bits(0x421c9c17, 0x7fc00000, 0x082),
    bits(0x39d10580, 0x39d10583, 0x002), bits(0x411d76d4, 0x7fc00000, 0x002),
    bits(0x3e082c14, 0x7fc00000, 0x012), bits(0x40cd2a00, 0x7fc00000, 0x002),
    bits(0x3f0e8169, 0x7fc00000, 0x012), bits(0x41086576, 0x7fc00000, 0x002),
    bits(0x3e5e8dc5, 0x7fc00000, 0x012), bits(0x40a9d16b, 0x7fc00000, 0x002),
    bits(0x3e1834b8, 0x7fc00000, 0x002), bits(0x411ebefb, 0x7fc00000, 0x002),
    bits(0x3db7be86, 0x7fc00000, 0x012), bits(0x416522c9, 0x7fc00000, 0x002),
    bits(0xbdbc3238, 0x7fc00000, 0x012), bits(0x412e77dd, 0x7fc00000, 0x002),
    bits(0xbe7ef02f, 0x7fc00000, 0x012), bits(0x415cd464, 0x7fc00000, 0x002),
    bits(0x3ec26142, 0x7fc00000, 0x012), bits(0x4139c2b8, 0x7fc00000, 0x002),
    bits(0x3bfdd8e0, 0x3bfdd8e0, 0x002), bits(0x411bc3ad, 0x7fc00000, 0x002),
    bits(0x3a26a700, 0x3a26a6ed, 0x002), bits(0x411c5301, 0xbcf3989b, 0x002),
    bits(0x3b1dac98, 0x3b1dac9a, 0x002), bits(0x411c8175, 0xbc96b024, 0x002),
    bits(0x3b53c190, 0x7fc00000, 0x001), bits(0x411dee02, 0x7fc00000, 0x001),
    bits(0xbb086edc, 0x7fc00000, 0x001), bits(0x411b7834, 0x7fc00000, 0x001),
    bits(0xbab484b8, 0xbab484bc, 0x000), bits(0x411eb7ca, 0x3df57e72, 0x000),
    bits(0x3be9ca10, 0x3be9ca11, 0x000), bits(0x411c9351, 0xbc65efdf, 0x000),
    bits(0xbbb18d08, 0xbbb18d07, 0x000), bits(0x411db4f0, 0x3d68236f, 0x000),
    bits(0xbb459660, 0xbb459661, 0x000), bits(0x411c9e08, 0xbc3b13dd, 0x000),
    bits(0x3ba86ff0, 0x3ba86ff0, 0x000), bits(0x411d3c9a, 0x3cdf9a10, 0x000),
    bits(0x3b9d37ee, 0x3b9d37ed, 0x000), bits(0x411d4fd9, 0x3d030bd5, 0x000),
    bits(0x3b822c6e, 0x3b822c6f, 0x000), bits(0x411b3bff, 0xbdc866e2, 0x000),
    bits(0xbc0afcf1, 0xbc0afcf1, 0x000), bits(0x411ca200, 0xbc2b3249, 0x000),
    bits(0xbbbef282, 0xbbbef282, 0x000), bits(0x411be211, 0xbd6abc6e, 0x000),
];
