//! Runs the command line in a folder.

use std::path::Path;
use std::process::{Command, Output};

fn host_fit(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fos")).current_dir(folder).args(arguments).output().expect("it starts")
}

/// Runs a command that must succeed; returns its standard output.
pub(crate) fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = host_fit(folder, arguments);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{arguments:?}\n{out}\n{err}");
    out.into_owned()
}

/// Runs a command that must succeed; returns its standard error.
pub(crate) fn stderr_of(folder: &Path, arguments: &[&str]) -> String {
    let output = host_fit(folder, arguments);
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}\n{err}");
    err
}

/// Runs a command that must fail with exit code `code`; returns its standard error.
pub(crate) fn fails(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = host_fit(folder, arguments);
    let out = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {out}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}
