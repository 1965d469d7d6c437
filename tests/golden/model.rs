// host-fit, a model for tests
#[allow(unused_imports)]
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, CheckedModel, FittedOn, InnovationStatistics, Input, Model,
    Quantity, Range, Source, StillnessLimits, Term, Transform, TriadCalibration, u, y,
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

/// The fitted model: inputs, terms and scaling of 2 axes. The compiler checks it.
pub static MODEL: CheckedModel<'static> = CheckedModel::new(Model {
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: Some(StillnessLimits { window: 100, accel_variance: 0.001, gyro_variance: 1e-5, gyro_at_rest: [0.01, -0.02, 0.0], gyro_deviation: 0.02 }),
    calibration: Some(Calibration {
        accel: TriadCalibration { matrix: [[0.98, 0.01, -0.02], [0.0, 1.03, 0.005], [0.015, -0.01, 0.99]], bias: [0.2, -0.1, -0.00756] },
        gyro: TriadCalibration { matrix: [[1.01, -0.02, 0.0], [0.01, 0.97, 0.0], [0.0, 0.03, 1.0]], bias: [0.0, 0.0, -0.002] },
    }),
    quantities: &[Quantity::Temperature, Quantity::Supply, Quantity::Measured(Axis::Az)],
    inputs: &INPUTS,
    axes: &AXES,
});

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
    hub.load_checked(&MODEL)?;
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
    bits(0x3b91f558, 0x7fc00000, 0x001), bits(0x411b683c, 0x7fc00000, 0x001),
    bits(0xbbc1c486, 0x7fc00000, 0x001), bits(0x411ca5fe, 0x7fc00000, 0x001),
    bits(0xbbc62e3f, 0xbbc437ed, 0x000), bits(0x411ab685, 0x7fc00000, 0x001),
    bits(0x3c72c725, 0x3c705fca, 0x000), bits(0x411aeba7, 0xbcbdeb7c, 0x000),
    bits(0x3b8fb589, 0x3b8e4949, 0x000), bits(0x411c52f9, 0x3d85fe72, 0x000),
    bits(0xbbde1564, 0xbbdbe27d, 0x000), bits(0x4119bfdf, 0xbdc6e30a, 0x000),
    bits(0x3b8a41ef, 0x3b88e380, 0x000), bits(0x411a95a0, 0xbd35db98, 0x000),
    bits(0xbc2e73b2, 0xbc2cb986, 0x000), bits(0x411c348d, 0x3d6d423a, 0x000),
    bits(0x3a81c739, 0x3a807e48, 0x000), bits(0x411a7908, 0xbd52bda0, 0x000),
    bits(0x3c215aed, 0x3c1fc1f3, 0x000), bits(0x411c3dc1, 0x3d768e6a, 0x000),
    bits(0x3b8bfcfa, 0x3b8a9a27, 0x000), bits(0x411a49df, 0xbd81309a, 0x000),
    bits(0xbc21fe7a, 0xbc2063e1, 0x000), bits(0x411a4a08, 0xbd811b96, 0x000),
    bits(0xbc2cae2c, 0xbc2af87c, 0x000), bits(0x411b9275, 0x3c930def, 0x000),
    bits(0x3bd8a42a, 0x3bd67f0d, 0x000), bits(0x411b9219, 0x3c92540f, 0x000),
    bits(0x3bb5af95, 0x3bb3e311, 0x000), bits(0x411ad498, 0xbcec8278, 0x000),
    bits(0xb95f4b39, 0xb95d1526, 0x000), bits(0x411a0392, 0xbda4b22f, 0x000),
    bits(0x3bd9cb48, 0x3bd7a341, 0x000), bits(0x411cc0d3, 0x3dbd7952, 0x000),
    bits(0xb9470b01, 0xb9451266, 0x000), bits(0x411ad1a9, 0xbcf26fa7, 0x000),
    bits(0xbc6fdedf, 0xbc6d7ee2, 0x000), bits(0x411c96d6, 0x3da844a3, 0x000),
    bits(0xba6efb1c, 0xba6c9d5b, 0x000), bits(0x4119595a, 0xbdfaa9f6, 0x000),
    bits(0x3c1e2f33, 0x3c1c9e42, 0x000), bits(0x411b00ab, 0xbc9377f1, 0x000),
    bits(0x3b278b8f, 0x3b25e2e3, 0x000), bits(0x411b52d2, 0x3b13f736, 0x000),
    bits(0xbbf1fe48, 0xbbef98e8, 0x000), bits(0x411c4917, 0x3d810086, 0x000),
    bits(0xbb41db88, 0xbb3ff02d, 0x000), bits(0x411b0bbd, 0xbc7a37f1, 0x000),
    bits(0x3bacebcd, 0x3bab3581, 0x000), bits(0x411aa4c8, 0xbd268cd1, 0x000),
    bits(0x3aff549c, 0x3afccd6b, 0x000), bits(0x411bacf4, 0x3cc89388, 0x000),
    bits(0xbafc88f7, 0xbafa08dc, 0x000), bits(0x411b1703, 0xbc4ca842, 0x000),
    bits(0xbbf0fd17, 0xbbee9a44, 0x000), bits(0x411cbc90, 0x3dbb5244, 0x000),
    bits(0x3c410e4c, 0x3c3f24f8, 0x000), bits(0x411b2401, 0xbc182d6f, 0x000),
    bits(0xbb8def98, 0xbb8c87d5, 0x000), bits(0x411b24f5, 0xbc144efe, 0x000),
    bits(0x3a8b733d, 0x3a8a11ca, 0x000), bits(0x411bbc11, 0x3ce71b1e, 0x000),
    bits(0x39ec00af, 0x39e9aa7f, 0x000), bits(0x411a572e, 0xbd74ef12, 0x000),
    bits(0xbd40c921, 0xbd3ee07d, 0x018), bits(0x4117112f, 0xbe886ca9, 0x018),
    bits(0x3c04f701, 0x3c03a5fc, 0x010), bits(0x411d9d2f, 0x3e166243, 0x000),
    bits(0x3d45e425, 0x3d43ee8f, 0x018), bits(0x411fd9a9, 0x3e937957, 0x018),
    bits(0xbb6cbfdc, 0xbb6a67cb, 0x010), bits(0x4119b231, 0xbdcdcb5f, 0x000),
    bits(0xbb387726, 0xbb36a395, 0x040), bits(0x411bc5b6, 0x3cfa980b, 0x040),
    bits(0xbc397074, 0xbc379a6f, 0x000), bits(0x411b4500, 0xba96c22b, 0x000),
    bits(0x3b316ba3, 0x3b2fa9ef, 0x040), bits(0x411b1e0c, 0xbc303cbb, 0x000),
    bits(0x3b7ea78e, 0x3b7c2218, 0x000), bits(0x411bff78, 0x3d37a381, 0x000),
    bits(0x4090cf05, 0x7fc00000, 0x092), bits(0x4229421b, 0x7fc00000, 0x082),
    bits(0xbc060729, 0xbc04b371, 0x002), bits(0x411c2f32, 0x7fc00000, 0x002),
    bits(0x408c9182, 0x7fc00000, 0x092), bits(0x421b0ebd, 0x7fc00000, 0x082),
    bits(0x39d31c98, 0x39d10583, 0x002), bits(0x411bf1fe, 0x7fc00000, 0x002),
    bits(0x3e0988ae, 0x7fc00000, 0x012), bits(0x40cb3952, 0x7fc00000, 0x002),
    bits(0x3f0fee39, 0x7fc00000, 0x012), bits(0x4107168f, 0x7fc00000, 0x002),
    bits(0x3e60c782, 0x7fc00000, 0x012), bits(0x40a83b3a, 0x7fc00000, 0x002),
    bits(0x3e19ba5e, 0x7fc00000, 0x002), bits(0x411d36dd, 0x7fc00000, 0x002),
    bits(0x3db994e9, 0x7fc00000, 0x012), bits(0x4162e678, 0x7fc00000, 0x002),
    bits(0xbdbe1400, 0x7fc00000, 0x012), bits(0x412cc77f, 0x7fc00000, 0x002),
    bits(0xbe80be6a, 0x7fc00000, 0x012), bits(0x415aad57, 0x7fc00000, 0x002),
    bits(0x3ec452df, 0x7fc00000, 0x012), bits(0x4137f572, 0x7fc00000, 0x002),
    bits(0x3c00315d, 0x3bfdd8e0, 0x002), bits(0x411a4331, 0x7fc00000, 0x002),
    bits(0x3a2851a1, 0x3a26a6ed, 0x002), bits(0x411ad116, 0xbcf3989b, 0x002),
    bits(0x3b1f403d, 0x3b1dac9a, 0x002), bits(0x411aff13, 0xbc96b024, 0x002),
    bits(0x3b55dfa8, 0x7fc00000, 0x001), bits(0x411c67fb, 0x7fc00000, 0x001),
    bits(0xbb09cc21, 0x7fc00000, 0x001), bits(0x4119f879, 0x7fc00000, 0x001),
    bits(0xbab652d8, 0xbab484bc, 0x000), bits(0x411d2fbe, 0x3df57e72, 0x000),
    bits(0x3bec2090, 0x3be9ca11, 0x000), bits(0x411b10c2, 0xbc65efdf, 0x000),
    bits(0xbbb35390, 0xbbb18d07, 0x000), bits(0x411c2f7b, 0x3d68236f, 0x000),
    bits(0xbb479033, 0xbb459661, 0x000), bits(0x411b1b5d, 0xbc3b13dd, 0x000),
    bits(0x3baa1f23, 0x3ba86ff0, 0x000), bits(0x411bb859, 0x3cdf9a10, 0x000),
    bits(0x3b9eca69, 0x3b9d37ed, 0x000), bits(0x411bcb67, 0x3d030bd5, 0x000),
    bits(0x3b8379ac, 0x3b822c6f, 0x000), bits(0x4119bcde, 0xbdc866e2, 0x000),
    bits(0xbc0c60c0, 0xbc0afcf1, 0x000), bits(0x411b1f4b, 0xbc2b3249, 0x000),
    bits(0xbbc0db55, 0xbbbef282, 0x000), bits(0x411a6147, 0xbd6abc6e, 0x000),
];
