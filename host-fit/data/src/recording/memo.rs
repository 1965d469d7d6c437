//! Cache of results computed from a recording, stored with it.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

type Found = HashMap<TypeId, Arc<dyn Any + Send + Sync>>;

/// One value of each type. A derived recording starts empty; a clone copies the cache.
#[derive(Default)]
pub(super) struct Memo(Mutex<Found>);

impl Memo {
    /// Result of `find`, computed once for each type `T`.
    pub(super) fn cached<T: Any + Send + Sync>(&self, find: impl FnOnce() -> T) -> Arc<T> {
        let known =
            |found: &Found| found.get(&TypeId::of::<T>()).cloned().and_then(|any| any.downcast().ok());
        let before = known(&self.found());
        before.unwrap_or_else(|| {
            // without the lock: `find` takes long, and may use the cache itself
            let new = Arc::new(find());
            let mut found = self.found();
            known(&found).unwrap_or_else(|| {
                found.insert(TypeId::of::<T>(), Arc::<T>::clone(&new));
                new
            })
        })
    }

    fn found(&self) -> MutexGuard<'_, Found> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clone for Memo {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.found().clone()))
    }
}

impl std::fmt::Debug for Memo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Memo").field(&self.found().len()).finish()
    }
}
