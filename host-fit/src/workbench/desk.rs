//! All studies that are open.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::folders::Folders;
use super::study::Study;
use super::task::Open;
use super::told::Entry;
use fos_diagnose::effects::Library;

/// Studies that are open at once, at most: each keeps its logs in memory.
const MOST: usize = 12;

/// All studies, and what they share.
pub(super) struct Desk {
    pub(super) folders: Folders,
    pub(super) library: Arc<Library>,
    studies: Mutex<BTreeMap<u64, Arc<Study>>>,
    next: AtomicU64,
}

impl Desk {
    pub(super) fn new(folders: Folders, library: Library) -> Self {
        Self { folders, library: Arc::new(library), studies: Mutex::default(), next: AtomicU64::new(1) }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, Arc<Study>>> {
        self.studies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Opens a study; reading goes on behind.
    ///
    /// # Errors
    ///
    /// Too many are open.
    pub(super) fn open(&self, open: Open) -> Result<u64, String> {
        let mut studies = self.lock();
        if studies.len() >= MOST {
            return Err(format!("{MOST} studies are open already\nhelp: close one"));
        }
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        studies.insert(id, Study::open(id, open, Arc::clone(&self.library)));
        Ok(id)
    }

    pub(super) fn study(&self, id: u64) -> Result<Arc<Study>, String> {
        let found = self.lock().get(&id).cloned();
        found.ok_or_else(|| {
            format!("there is no study {id}\nhelp: it was closed, or the program was started anew")
        })
    }

    pub(super) fn close(&self, id: u64) -> Result<(), String> {
        let study = self.study(id)?;
        self.lock().remove(&id);
        study.close();
        Ok(())
    }

    pub(super) fn entries(&self) -> Vec<Entry> {
        self.lock().values().map(|study| study.entry()).collect()
    }
}
