//! Gathered rows give the same bits in any order, and rows that do not form a fleet are refused.

use crate::drawn::{asked, row};
use fos_diagnose::effects::Library;
use fos_fleet::{AxisDiagnosis, Fleet, FoundEffect, Gathered, UnitRow};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

const UNITS: usize = 30;

/// Rows with and without diagnosis, one each of another part, without a lot, unreadable, and without a slope.
fn rows() -> Vec<UnitRow> {
    let mut rows: Vec<UnitRow> = (0..UNITS).map(|unit| row(unit * 7)).collect();
    for row in rows.iter_mut().step_by(3) {
        let found = FoundEffect { effect: format!("effect {}", row.unit), predicted_reduction: 0.25 };
        let verdict = fos_diagnose::detect::Verdict::Missing;
        row.axes[2].diagnosis = Some(AxisDiagnosis { verdict, effects: vec![found] });
    }
    rows[5].part = "another".to_owned();
    rows[6].lot = None;
    rows[7].axes.clear();
    rows[7].failed.push("the file is empty".to_owned());
    let slopeless = &mut rows[8].axes[3].estimate.coefficients;
    slopeless.names.truncate(1);
    slopeless.values.truncate(1);
    slopeless.covariance = vec![vec![slopeless.covariance[0][0]]];
    rows
}

fn gathered(rows: &[UnitRow]) -> Gathered {
    let mut gathered = Gathered::default();
    rows.iter().for_each(|row| gathered.add(row.clone()).expect("a row"));
    gathered
}

fn fleet_of(gathered: &Gathered) -> Fleet {
    Fleet::of_gathered(gathered, &Library::built_in(), "a test").expect("a fleet")
}

#[test]
fn order_of_rows_does_not_change_the_bits() {
    let mut rows = rows();
    let expected = Fleet::of(&rows, &asked(), &Library::built_in(), "a test").to_bytes();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..3 {
        rows.shuffle(&mut random);
        let gathered = gathered(&rows);
        assert_eq!(gathered.len(), UNITS);
        assert_eq!(fleet_of(&gathered).to_bytes(), expected);
    }
    assert_ne!(fleet_of(&gathered(&rows[1..])).to_bytes(), expected, "without a unit it is another");
}

#[test]
fn rejects_mismatched_rows_without_changes() {
    let mut of_all = gathered(&rows());
    let mut other = row(999);
    other.asked.regressors.push("temp_c * temp_c".to_owned());
    let before = of_all.clone();
    let refused = of_all.add(other).expect_err("asked something else").to_string();
    assert!(refused.contains("u00000999") && refused.contains("help: "), "{refused}");
    let mut damaged = row(998);
    damaged.axes[1].estimate.coefficients.values.pop();
    let refused = of_all.add(damaged).expect_err("a value is missing").to_string();
    assert!(refused.contains("u00000998") && refused.contains("ay_mps2"), "{refused}");
    assert_eq!(of_all, before);

    of_all.add(row(7)).expect("complete");
    let twice = Fleet::of_gathered(&of_all, &Library::built_in(), "").expect_err("a unit twice").to_string();
    assert!(twice.contains("u00000007") && twice.contains("help: "), "{twice}");
    let nothing = Fleet::of_gathered(&Gathered::default(), &Library::built_in(), "");
    assert!(nothing.expect_err("no row").to_string().contains("help: "));
}
