//! Cache shared by all threads.

use std::borrow::Borrow;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Values by key. Two threads that miss the same key at once may both compute it.
#[derive(Debug)]
pub(crate) struct Memo<K, V>(Mutex<HashMap<K, V>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Eq + Hash, V: Clone> Memo<K, V> {
    /// Returns the cached value of `key`.
    pub(crate) fn get<Q: Eq + Hash + ?Sized>(&self, key: &Q) -> Option<V>
    where
        K: Borrow<Q>,
    {
        self.lock().get(key).cloned()
    }

    pub(crate) fn insert(&self, key: K, value: V) -> V {
        self.lock().insert(key, value.clone());
        value
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<K, V>> {
        // the map is consistent even if another thread panicked
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
