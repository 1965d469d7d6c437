//! Control: a CSV reader that assumes the same number of cells in all lines. The fuzzer must find it.
#![no_main]

use std::hint::black_box;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap_or_default();
    for cells in lines.filter(|_| header.contains(&"t_s")) {
        for column in 0..header.len() {
            black_box(cells[column].parse::<f64>().ok());
        }
    }
});
