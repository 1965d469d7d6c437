//! Results of the detectors stay with a recording and reach no other one.

use super::detected::Found;
use super::{LoadOptions, Marks, Recording, Source};

#[test]
fn keeps_what_was_detected_until_a_column_changes() {
    let columns = vec![("gx_rads".to_owned(), vec![1.0, 2.0, 3.0])];
    let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
    let log = Recording::from_columns(Source::made_by("test"), columns, &options).unwrap();
    let detect = |log: &Recording, rows| {
        let new = || Marks { found: Vec::new(), rest: vec![true; rows], turns: Vec::new() };
        log.detected.marks.get_or_find((), new).rest.len()
    };
    assert_eq!(detect(&log, 1), 1);
    assert_eq!(detect(&log, 2), 1);
    assert_eq!(detect(&log.clone(), 2), 1);
    assert_eq!(detect(&log.with_values("gx_rads", vec![1.0; 3]), 2), 2);
    assert_eq!(detect(&log.first_rows(2), 2), 2);
    assert_eq!(detect(&log.with_rests(vec![true; 3], Vec::new()), 2), 2);
    assert_eq!(detect(&Recording::join(vec![log.clone(), log]).unwrap(), 2), 2);
}

#[test]
fn stores_one_result_for_each_key() {
    let found = Found::default();
    let results = [(1, 10), (2, 20), (1, 30)].map(|(key, new)| *found.get_or_find(key, || new));
    assert_eq!(results, [10, 20, 10]);
}
