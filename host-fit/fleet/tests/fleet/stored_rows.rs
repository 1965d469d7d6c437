//! The file of the rows: foreign files are refused, and interruptions lose no finished row.

use std::path::Path;

use crate::drawn::{asked, row};
use fos_data::file::keyed_rows::KeyedRowsError;
use fos_diagnose::effects::Library;
use fos_fleet::{Fleet, FleetError, Unit, UnitRow, rows, rows_beside};

/// Units whose logs do not exist: their rows are made at once and have the reason.
fn units() -> Vec<Unit> {
    let unit = |name: &str| Unit {
        name: name.to_owned(),
        part: "imu".to_owned(),
        lot: None,
        logs: vec![format!("{name}.csv").into()],
    };
    ["a", "b", "c"].map(unit).into()
}

fn rows_in(path: &Path, progress: impl Fn(usize) + Sync) -> Result<Vec<UnitRow>, KeyedRowsError> {
    rows(&units(), &asked(), &Library::built_in(), "a test", "a build", path, progress)
}

/// Content of the file after an uninterrupted run.
fn uninterrupted(path: &Path) -> String {
    rows_in(path, |_| {}).expect("rows");
    std::fs::read_to_string(path).expect("rows")
}

#[test]
fn rejects_foreign_files_of_any_length() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows");
    for foreign in ["notes", "notes\n", "42\n", "{}", "{\"a\": 1}\n", "[1, 2", "{\"a\": ", "one\ntwo\n"] {
        std::fs::write(&path, foreign).expect("a file");
        let refused = rows_in(&path, |_| {});
        assert!(matches!(refused, Err(KeyedRowsError::Foreign(_))), "{foreign:?}: {refused:?}");
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), foreign);
    }
}

#[test]
fn does_not_overwrite_foreign_files_beside_a_population() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("population.json");
    let found: Vec<UnitRow> = (0..4).map(row).collect();
    let texts: Vec<String> = found.iter().map(|row| serde_json::to_string(row).expect("JSON")).collect();
    let fleet = Fleet::of(&found, &asked(), &Library::built_in(), "a test");
    std::fs::write(rows_beside(&path), "notes\n").expect("a file");
    let refused = fleet.write_with_rows(&path, &texts);
    assert!(matches!(refused, Err(FleetError::Rows(KeyedRowsError::Foreign(_)))), "{refused:?}");
    assert_eq!(std::fs::read_to_string(rows_beside(&path)).expect("a file"), "notes\n");
    assert!(!path.exists());
    std::fs::remove_file(rows_beside(&path)).expect("removed");
    fleet.write_with_rows(&path, &texts).expect("written");
    fleet.write_with_rows(&path, &texts).expect("written again");
}

#[test]
fn resumes_after_an_interruption_in_the_first_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows");
    let whole = uninterrupted(&path);
    let first = whole.find('\n').expect("a line");
    for length in (0..first).step_by(5).chain([1, 2, first - 1]) {
        for end in ["", "\n"] {
            std::fs::write(&path, format!("{}{end}", &whole[..length])).expect("a file");
            assert_eq!(uninterrupted(&path), whole, "cut to {length} bytes, {end:?}");
        }
    }
}

#[test]
fn second_interruption_loses_no_finished_row() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows");
    let whole = uninterrupted(&path);
    let finished = || {
        let text = std::fs::read_to_string(&path).expect("rows");
        text.lines().filter(|line| whole.lines().any(|of_whole| of_whole == *line)).count()
    };
    // A cut at a line's end leaves a complete row without its newline.
    let ends = whole.match_indices('\n').map(|(place, _)| place);
    for length in (1..whole.len()).step_by(11).chain(ends) {
        std::fs::write(&path, &whole[..length]).expect("rows");
        rows_in(&path, |done| assert!(finished() >= done, "cut to {length} bytes, {done} rows done"))
            .expect("rows");
        assert_eq!(std::fs::read_to_string(&path).expect("rows"), whole, "cut to {length} bytes");
    }
}
