//! What others have found out about a recording, kept with it.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::Recording;

type Found = HashMap<TypeId, Arc<dyn Any + Send + Sync>>;

/// One value of each type. A recording that is made of another begins with none, a clone with what the other has.
#[derive(Default)]
pub(super) struct Memo(Mutex<Found>);

impl Recording {
    /// What `find` makes of the recording, which is asked once for each type `T`.
    pub(crate) fn once<T: Any + Send + Sync>(&self, find: impl FnOnce(&Self) -> T) -> Arc<T> {
        let known =
            |found: &Found| found.get(&TypeId::of::<T>()).cloned().and_then(|any| any.downcast().ok());
        let before = known(&self.memo.found());
        before.unwrap_or_else(|| {
            // without the lock: it takes long, and may ask for others
            let new = Arc::new(find(self));
            let mut found = self.memo.found();
            known(&found).unwrap_or_else(|| {
                found.insert(TypeId::of::<T>(), Arc::<T>::clone(&new));
                new
            })
        })
    }
}

impl Memo {
    fn found(&self) -> std::sync::MutexGuard<'_, Found> {
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

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Source};
    use super::*;

    #[test]
    fn it_is_found_once_and_anew_where_a_column_is_another() {
        let columns = vec![("gx_rads".to_owned(), vec![1.0, 2.0, 3.0])];
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        let log = Recording::from_columns(Source::made_by("test"), columns, &options).unwrap();
        let sum = |log: &Recording| log.once(|log| log.channels()[0].values.iter().sum::<f64>());
        assert_eq!(*sum(&log), 6.0);
        assert_eq!(*log.once(|_| -> f64 { unreachable!("it is known") }), 6.0);
        assert_eq!(*log.clone().once(|_| -> f64 { unreachable!("a clone knows it") }), 6.0);
        assert_eq!(*sum(&log.with_values("gx_rads", vec![1.0; 3])), 3.0);
        assert_eq!(*sum(&log.first_rows(2)), 3.0);
        assert_eq!(*log.with_rests(vec![true; 3], Vec::new()).once(|_| 7.0), 7.0);
        assert_eq!(*sum(&Recording::join(vec![log.clone(), log]).unwrap()), 12.0);
    }
}
