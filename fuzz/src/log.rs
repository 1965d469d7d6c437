//! Files of logs.

use std::path::Path;
use std::sync::LazyLock;

use fos_data::catch_panic::announce_no_caught_panic;
use fos_data::recording::{ColumnMap, LoadOptions, load, preview};
use tempfile::TempDir;

/// Folder of the inputs of this process, made once.
pub static FOLDER: LazyLock<TempDir> = LazyLock::new(folder);

/// Called before the first input; otherwise a caught panic would end the fuzzer.
pub fn init() {
    announce_no_caught_panic();
}

/// A folder in memory, if possible.
pub fn folder() -> TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    made.expect("a folder for the inputs")
}

/// Reads a file with these bytes in all supported ways. An accepted log must be usable: columns of one length, finite
/// time, segments within; an error must name the file.
pub fn read(name: &str, bytes: &[u8]) {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("the input is written");
    let mapped = ColumnMap::from_specs(["t_s=time", "gx_rads=1:dps"]).expect("a map");
    for columns in [ColumnMap::default(), mapped] {
        match load(&path, &LoadOptions { columns, ..LoadOptions::default() }) {
            Ok(log) => {
                let rows = log.n_rows();
                assert!(log.channels().iter().all(|channel| channel.values.len() == rows));
                assert!(log.time_s.iter().all(|time| time.is_finite()));
                for segment in &log.segments {
                    assert!(segment.rows.start < segment.rows.end && segment.rows.end <= rows);
                }
                let _ = log.still_rows();
            }
            Err(error) => refused(name, &error.to_string()),
        }
    }
    if let Err(error) = preview(&path, &ColumnMap::default()) {
        refused(name, &error.to_string());
    }
}

/// Errors must name the file and a remedy.
fn refused(name: &str, error: &str) {
    assert!(error.contains(name) && error.contains("\nhelp: "), "{error}");
}
