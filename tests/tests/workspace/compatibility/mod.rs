//! A stored file of every format loads, and gives the recorded results to the bit.
//!
//! `tests/fixtures/README.md` describes the files and how to make a new one.

mod digest;
mod flash;
mod formats;
mod kinds;
mod make;

use std::fs;
use std::path::{Path, PathBuf};

use formats::{FORMATS, Format};
use fos_diagnose::study::Study;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

/// Path of a fixture, `NAME_vVERSION.EXTENSION`.
fn file_of(format: &Format) -> PathBuf {
    folder().join(format!("{}_v{}.{}", format.name, format.version, format.extension))
}

fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Path of the recorded results of a fixture: its name with `.txt` appended.
fn recorded(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".txt");
    name.into()
}

#[test]
fn every_fixture_gives_its_recorded_results() {
    println!("| format | version | fixture, bytes |\n|---|---|---|");
    for format in FORMATS {
        let path = file_of(format);
        let bytes = read(&path);
        let outputs = (format.outputs)(&bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let expected = String::from_utf8(read(&recorded(&path))).expect("UTF-8");
        assert!(outputs == expected, "{}: the results are now\n{outputs}", path.display());
        println!("| {} | {} | {} |", format.title, format.version, bytes.len());
    }
}

#[test]
fn writers_give_the_bytes_of_the_fixtures() {
    for (name, make) in [
        ("kinds", kinds::image as fn() -> Vec<u8>),
        ("hub_log", make::hub_log),
        ("telemetry", make::telemetry),
    ] {
        let format = FORMATS.iter().find(|format| format.name == name).expect("a format");
        // determined by the writer alone: no fit is in them
        assert!(make() == read(&file_of(format)), "{}: other bytes, and no other version", format.title);
    }
    let study = folder().join("study_v1.json");
    let written = Study::read(&study).expect("it is read").to_bytes();
    assert_eq!(String::from_utf8_lossy(&written), String::from_utf8_lossy(&read(&study)));
    // fos-core/tests/image.rs compares the writer of images with the description of the format, byte by byte
}

#[test]
fn a_file_in_the_folder_is_a_fixture_with_its_outputs() {
    // `reference`: answers computed by others, with a separate README
    let mut known: Vec<PathBuf> = ["README.md", "reference"].map(|name| folder().join(name)).into();
    for format in FORMATS {
        let path = file_of(format);
        known.extend([recorded(&path), path]);
    }
    for entry in fs::read_dir(folder()).expect("a folder") {
        let path = entry.expect("an entry").path();
        assert!(known.contains(&path), "{}: of no format, or of another version", path.display());
    }
}

#[test]
fn rejects_another_version_by_its_number() {
    for format in FORMATS {
        let Some(as_version) = format.as_version else { continue };
        let bytes = read(&file_of(format));
        for version in [format.version + 1, 999] {
            let message = (format.outputs)(&as_version(&bytes, version)).expect_err("it is refused");
            for word in [version.to_string(), "this program reads".to_owned(), format.version.to_string()] {
                assert!(message.contains(&word), "{}: {word:?} is not in: {message}", format.title);
            }
        }
    }
}

/// Negative control: a changed byte changes the results or is rejected.
#[test]
fn every_changed_byte_is_refused_or_changes_the_results() {
    for format in FORMATS {
        let path = file_of(format);
        let bytes = read(&path);
        let expected = (format.outputs)(&bytes);
        let (mut refused, mut differs) = (0, 0);
        for place in (format.payload)(&bytes) {
            let mut changed = bytes.clone();
            changed[place] ^= 1;
            match (format.outputs)(&changed) {
                Err(_) => refused += 1,
                outputs if outputs != expected => differs += 1,
                _ => panic!("{}: a change of byte {place} is not noticed", path.display()),
            }
        }
        assert!(refused + differs > 10, "{}: {refused} + {differs} bytes", path.display());
        println!(
            "control: {}, {} bytes changed: {refused} refused, {differs} with different results, 0 undetected",
            format.title,
            refused + differs
        );
    }
}
