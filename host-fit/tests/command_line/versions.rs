//! A file of another version is refused with its name, its version, and the version that this program reads.

use std::fs;
use std::path::Path;

use crate::session::{done, fails};
use fos_embedded::telemetry::{Borrowed, Frame, HUB_AXES, StartFrame, encode};

fn fixture(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures").join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn refused(folder: &Path, arguments: &[&str], words: [&str; 3]) {
    let message = fails(folder, 1, arguments);
    for word in words {
        assert!(message.contains(word), "{arguments:?}: {word:?} is not in: {message}");
    }
}

#[test]
fn rejects_a_file_of_another_version_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).expect("written");

    let mut image = fixture("model_v1.fosm");
    write("read.fosm", &image);
    let message = done(folder, &["inspect", "read.fosm"]);
    assert!(message.contains("format version 1"), "what is refused is the version: {message}");
    image[4] = 2;
    write("later.fosm", &image);
    refused(folder, &["inspect", "later.fosm"], ["later.fosm", "version 2", "reads version 1"]);
    refused(folder, &["replay", "later.fosm", "no.csv"], ["later.fosm", "version 2", "reads version 1"]);

    write("later.json", br#"{ "schema": "fos-study/2" }"#);
    refused(folder, &["compare", "later.json"], ["later.json", "fos-study/2", r#"reads "fos-study/1""#]);

    let start = StartFrame { version: 2, period_s: 0.005, axes: HUB_AXES, quantities: "" };
    let start: Borrowed<'_> = Frame::Start(start);
    write("later.stream", encode(&start, &mut [0; 128]).expect("room"));
    let record = ["record", "later.stream", "-o", "log.csv"];
    refused(folder, &record, ["later.stream", "version 2", "reads version 1"]);
    assert!(!folder.join("log.csv").exists(), "nothing is written of it");
}
