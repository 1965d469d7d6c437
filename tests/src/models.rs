//! Models that own their parts, and random models.

use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, Channel, Factor, FittedOn, InnovationStatistics, Input,
    Model, ModelError, Predictor, Quantity, Range, Real, Source, StillnessLimits, Term, Transform,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Sample period of all models here, s.
pub const PERIOD_S: f64 = 0.005;

/// Capacity for all models here: 8 inputs and 6 axes, lags up to 12: 12·14 + 8 values.
pub type Roomy<R> = Predictor<R, 6, 8, 128, 256>;

/// [`AxisModel`] that owns its terms.
#[derive(Debug, Clone)]
pub struct OwnedAxis<R> {
    /// Scales, limits, statistics.
    pub parameters: AxisParameters<R>,
    /// Terms of inputs only.
    pub physical: Vec<Term<R>>,
    /// Terms that may also use the past of the axis.
    pub stochastic: Vec<Term<R>>,
}

/// [`Model`] that owns its parts, so that a test can change one.
#[derive(Debug, Clone)]
pub struct OwnedModel<R> {
    /// Sample period, s.
    pub period_s: f64,
    /// Limits for the detection of rest.
    pub stillness: Option<StillnessLimits<R>>,
    /// Calibration of the corrected values.
    pub calibration: Option<Calibration<R>>,
    /// Quantities of a sample, in the order of the sources of the inputs.
    pub quantities: Vec<Quantity>,
    /// Inputs available to terms.
    pub inputs: Vec<Input<R>>,
    /// Axes in the order of the measured values.
    pub axes: Vec<OwnedAxis<R>>,
}

impl<R: Real> OwnedModel<R> {
    /// Model of one axis without inputs.
    pub fn autoregressive(parameters: AxisParameters<R>, stochastic: Vec<Term<R>>) -> Self {
        let axes = vec![OwnedAxis { parameters, physical: vec![], stochastic }];
        Self {
            period_s: PERIOD_S,
            stillness: None,
            calibration: None,
            quantities: vec![],
            inputs: vec![],
            axes,
        }
    }

    /// Passes the borrowed form to `user`.
    pub fn borrow<T>(&self, user: impl FnOnce(&Model<'_, R>) -> T) -> T {
        let axes: Vec<AxisModel<'_, R>> = self
            .axes
            .iter()
            .map(|axis| AxisModel {
                parameters: axis.parameters,
                physical: &axis.physical,
                stochastic: &axis.stochastic,
            })
            .collect();
        user(&Model {
            period_s: self.period_s,
            fitted_on: FittedOn::Raw,
            stillness: self.stillness,
            calibration: self.calibration,
            quantities: &self.quantities,
            inputs: &self.inputs,
            axes: &axes,
        })
    }

    /// # Errors
    ///
    /// The model is invalid.
    pub fn predictor(&self) -> Result<Roomy<R>, ModelError> {
        self.borrow(Predictor::new)
    }

    /// The same model in another scalar.
    pub fn convert<S: Real>(&self) -> OwnedModel<S> {
        let terms = |terms: &[Term<R>]| terms.iter().map(Term::convert).collect();
        OwnedModel {
            period_s: self.period_s,
            stillness: self.stillness.map(|limits| limits.convert()),
            calibration: self.calibration.map(|calibration| calibration.convert()),
            quantities: self.quantities.clone(),
            inputs: self.inputs.iter().map(Input::convert).collect(),
            axes: self
                .axes
                .iter()
                .map(|axis| OwnedAxis {
                    parameters: axis.parameters.convert(),
                    physical: terms(&axis.physical),
                    stochastic: terms(&axis.stochastic),
                })
                .collect(),
        }
    }
}

/// Axis in scaled units (offset 0, scale 1) with the range −1 … 1 and no fault test enabled.
pub fn plain<R: Real>() -> AxisParameters<R> {
    let number = R::from_f64;
    AxisParameters {
        axis: Axis::Gz,
        reference: number(0.0),
        offset: number(0.0),
        scale: number(1.0),
        constant: number(0.0),
        range: Range::new(number(-1.0), number(1.0)),
        physical_range: Range::unlimited(),
        full_scale: number(0.0),
        stuck_after_repeats: 0,
        gap_limit_samples: 20,
        coast_limit_s: number(1e9),
        innovation: InnovationStatistics {
            mean: number(0.0),
            variance: number(1.0),
            lag_1_correlation: number(0.0),
        },
    }
}

/// Input in scaled units with the range −`reach` … `reach`.
pub fn input<R: Real>(source: Source, transform: Transform<R>, reach: f64) -> Input<R> {
    let range = Range::new(R::from_f64(-reach), R::from_f64(reach));
    let (centre, scale) = (R::from_f64(0.0), R::from_f64(1.0));
    Input { source, transform, centre, scale, source_range: range, range }
}

/// Kind of random models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Draw {
    /// Transforms whose definition and recursion are the same sums: a naive twin gives the same bits.
    Exact,
    /// All transforms; the fed-back part is a contraction, so that rounding does not grow.
    Contracting,
}

fn transforms(draw: Draw) -> BoxedStrategy<Transform<f64>> {
    let plain = prop_oneof![
        Just(Transform::Identity),
        Just(Transform::Absolute),
        (0.0..0.8).prop_map(|half_width| Transform::Backlash { half_width }),
        Just(Transform::Time),
    ];
    if draw == Draw::Exact {
        return plain.boxed();
    }
    let tau = || 0.01..5.0;
    prop_oneof![
        plain,
        tau().prop_map(|tau_s| Transform::LowPass { tau_s }),
        tau().prop_map(|tau_s| Transform::Rate { tau_s }),
        tau().prop_map(|tau_s| Transform::Variance { tau_s }),
        tau().prop_map(|tau_s| Transform::Decay { tau_s }),
        (0.1..90.0).prop_map(|frequency_hz| Transform::Sine { frequency_hz }),
        (0.1..90.0).prop_map(|frequency_hz| Transform::Cosine { frequency_hz }),
    ]
    .boxed()
}

/// Source of an input with this transform: the clock, or the given quantity or axis.
pub fn source_of(transform: &Transform<f64>, of_a_remainder: bool, quantity: u8, axis: u8) -> Source {
    match (transform.is_clock(), of_a_remainder) {
        (true, _) => Source::Clock,
        (false, true) => Source::Remainder(axis),
        (false, false) => Source::Quantity(quantity),
    }
}

/// Input of quantities with the range −2 … 2.
pub fn shifted_input(
    source: Source,
    transform: Transform<f64>,
    centre: f64,
    scale: f64,
    reach: f64,
) -> Input<f64> {
    Input { centre, scale, source_range: Range::new(-2.0, 2.0), ..input(source, transform, reach) }
}

fn inputs(draw: Draw, n_axes: u8) -> impl Strategy<Value = Vec<Input<f64>>> {
    let one = (transforms(draw), any::<bool>(), 0_u8..3, 0..n_axes, -0.5..0.5, 0.5..2.0, 0.4..3.0_f64)
        .prop_map(|(transform, of_a_remainder, quantity, axis, centre, scale, reach)| {
            let source = source_of(&transform, of_a_remainder, quantity, axis);
            shifted_input(source, transform, centre, scale, reach)
        });
    prop::collection::vec(one, 0..=8)
}

/// A coefficient and factors, each a channel and a lag.
pub type Picks = Vec<(f64, Vec<(u8, u16)>)>;

fn picks() -> impl Strategy<Value = Picks> {
    prop::collection::vec((-1.0..1.0, prop::collection::vec((any::<u8>(), 0_u16..=12), 1..=3)), 0..=8)
}

/// Terms from arbitrary numbers; outputs come first among the channels to choose from.
fn terms(picks: Picks, allowed: &[u8], output: bool) -> Vec<Term<f64>> {
    let channels = allowed.len() + usize::from(output);
    let factor = |(pick, lag): (u8, u16)| {
        let pick = usize::from(pick) % channels;
        match (output, pick) {
            (true, 0) => Factor { channel: Channel::Output, lag: lag.max(1) },
            _ => Factor { channel: Channel::Input(allowed[pick - usize::from(output)]), lag },
        }
    };
    if channels == 0 {
        return vec![];
    }
    let term = |(coefficient, factors): (f64, Vec<_>)| {
        Term::new(coefficient, &factors.into_iter().map(factor).collect::<Vec<_>>())
    };
    picks.into_iter().map(term).collect()
}

/// An axis with these parameters over these inputs, with terms from arbitrary numbers.
pub fn axis_of(
    parameters: AxisParameters<f64>,
    physical: Picks,
    stochastic: Picks,
    draw: Draw,
    inputs: &[Input<f64>],
) -> OwnedAxis<f64> {
    let all: Vec<u8> = (0..inputs.len() as u8).collect();
    let remainder = |index: u8| matches!(inputs[usize::from(index)].source, Source::Remainder(_));
    let logged: Vec<u8> = all.iter().copied().filter(|&index| !remainder(index)).collect();
    let mut stochastic = terms(stochastic, &all, true);
    if draw == Draw::Contracting {
        // |∂r̂/∂r| summed over all lags: every other factor is at most 3.3 (reach 3, widened by 5 % of 6)
        let slope = |term: &Term<f64>| {
            let degree = term.factors().len();
            term.coefficient.abs() * degree as f64 * 3.3_f64.powi(degree as i32 - 1)
        };
        let total = stochastic.iter().map(slope).sum::<f64>().max(0.1);
        let shrink = |term: &Term<f64>| term.with_coefficient(0.8 * term.coefficient / total);
        stochastic = stochastic.iter().map(shrink).collect();
    }
    OwnedAxis { parameters, physical: terms(physical, &logged, false), stochastic }
}

/// Parameters of every random axis: a range of −`reach` … `reach`, and a full scale that samples rarely exceed.
pub fn drawn_axis(reach: f64) -> AxisParameters<f64> {
    // p is sometimes outside its range, by up to three times half its width.
    let physical_range = Range::new(-0.25 * reach, 0.5 * reach);
    AxisParameters { range: Range::new(-reach, reach), physical_range, full_scale: 14.0, ..plain() }
}

fn axis(draw: Draw, inputs: Vec<Input<f64>>) -> impl Strategy<Value = OwnedAxis<f64>> {
    let numbers = (-10.0..10.0, -0.1..0.1, 0.5..2.0, -0.3..0.3, 0.5..1.0_f64);
    let faults = (prop_oneof![Just(0_u16), 2_u16..6], 0_u8..12, prop_oneof![Just(0.0), 0.0..0.3, Just(1e9)]);
    (numbers, faults, picks(), picks()).prop_map(move |(numbers, faults, physical, stochastic)| {
        let (reference, offset, scale, constant, reach) = numbers;
        let (stuck_after_repeats, gap_limit_samples, coast_limit_s) = faults;
        let parameters = AxisParameters {
            reference,
            offset,
            scale,
            constant,
            stuck_after_repeats,
            gap_limit_samples,
            coast_limit_s,
            ..drawn_axis(reach)
        };
        axis_of(parameters, physical, stochastic, draw, &inputs)
    })
}

/// Models of 1 to 6 axes and up to 8 inputs over three quantities.
pub fn models(draw: Draw) -> impl Strategy<Value = OwnedModel<f64>> {
    (1_u8..=6)
        .prop_flat_map(move |n_axes| (inputs(draw, n_axes), Just(n_axes)))
        .prop_flat_map(move |(inputs, n_axes)| {
            let axes = prop::collection::vec(axis(draw, inputs.clone()), usize::from(n_axes));
            (Just(inputs), axes)
        })
        .prop_map(|(inputs, axes)| model_of(inputs, axes))
}

/// A model of these parts over three quantities.
pub fn model_of(inputs: Vec<Input<f64>>, axes: Vec<OwnedAxis<f64>>) -> OwnedModel<f64> {
    let quantities = vec![Quantity::Temperature, Quantity::Supply, Quantity::Load];
    OwnedModel { period_s: PERIOD_S, stillness: None, calibration: None, quantities, inputs, axes }
}

/// Configuration with this number of cases, always the same ones; longer runs set PROPTEST_CASES.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases: std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(cases),
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(0xf05),
        ..ProptestConfig::default()
    }
}
