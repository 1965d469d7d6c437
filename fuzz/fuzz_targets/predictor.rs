//! The predictor against a naive twin in f64, over any model and any events: bit for bit where both are the same sums.
#![no_main]

use fos_fuzz::draw;
use fos_fuzz::models::{Draw, models};
use fos_fuzz::twin::{compare, events};
use libfuzzer_sys::fuzz_target;
use proptest::strategy::Strategy;

fuzz_target!(|bytes: &[u8]| {
    let Some((which, rest)) = bytes.split_first() else { return };
    // the tolerance: as in the property tests of the predictor
    let (kind, tolerance) = if which & 1 == 0 { (Draw::Exact, 0.0) } else { (Draw::Contracting, 1e-9) };
    let Some((model, events)) = draw((models(kind), events()).boxed(), rest) else { return };
    if let Err(difference) = compare(&model, &events, tolerance) {
        panic!("{difference}\n{model:?}\n{events:?}");
    }
});
