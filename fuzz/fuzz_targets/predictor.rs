//! The predictor against a naive twin in f64, for any model and events: equal bits if both compute the same sums.
#![no_main]

use fos_fuzz::drawn::{event, events, model};
use fos_testkit::models::Draw;
use fos_fuzz::twin::compare;
use libfuzzer_sys::arbitrary::Unstructured;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    // Tolerance as in the property tests of the predictor.
    let (kind, tolerance) =
        if bytes.arbitrary().unwrap_or(false) { (Draw::Exact, 0.0) } else { (Draw::Contracting, 1e-9) };
    let Ok(model) = model(&mut bytes, kind) else { return };
    let events = events(&mut bytes, event);
    if let Err(difference) = compare(&model, &events, tolerance) {
        panic!("{difference}\n{model:?}\n{events:?}");
    }
});
