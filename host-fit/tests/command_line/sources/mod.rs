//! Source files of the program and of the crates under it.

use std::fs;
use std::path::{Path, PathBuf};

/// Rust files under these folders of `host-fit/`, each with its relative path and its text.
pub(crate) fn sources(folders: &[&str]) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    folders.iter().for_each(|folder| collect(&root.join(folder), &mut files));
    let is_rust = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == "rs");
    let named = |path: &PathBuf| {
        let name = path.strip_prefix(root).expect("below").to_string_lossy().into_owned();
        (name, fs::read_to_string(path).expect("there"))
    };
    files.iter().filter(is_rust).map(named).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => collect(&path, files),
            false => files.push(path),
        }
    }
}
