//! Missing cells of a logged quantity: an input of a model on the device and the same transform on the host start and
//! continue alike.

use fos_core::{Range, Sample, Source, Transform, Transformer};
use fos_testkit::models::{OwnedModel, PERIOD_S, Roomy, input, plain};
use fos_testkit::noise::Noise;

const ROWS: usize = 400;
/// Numbers of cells missing at the start; the longest exceeds the memory of the transforms below.
const LEADS: [usize; 4] = [0, 1, 7, 120];

fn transforms() -> [Transform<f64>; 10] {
    [
        Transform::Identity,
        Transform::LowPass { tau_s: 0.3 },
        Transform::Rate { tau_s: 0.1 },
        Transform::Variance { tau_s: 0.2 },
        Transform::Backlash { half_width: 0.4 },
        Transform::Absolute,
        Transform::Decay { tau_s: 1.0 },
        Transform::Time,
        Transform::Sine { frequency_hz: 1.3 },
        Transform::Cosine { frequency_hz: 1.3 },
    ]
}

/// A temperature near 25 °C with missing cells: `lead` at the start, single ones, a stretch, the last four.
fn cells(lead: usize) -> Vec<f64> {
    let mut noise = Noise::new(5);
    let missing = |row: usize| row < lead || row % 50 == 3 || (200..230).contains(&row) || row >= ROWS - 4;
    (0..ROWS)
        .map(|row| {
            let value = 25.0 + 0.01 * row as f64 + 0.2 * noise.normal();
            if missing(row) { f64::NAN } else { value }
        })
        .collect()
}

/// Values of an input of a model; a gap of 33 ticks lies before row 300.
fn on_the_device(transform: Transform<f64>, cells: &[f64]) -> Vec<f64> {
    let source = if transform.is_clock() { Source::Clock } else { Source::Quantity(0) };
    let wide = Range::new(-1e9, 1e9);
    let input = fos_core::Input { source_range: wide, range: wide, ..input(source, transform, 1.0) };
    let model: OwnedModel<f64> = OwnedModel {
        quantities: vec![fos_core::Quantity::Temperature],
        inputs: vec![input],
        ..OwnedModel::autoregressive(plain(), vec![])
    };
    let mut predictor: Roomy<f64> = model.predictor().unwrap();
    let rows = cells.iter().enumerate().map(|(row, cell)| {
        if row == 300 {
            let _ = predictor.skip(33);
        }
        let _ = predictor.coast(&Sample { measured: &[0.0], quantities: &[*cell] });
        predictor.input(0).unwrap()
    });
    rows.collect()
}

/// Values of the transform alone; `start` processes the cells before the first known one.
fn on_the_host(
    transform: Transform<f64>,
    cells: &[f64],
    start: impl Fn(&mut Transformer<f64>, f64) -> f64,
) -> Vec<f64> {
    let mut transformer = Transformer::new(&transform, PERIOD_S);
    let mut known = false;
    let rows = cells.iter().enumerate().map(|(row, cell)| {
        if row == 300 {
            transformer.skip(33);
        }
        known |= cell.is_finite();
        if known || transform.is_clock() { transformer.update(*cell) } else { start(&mut transformer, *cell) }
    });
    rows.collect()
}

/// Number of rows that differ by more than rounding: a device steps through the beginning of a gap, a host skips it in
/// closed form.
fn differing(a: &[f64], b: &[f64]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-9).count()
}

#[test]
fn device_and_host_agree_on_missing_cells() {
    let (mut compared, mut control) = (0, 0);
    for transform in transforms() {
        for lead in LEADS {
            let cells = cells(lead);
            let device = on_the_device(transform, &cells);
            let host = on_the_host(transform, &cells, Transformer::update);
            assert_eq!(differing(&device, &host), 0, "{transform:?}, {lead} missing at first");
            compared += cells.len();

            // negative control: a transform with a memory that starts at 0 °C
            let from_zero = on_the_host(transform, &cells, |transformer, _| transformer.update(0.0));
            let differs = differing(&device, &from_zero) > 0;
            let remembers = matches!(
                transform,
                Transform::LowPass { .. }
                    | Transform::Rate { .. }
                    | Transform::Variance { .. }
                    | Transform::Backlash { .. }
            );
            assert_eq!(differs, remembers && lead > 0, "{transform:?}, {lead} missing at first");
            control += usize::from(differs);
        }
    }
    println!(
        "attack: missing cells, transforms | {compared} samples of {} transforms, with empty cells at both ends, inside and across a gap: the device computes the same inputs as the host | negative control: a host that starts from 0 differs in all {control} cases with memory",
        transforms().len()
    );
}

#[test]
fn transform_forgets_missing_cells_before_the_first_value() {
    for transform in transforms().into_iter().filter(|transform| !transform.is_clock()) {
        let all = cells(0);
        let begin = all.iter().position(|cell| cell.is_finite()).unwrap();
        let late = cells(120);
        let first = late.iter().position(|cell| cell.is_finite()).unwrap();
        assert!(first > begin);
        let whole = on_the_device(transform, &late);
        let mut fresh = Transformer::new(&transform, PERIOD_S);
        for row in first..300 {
            let alone = fresh.update(late[row]);
            assert_eq!(alone.to_bits(), whole[row].to_bits(), "{transform:?}, row {row}");
        }
    }
}
