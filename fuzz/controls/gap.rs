//! Control: a twin that coasts one sample longer than the model. The comparison must find it.
#![no_main]

use fos_fuzz::drawn::{event, events, model};
use fos_testkit::models::Draw;
use fos_fuzz::twin::{Twin, compare_with};
use libfuzzer_sys::arbitrary::Unstructured;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let Ok(model) = model(&mut bytes, Draw::Exact) else { return };
    let events = events(&mut bytes, event);
    let mut other = model.clone();
    for axis in &mut other.axes {
        axis.parameters.gap_limit_samples += 1;
    }
    if let Err(difference) = compare_with(Twin::new(&other), &model, &events, 0.0) {
        panic!("{difference}");
    }
});
