//! Files that may be opened: logs and populations below the folders named at start, and files dropped on the page.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use fos_data::file::{FileError, make_folder};
use fos_data::recording::may_be_log;
use fos_fleet::rows_beside;

/// Largest depth of listed folders.
const DEEPEST: usize = 3;

/// Folder of stored studies within the own one.
const STUDIES: &str = "studies";

/// Begin of the names of files with the true error of a simulated case, which are no logs.
const TRUTH: &str = "truth_";

/// Largest number of listed logs.
const LISTED: usize = 500;

/// Folders that logs are read from, and the one that dropped files and the example are written to.
#[derive(Debug, Clone)]
pub struct Folders {
    readable: Vec<PathBuf>,
    own: PathBuf,
}

/// A log that may be opened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Listed {
    /// Path by which the log is opened.
    pub(super) path: String,
    bytes: u64,
}

impl Folders {
    /// Takes the folders `readable`, named by the user, and `own`, which is created if it does not exist.
    ///
    /// # Errors
    ///
    /// A folder does not exist, or the own one cannot be created.
    pub fn new(readable: &[PathBuf], own: &Path) -> Result<Self, FileError> {
        make_folder(own)?;
        let mut all: Vec<PathBuf> = Vec::new();
        for folder in readable.iter().map(PathBuf::as_path).chain([own]) {
            let folder = fs::canonicalize(folder).map_err(FileError::reading(folder))?;
            if !all.contains(&folder) {
                all.push(folder);
            }
        }
        Ok(Self { readable: all, own: own.to_owned() })
    }

    /// Returns the file of this path if it may be read; links and dots are resolved before the check.
    pub(super) fn permitted(&self, path: &str) -> Result<PathBuf, String> {
        let elsewhere = || {
            let folders: Vec<String> =
                self.readable.iter().map(|folder| folder.display().to_string()).collect();
            format!(
                "{path}: not a file in one of the folders that may be read: {}\nhelp: drop the file on the page, or start `fos serve FOLDER`",
                folders.join(", ")
            )
        };
        let found = fs::canonicalize(path).map_err(|_| elsewhere())?;
        if !self.readable.iter().any(|folder| found.starts_with(folder)) || !found.is_file() {
            return Err(elsewhere());
        }
        // unchanged, so that the command lines on the page can be used as they are
        Ok(PathBuf::from(path))
    }

    /// Lists the logs that may be opened, by their extensions.
    pub(super) fn logs(&self) -> Vec<Listed> {
        let is_log = |name: &str| may_be_log(name) && !name.starts_with(TRUTH);
        self.listed(&|path| path.file_name().is_some_and(|name| is_log(&name.to_string_lossy())))
    }

    /// Lists the logs of that name with any extension; the name may include folders: `2026-W9/013`.
    pub(super) fn logs_named(&self, name: &str) -> Vec<Listed> {
        let mut logs = self.listed(&|path| path.with_extension("").ends_with(name));
        logs.retain(|log| may_be_log(&log.path));
        logs
    }

    /// Lists the populations that may be opened: files whose rows lie next to them.
    pub(super) fn populations(&self) -> Vec<Listed> {
        self.listed(&|path| rows_beside(path).is_file())
    }

    fn listed(&self, is_wanted: &dyn Fn(&Path) -> bool) -> Vec<Listed> {
        let mut found = Vec::new();
        let current = fs::canonicalize(".").unwrap_or_default();
        for folder in &self.readable {
            // shown as one would type it
            let shown = folder.strip_prefix(&current).unwrap_or(folder);
            let shown = if shown.as_os_str().is_empty() { Path::new(".") } else { shown };
            list(shown, 0, is_wanted, &mut found);
        }
        found.sort_by(|a: &Listed, b| a.path.cmp(&b.path));
        found.dedup();
        found
    }

    /// Returns the paths for a dropped file of this name, of which the first that is free on arrival is used. Only the
    /// last part of the name counts.
    ///
    /// # Errors
    ///
    /// The name is not a file name, or the folder cannot be created.
    pub(super) fn for_upload(
        &self,
        name: &str,
    ) -> Result<impl Iterator<Item = PathBuf> + Send + use<>, String> {
        let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
        let plain: String = last
            .chars()
            .map(|letter| if letter.is_alphanumeric() || "._-".contains(letter) { letter } else { '_' })
            .collect();
        if plain.trim_matches('.').is_empty() || plain.len() > 200 {
            return Err(format!("{name:?} is no file name\nhelp: rename the file"));
        }
        let folder = self.own.join("dropped");
        make_folder(&folder).map_err(|error| error.to_string())?;
        // an existing file of that name may be the log of a study
        let names = (1..).map(move |n| if n == 1 { plain.clone() } else { format!("{n}_{plain}") });
        Ok(names.map(move |name| folder.join(name)))
    }

    /// Returns the files of the stored studies with their numbers, and the number of the next study.
    pub(super) fn stored_studies(&self) -> Result<(Vec<(u64, PathBuf)>, u64), FileError> {
        let folder = self.own.join(STUDIES);
        make_folder(&folder)?;
        let number = |path: &Path| -> Option<u64> {
            let is_study = path.extension().is_some_and(|ending| ending == "json") && path.is_file();
            path.file_stem().filter(|_| is_study)?.to_str()?.parse().ok()
        };
        let entries = fs::read_dir(&folder).map_err(FileError::reading(&folder))?;
        let mut found: Vec<(u64, PathBuf)> =
            entries.flatten().filter_map(|entry| Some((number(&entry.path())?, entry.path()))).collect();
        found.sort_unstable();
        let next = found.last().map_or(1, |(last, _)| last.saturating_add(1));
        Ok((found, next))
    }

    /// File in which the study of this number is stored.
    pub(super) fn file_of_study(&self, id: u64) -> PathBuf {
        self.own.join(STUDIES).join(format!("{id}.json"))
    }

    /// Folder of the built-in example.
    pub(super) fn example(&self) -> PathBuf {
        self.own.join("example")
    }
}

fn list(folder: &Path, depth: usize, is_wanted: &dyn Fn(&Path) -> bool, found: &mut Vec<Listed>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        let Ok(kind) = entry.file_type() else { continue };
        if found.len() >= LISTED || name.starts_with('.') {
            continue;
        }
        if kind.is_dir() && depth < DEEPEST && name != "target" && name != "node_modules" {
            list(&path, depth + 1, is_wanted, found);
        } else if kind.is_file() && is_wanted(&path) {
            let bytes = entry.metadata().map_or(0, |metadata| metadata.len());
            let path = path.strip_prefix(".").unwrap_or(&path).display().to_string();
            found.push(Listed { path, bytes });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_logs_below_the_folders_may_be_read() {
        let world = tempfile::tempdir().unwrap();
        let (open, closed) = (world.path().join("open"), world.path().join("closed"));
        fs::create_dir_all(open.join("deeper")).unwrap();
        fs::create_dir_all(&closed).unwrap();
        for file in ["open/a.csv", "open/deeper/b.parquet", "closed/secret.csv"] {
            fs::write(world.path().join(file), "x").unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(closed.join("secret.csv"), open.join("link.csv")).unwrap();
        let folders = Folders::new(std::slice::from_ref(&open), &open.join("own")).unwrap();
        let may = |path: &Path| folders.permitted(&path.display().to_string()).is_ok();
        assert!(may(&open.join("a.csv")) && may(&open.join("deeper/b.parquet")));
        assert!(may(&open.join("deeper/../a.csv")));
        assert!(!may(&closed.join("secret.csv")));
        assert!(!may(&open.join("../closed/secret.csv")), "dots lead out of it");
        #[cfg(unix)]
        assert!(!may(&open.join("link.csv")), "a link leads out of it");
        assert!(!may(&open) && !may(&open.join("none.csv")));
        let listed: Vec<String> = folders.logs().into_iter().map(|log| log.path).collect();
        assert_eq!(listed.len(), 2, "{listed:?}");
    }

    #[test]
    fn a_dropped_file_cannot_choose_its_folder() {
        let own = tempfile::tempdir().unwrap();
        let folders = Folders::new(&[], own.path()).unwrap();
        let at = |name: &str| folders.for_upload(name).map(|mut names| names.next().unwrap());
        let dropped = own.path().join("dropped");
        assert_eq!(at("unit.csv").unwrap(), dropped.join("unit.csv"));
        assert_eq!(at("../../etc/passwd").unwrap(), dropped.join("passwd"));
        assert_eq!(at("C:\\logs\\unit 1.csv").unwrap(), dropped.join("unit_1.csv"));
        assert!(at("..").is_err() && at("").is_err() && at("a/").is_err());
    }
}
