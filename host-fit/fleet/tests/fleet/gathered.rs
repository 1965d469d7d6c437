//! Gathered rows give the same bits for any distribution of the rows and any order of merges.

use crate::drawn::{asked, row};
use fos_diagnose::effects::Library;
use fos_fleet::{AxisDiagnosis, Fleet, FoundEffect, Gathered, UnitRow};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
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
    rows.iter().for_each(|row| gathered.add(row).expect("a row"));
    gathered
}

fn fleet_of(gathered: &Gathered) -> Fleet {
    Fleet::of_gathered(gathered, &Library::built_in(), "a test").expect("a fleet")
}

#[test]
fn merge_order_does_not_change_the_bits() {
    let mut rows = rows();
    let expected = Fleet::of(&rows, &asked(), &Library::built_in(), "a test").to_bytes();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..6 {
        rows.shuffle(&mut random);
        let mut left = rows.as_slice();
        let mut apart = Vec::new();
        while !left.is_empty() {
            let (some, rest) = left.split_at(random.random_range(0..=left.len()));
            apart.push(Gathered::from_bytes(&gathered(some).to_bytes()).expect("as it was written"));
            left = rest;
        }
        apart.shuffle(&mut random);
        // Merged in pairs, as by a tree of machines.
        while apart.len() > 1 {
            let mut next = Vec::new();
            for pair in apart.chunks(2) {
                let mut merged = pair[0].clone();
                pair.iter().skip(1).for_each(|other| merged.merge(other.clone()).expect("of one fleet"));
                next.push(merged);
            }
            apart = next;
        }
        let merged = apart.pop().expect("one is left");
        assert_eq!(merged.len(), UNITS);
        assert_eq!(fleet_of(&merged).to_bytes(), expected);
    }
    assert_ne!(fleet_of(&gathered(&rows[1..])).to_bytes(), expected, "without a unit it is another");
}

#[test]
fn rejects_mismatched_rows_without_changes() {
    let mut of_all = gathered(&rows());
    let mut other = row(999);
    other.asked.regressors.push("temp_c * temp_c".to_owned());
    let before = of_all.clone();
    let refused = of_all.add(&other).expect_err("asked something else").to_string();
    assert!(refused.contains("u00000999") && refused.contains("help: "), "{refused}");
    assert!(of_all.merge(gathered(&[other])).is_err());
    let mut torn = row(998);
    torn.axes[1].estimate.coefficients.values.pop();
    let refused = of_all.add(&torn).expect_err("a value is missing").to_string();
    assert!(refused.contains("u00000998") && refused.contains("ay_mps2"), "{refused}");
    assert_eq!(of_all, before);

    of_all.merge(gathered(&[row(7)])).expect("told when all are there");
    let twice = Fleet::of_gathered(&of_all, &Library::built_in(), "").expect_err("a unit twice").to_string();
    assert!(twice.contains("u00000007") && twice.contains("help: "), "{twice}");
    let nothing = Fleet::of_gathered(&Gathered::default(), &Library::built_in(), "");
    assert!(nothing.expect_err("no row").to_string().contains("help: "));
}

#[test]
fn damaged_bytes_never_panic() {
    let bytes = gathered(&rows()[..10]).to_bytes();
    assert!(Gathered::from_bytes(&bytes[..bytes.len() - 1]).is_err());
    assert!(
        Gathered::from_bytes(b"").is_err() && Gathered::from_bytes(&[&bytes[..], b"x"].concat()).is_err()
    );
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut refused = 0;
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        let place = random.random_range(0..damaged.len());
        damaged[place] ^= 1 << random.random_range(0..8);
        match Gathered::from_bytes(&damaged) {
            Ok(gathered) => drop(Fleet::of_gathered(&gathered, &Library::built_in(), "a test")),
            Err(_) => refused += 1,
        }
    }
    // Most bytes are digits of numbers, where any bits are valid.
    assert!(refused > 3, "{refused}");
}

#[test]
fn gathered_unit_needs_a_fifth_of_its_row() {
    let rows: Vec<UnitRow> = (0..500).map(row).collect();
    let of_rows: usize = rows.iter().map(|row| serde_json::to_vec(row).expect("JSON").len()).sum();
    let bytes = gathered(&rows).to_bytes().len();
    // 48 numbers, a digest of the row, half a digest of its log, a name.
    assert!(bytes < 500 * (48 * 8 + 32 + 16 + 32) && bytes * 4 < of_rows, "{bytes} of {of_rows}");
}
