//! Cached results of a recording stay with it and reach no other one.

use super::{LoadOptions, Recording, Source};

#[test]
fn caches_results_until_a_column_changes() {
    let columns = vec![("gx_rads".to_owned(), vec![1.0, 2.0, 3.0])];
    let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
    let log = Recording::from_columns(Source::made_by("test"), columns, &options).unwrap();
    let sum = |log: &Recording| log.cached(|log| log.channels()[0].values.iter().sum::<f64>());
    assert_eq!(*sum(&log), 6.0);
    assert_eq!(*log.cached(|_| -> f64 { unreachable!("it is known") }), 6.0);
    assert_eq!(*log.clone().cached(|_| -> f64 { unreachable!("a clone knows it") }), 6.0);
    assert_eq!(*sum(&log.with_values("gx_rads", vec![1.0; 3])), 3.0);
    assert_eq!(*sum(&log.first_rows(2)), 3.0);
    assert_eq!(*log.with_rests(vec![true; 3], Vec::new()).cached(|_| 7.0), 7.0);
    assert_eq!(*sum(&Recording::join(vec![log.clone(), log]).unwrap()), 12.0);
}
