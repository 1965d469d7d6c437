//! What a step costs: instructions per tick on the emulated Cortex-M4F, for models of 5, 10 and 20 terms.
//!
//! Prints one line of JSON per case. On the host it runs without counting.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

use core::hint::black_box;

use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Monitor, Predictor, Range,
    Sample, Term, y,
};
use platform::{Instructions, fail, println};

mod platform;

const PERIOD_S: f64 = 0.005;
const STEPS: u32 = 2000;

/// Half linear, the rest quadratic but for a tenth cubic: what a search of cross-product degree 3 tends to find.
static TERMS: [Term<f32>; 20] = [
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

fn model<'a>(axes: &'a [AxisModel<'a, f32>]) -> Model<'a, f32> {
    Model {
        period_s: PERIOD_S,
        fitted_on: FittedOn::Raw,
        stillness: None,
        quantities: &[],
        inputs: &[],
        axes,
    }
}

/// A measured value that is never the same twice.
fn measured(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    0.011 + (*state >> 8) as f32 * (0.004 / 16_777_216.0)
}

fn run() {
    let mut instructions = Instructions::start();
    let mut state = 1;
    let loop_alone = instructions.of(|| {
        for _ in 0..STEPS {
            let values = [measured(&mut state); 6];
            black_box(&values);
        }
    });
    for n_terms in [0, 5, 10, 20] {
        let terms = &TERMS[..n_terms];
        let factors: usize = terms.iter().map(|term| term.factors().len()).sum();
        let axis = AxisModel { parameters: PARAMETERS, physical: &[], stochastic: terms };
        for n_axes in [1, 6] {
            let axes = [axis; 6];
            let mut predictor = match Predictor::<f32, 6, 1, 120, 64>::new(&model(&axes[..n_axes])) {
                Ok(predictor) => predictor,
                Err(error) => fail(format_args!("{error}")),
            };
            let mut spent = |still: bool| {
                let all = instructions.of(|| {
                    for _ in 0..STEPS {
                        let values = [measured(&mut state); 6];
                        let sample = Sample { measured: &black_box(&values)[..n_axes], quantities: &[] };
                        black_box(if still { predictor.track(&sample) } else { predictor.coast(&sample) });
                    }
                });
                (all - loop_alone) / f64::from(STEPS)
            };
            let (track, coast) = (spent(true), spent(false));
            let budget = 8 * factors * n_axes + 60 * n_axes;
            println!(
                "{{\"terms\":{n_terms},\"factors\":{factors},\"axes\":{n_axes},\"track\":{track:.1},\
                 \"coast\":{coast:.1},\"aim\":{budget}}}"
            );
        }
    }
    let mut monitor = Monitor::new(&PARAMETERS, PERIOD_S);
    let axes = [AxisModel { parameters: PARAMETERS, physical: &[], stochastic: &[] }];
    let mut predictor = match Predictor::<f32, 1, 1, 1, 1>::new(&model(&axes)) {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("{error}")),
    };
    let correction = predictor.track(&Sample { measured: &[0.012], quantities: &[] })[0];
    let all = instructions.of(|| {
        for _ in 0..STEPS {
            let _ = black_box(monitor.update(black_box(&correction)));
        }
    });
    println!("{{\"monitor\":{:.1}}}", all / f64::from(STEPS));
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    run();
}
