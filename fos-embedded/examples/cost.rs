//! What a model costs: instructions a sample on the emulated Cortex-M4F, RAM, and the size of its image.
//!
//! Prints tables in Markdown. On the host it runs without counting; sizes are those of the machine it runs on.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

use core::hint::black_box;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Info, InnovationStatistics, Input, Model, Monitor, Predictor,
    Quantity, Range, Sample, Source, Term, Transform, y,
};
use platform::{Instructions, fail, println};

mod platform;

const PERIOD_S: f64 = 0.005;
const STEPS: u32 = 2000;

/// Half linear, the rest quadratic but for a tenth cubic: what a search of cross-product degree 3 tends to find.
static TERMS_OF_AN_AXIS: [Term<f32>; 20] = [
    Term::new(0.3, &[y(1)]),
    Term::new(0.2, &[y(2)]),
    Term::new(0.1, &[y(3)]),
    Term::new(0.01, &[y(1), y(2)]),
    Term::new(-0.01, &[y(3), y(3)]),
    Term::new(0.05, &[y(4)]),
    Term::new(0.05, &[y(7)]),
    Term::new(-0.01, &[y(4), y(10)]),
    Term::new(0.01, &[y(2), y(5)]),
    Term::new(0.001, &[y(1), y(1), y(2)]),
    Term::new(0.02, &[y(5)]),
    Term::new(0.02, &[y(6)]),
    Term::new(0.02, &[y(8)]),
    Term::new(0.02, &[y(9)]),
    Term::new(0.02, &[y(10)]),
    Term::new(0.003, &[y(1), y(6)]),
    Term::new(-0.003, &[y(2), y(8)]),
    Term::new(0.003, &[y(3), y(9)]),
    Term::new(-0.003, &[y(6), y(7)]),
    Term::new(0.001, &[y(2), y(3), y(4)]),
];

const PARAMETERS: AxisParameters<f32> = AxisParameters {
    axis: Axis::Gx,
    reference: 0.0,
    offset: 0.011,
    scale: 0.002,
    constant: 0.001,
    range: Range::new(-5.0, 5.0),
    full_scale: 8.0,
    stuck_after: 100,
    gap_limit: 20,
    coast_limit_s: 60.0,
    innovation: InnovationStatistics { mean: 0.0, variance: 0.3, lag_1_correlation: 0.0 },
};

const fn input(source: Source, transform: Transform<f32>, centre: f32, scale: f32) -> Input<f32> {
    let range = Range::new(-5.0, 5.0);
    Input { source, transform, centre, scale, source_range: range, range }
}

/// Temperature, what the die makes of it, and the long memory of the error itself.
static INPUTS: [Input<f32>; 3] = [
    input(Source::Quantity(0), Transform::Identity, 25.0, 10.0),
    input(Source::Quantity(0), Transform::LowPass { tau_s: 60.0 }, 25.0, 10.0),
    input(Source::Remainder(0), Transform::LowPass { tau_s: 30.0 }, 0.0, 1.0),
];

fn model<'a>(axes: &'a [AxisModel<'a, f32>], inputs: &'a [Input<f32>]) -> Model<'a, f32> {
    Model {
        period_s: PERIOD_S,
        fitted_on: FittedOn::Raw,
        stillness: None,
        quantities: &[Quantity::Temperature],
        inputs,
        axes,
    }
}

/// A measured value that is never the same twice.
fn measured(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    0.011 + (*state >> 8) as f32 * (0.004 / 16_777_216.0)
}

/// Instructions of one tracked and of one coasted sample.
fn steps<const AXES: usize, const TERMS: usize, const HISTORY: usize>(
    instructions: &mut Instructions,
    model: &Model<'_, f32>,
) -> (f64, f64) {
    let mut predictor = match Predictor::<f32, AXES, 3, TERMS, HISTORY>::new(model) {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("{error}")),
    };
    let mut state = 1;
    let loop_alone = instructions.of(|| {
        for _ in 0..STEPS {
            black_box(&[measured(&mut state); AXES]);
        }
    });
    let mut spent = |still: bool| {
        let all = instructions.of(|| {
            for _ in 0..STEPS {
                let values = [measured(&mut state); AXES];
                let sample = Sample { measured: black_box(&values), quantities: &[25.5] };
                black_box(if still { predictor.track(&sample) } else { predictor.coast(&sample) });
            }
        });
        (all - loop_alone) / f64::from(STEPS)
    };
    (spent(true), spent(false))
}

/// One row of the table: a model of `n_terms` terms on each of `AXES` axes.
fn row<const AXES: usize, const TERMS: usize, const HISTORY: usize>(instructions: &mut Instructions) {
    let terms = &TERMS_OF_AN_AXIS[..TERMS / AXES];
    let factors: usize = terms.iter().map(|term| term.factors().len()).sum();
    let axes = [AxisModel { parameters: PARAMETERS, physical: &[], stochastic: terms }; AXES];
    let model = model(&axes, &[]);
    let (track, coast) = steps::<AXES, TERMS, HISTORY>(instructions, &model);
    let image = match encode(&model, &Info::default(), &mut [0; 8192]) {
        Ok(image) => image.len(),
        Err(error) => fail(format_args!("{error}")),
    };
    let ram = size_of::<Predictor<f32, AXES, 0, TERMS, HISTORY>>();
    println!(
        "| {AXES} | {} | {factors} | {track:.0} | {coast:.0} | {:.0} | {ram} | {image} |",
        terms.len(),
        track / AXES as f64
    );
}

fn run() {
    let mut instructions = Instructions::start();
    println!(
        "| axes | terms an axis | factors an axis | track | coast | track an axis | RAM, bytes | image, bytes |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    row::<1, 0, 16>(&mut instructions);
    row::<1, 5, 16>(&mut instructions);
    row::<1, 10, 16>(&mut instructions);
    row::<1, 20, 16>(&mut instructions);
    row::<6, 0, 64>(&mut instructions);
    row::<6, 30, 64>(&mut instructions);
    row::<6, 60, 64>(&mut instructions);
    row::<6, 120, 64>(&mut instructions);

    println!();
    println!("| inputs (one axis, no terms) | track | coast |");
    println!("|---|---|---|");
    let axes = [AxisModel { parameters: PARAMETERS, physical: &[], stochastic: &[] }];
    let names = ["none", "+ identity", "+ low-pass", "+ low-pass of the remainder"];
    for (n_inputs, name) in names.iter().enumerate() {
        let (track, coast) = steps::<1, 1, 16>(&mut instructions, &model(&axes, &INPUTS[..n_inputs]));
        println!("| {name} | {track:.0} | {coast:.0} |");
    }

    let mut monitor = Monitor::new(&PARAMETERS, PERIOD_S);
    let mut predictor = match Predictor::<f32, 1, 1, 1, 1>::new(&model(&axes, &[])) {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("{error}")),
    };
    let correction = predictor.track(&Sample { measured: &[0.012], quantities: &[] })[0];
    let all = instructions.of(|| {
        for _ in 0..STEPS {
            let _ = black_box(monitor.update(black_box(&correction)));
        }
    });
    println!();
    println!("monitor, a correction: {:.0} instructions", all / f64::from(STEPS));
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    run();
}
