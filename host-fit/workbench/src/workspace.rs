//! Open studies.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::folders::Folders;
use super::study::Study;
use super::task::{LogFiles, Open};
use super::view::Entry;
use fos_data::file::FileError;
use fos_data::file::compare_and_swap::FileVersion;
use fos_data::recording::LoadOptions;
use fos_diagnose::effects::Library;
use fos_diagnose::study::Study as StudyFile;

/// Largest number of open studies: each keeps its logs in memory.
const MAX_OPEN_STUDIES: usize = 12;

/// Largest size of a stored study, bytes; those of six axes with several effects have 300 kB.
const LARGEST_STUDY: u64 = 32 << 20;

/// Open studies, with their common folders and library.
pub(super) struct Workspace {
    pub(super) folders: Folders,
    pub(super) library: Arc<Library>,
    studies: Mutex<BTreeMap<u64, Arc<Study>>>,
    next: AtomicU64,
}

impl Workspace {
    /// Restores the studies that an earlier server stored. A stored study reads its logs when it is first shown; one
    /// that cannot be used shows the reason.
    pub(super) fn new(folders: Folders, library: Library) -> Result<Self, FileError> {
        let library = Arc::new(library);
        let (stored, next) = folders.stored_studies()?;
        let stored = stored.into_iter().map(|(id, file)| (id, restored(id, &file, &folders, &library)));
        let studies = Mutex::new(stored.collect());
        Ok(Self { folders, library, studies, next: AtomicU64::new(next) })
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, Arc<Study>>> {
        self.studies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Opens a study; its logs are read in the background.
    pub(super) fn open(&self, open: Open) -> Result<u64, String> {
        let mut studies = self.lock();
        if studies.len() >= MAX_OPEN_STUDIES {
            return Err(format!("{MAX_OPEN_STUDIES} studies are open already\nhelp: close one"));
        }
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let file = FileVersion::now(&self.folders.file_of_study(id)).map_err(|error| error.to_string())?;
        let study = Study::new(id, open.name(), Ok(open), file, Arc::clone(&self.library));
        study.begin();
        studies.insert(id, study);
        Ok(id)
    }

    /// Opens a study of these logs, or the stored one of the same logs, which becomes the latest.
    pub(super) fn open_or_resume(&self, files: LogFiles) -> Result<u64, String> {
        // a stored study does not record how strictly its logs were read
        let as_stored =
            LogFiles { read: LoadOptions { strict: false, ..files.read.clone() }, ..files.clone() };
        let mut studies = self.lock();
        let Some(old) =
            studies.values().find(|study| study.files().as_ref() == Some(&as_stored)).map(|study| study.id)
        else {
            drop(studies);
            return self.open(Open::Logs(files));
        };
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let (from, to) = (self.folders.file_of_study(old), self.folders.file_of_study(id));
        fs::rename(&from, &to).map_err(|error| FileError::writing(&to)(error).to_string())?;
        studies.remove(&old);
        studies.insert(id, restored(id, &to, &self.folders, &self.library));
        Ok(id)
    }

    /// Returns a study; a stored one begins to read its logs.
    pub(super) fn study(&self, id: u64) -> Result<Arc<Study>, String> {
        let study = self.lock().get(&id).cloned().ok_or_else(|| not_open(id))?;
        study.begin();
        Ok(study)
    }

    /// Closes a study and deletes its file.
    pub(super) fn close(&self, id: u64) -> Result<(), String> {
        self.lock().remove(&id).ok_or_else(|| not_open(id))?.close()
    }

    pub(super) fn entries(&self) -> Vec<Entry> {
        self.lock().values().map(|study| study.entry()).collect()
    }
}

fn not_open(id: u64) -> String {
    format!("there is no study {id}\nhelp: it was closed; open its logs again")
}

/// A stored study, or the reason why it cannot be used.
fn restored(id: u64, file: &Path, folders: &Folders, library: &Arc<Library>) -> Arc<Study> {
    let name = || file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (name, open, version) = match read(file, folders) {
        Ok((stored, version)) => {
            let open = Open::Stored(Arc::new(stored));
            let is_example =
                open.files().is_some_and(|files| Path::new(&files.log).starts_with(folders.example()));
            let name = if is_example { Open::Example(folders.example()).name() } else { open.name() };
            (name, Ok(open), version)
        }
        Err(reason) => (name(), Err(reason), FileVersion::of(file, &[])),
    };
    Study::new(id, name, open, version, Arc::clone(library))
}

fn read(file: &Path, folders: &Folders) -> Result<(StudyFile, FileVersion), String> {
    let in_text = |error: &dyn std::fmt::Display| error.to_string();
    let bytes = fs::metadata(file).map_err(|error| in_text(&FileError::reading(file)(error)))?.len();
    if bytes > LARGEST_STUDY {
        return Err(format!(
            "{}: {bytes} bytes are no study of the workbench\nhelp: close it here",
            file.display()
        ));
    }
    let (stored, version) = StudyFile::read_to_change(file).map_err(|error| in_text(&error))?;
    let refinement = stored.refinements.first().ok_or_else(|| {
        format!("{}: names no log to explain\nhelp: close it here, and open the log again", file.display())
    })?;
    let logs = &refinement.logs;
    for source in [Some(&logs.log), logs.reference.as_ref(), logs.evaluation.as_ref()].into_iter().flatten() {
        folders.permitted(&source.path)?;
    }
    Ok((stored, version))
}
