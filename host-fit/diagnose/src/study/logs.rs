//! Location of the logs of a study: at the path of the fit, or at the same place relative to the study, so that study
//! and logs can be moved together.

use std::fs;
use std::path::{Component, Path, PathBuf};

use super::Study;
use fos_data::file::{folder_of, followed, name_of};
use fos_data::recording::{LoadOptions, Recording, RecordingError, Source, load};

/// Error of finding or reading a log of a study.
#[derive(Debug, thiserror::Error)]
pub enum LogAgainError {
    /// The log exists but cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{log}: the log that {} names is not there; looked for as {}\nhelp: put it back, or beside the study, or name another log in the command",
        study.display(),
        in_words(tried)
    )]
    NotThere { log: String, study: PathBuf, tried: Vec<PathBuf> },
    #[error(
        "{}: not the log that {} was made with: its digest is {found}, the study's is {named}\nhelp: put that log back, or name another one in the command",
        log.display(),
        study.display()
    )]
    Another { log: PathBuf, study: PathBuf, found: String, named: String },
}

fn in_words(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Reads a log that the study at `study` refers to.
pub fn load_again(source: &Source, study: &Path, read: &LoadOptions) -> Result<Recording, LogAgainError> {
    let tried = places(source, study);
    let mut first_problem = None;
    // a pipe cannot be read again
    for place in tried.iter().filter(|place| place.is_file() || place.is_dir()) {
        let problem = match load(place, read) {
            Ok(recording) => match recording.sources.first() {
                Some(found) if found == source => return Ok(recording),
                found => LogAgainError::Another {
                    log: place.clone(),
                    study: study.to_owned(),
                    found: found.map_or_else(String::new, |found| found.sha256.clone()),
                    named: source.sha256.clone(),
                },
            },
            Err(error) => error.into(),
        };
        first_problem.get_or_insert(problem);
    }
    let (log, study) = (source.path.clone(), study.to_owned());
    Err(first_problem.unwrap_or(LogAgainError::NotThere { log, study, tried }))
}

/// Paths where a log may be, the most likely first; the digest decides.
fn places(source: &Source, study: &Path) -> Vec<PathBuf> {
    let given = PathBuf::from(&source.path);
    let study = followed(study);
    let folder = folder_of(&study);
    let mut places = vec![given.clone()];
    let seen_from_study = source.from_study.as_ref().map(PathBuf::from);
    for path in seen_from_study.into_iter().chain([given, name_of(&source.path).into()]) {
        let place = folder.join(path);
        if !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

impl Study {
    /// Loads the logs that the study was fitted to.
    pub fn fitted_log<E: From<RecordingError>>(
        &self,
        load: impl FnMut(&Source) -> Result<Recording, E>,
    ) -> Result<Recording, E> {
        let logs: Vec<Recording> = self.data.sources.iter().map(load).collect::<Result<_, E>>()?;
        Ok(Recording::join(logs)?)
    }

    /// Stores the paths of the logs relative to the study's future location. Paths of logs that were not read in this
    /// run are unchanged.
    pub(super) fn note_places(&mut self, study: &Path) {
        let study = followed(study);
        let Ok(folder) = fs::canonicalize(folder_of(&study)) else { return };
        let grown = self.refinements.iter_mut().map(|refinement| &mut refinement.logs);
        let grown =
            grown.flat_map(|logs| [Some(&mut logs.log), logs.reference.as_mut(), logs.evaluation.as_mut()]);
        for source in self.data.sources.iter_mut().chain(grown.flatten()) {
            let found = source.found.as_ref().and_then(|found| relative(&folder, found));
            if let Some(path) = found {
                source.from_study = Some(path.to_string_lossy().into_owned());
            }
        }
    }
}

/// Returns the relative path from a folder to a file, both absolute; `None` if they have no common root.
fn relative(folder: &Path, file: &Path) -> Option<PathBuf> {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (folder.components().collect(), file.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    (common > 0).then(|| {
        let up = from[common..].iter().map(|_| Component::ParentDir);
        up.chain(to[common..].iter().copied()).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_path_goes_up_and_down() {
        for (folder, file, way) in [
            ("/a/b", "/a/b/log.csv", "log.csv"),
            ("/a/b", "/a/b/logs/log.csv", "logs/log.csv"),
            ("/a/b/c", "/a/logs/log.csv", "../../logs/log.csv"),
            ("/", "/log.csv", "log.csv"),
        ] {
            assert_eq!(relative(Path::new(folder), Path::new(file)), Some(PathBuf::from(way)));
        }
        assert_eq!(relative(Path::new("a"), Path::new("/b")), None);
    }
}
