//! Early end of a long computation.
//!
//! Cooperative cancellation through a thread-local flag: the computing thread calls [`check`] in its long loops, and the
//! stack unwinds to [`interruptible`] once someone has [requested it](StopRequest::ask). So the numerical code need not
//! pass the request through every argument and return value, and partial results are dropped with the stack.

use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// A request to stop, settable from any thread.
#[derive(Debug, Clone, Default)]
pub struct StopRequest(Arc<AtomicBool>);

/// Reason why an interruptible computation gave no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interrupted {
    Stopped,
    /// A defect of this program.
    Panicked,
}

struct Unwound;

thread_local! {
    static WISH: RefCell<Option<StopRequest>> = const { RefCell::new(None) };
}

impl StopRequest {
    /// Requests a stop at the next check.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns true once a stop was requested.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Stops here if a stop of this thread's computation was requested; does nothing outside of one.
#[inline]
pub fn check() {
    counting::count();
    let asked = WISH.with_borrow(|wish| wish.as_ref().is_some_and(StopRequest::is_asked));
    if asked {
        // no panic message: this is no error
        panic::resume_unwind(Box::new(Unwound));
    }
}

/// Runs a computation that `stop` may end.
///
/// # Errors
///
/// The computation was stopped or panicked; the caller continues either way. Changes should be published only when
/// complete.
pub fn interruptible<T>(stop: &StopRequest, work: impl FnOnce() -> T) -> Result<T, Interrupted> {
    let outer = WISH.replace(Some(stop.clone()));
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    WISH.set(outer);
    result.map_err(|cause| match cause.is::<Unwound>() {
        true => Interrupted::Stopped,
        false => Interrupted::Panicked,
    })
}

/// Payload of a caught panic. Continues to unwind if it is a requested stop.
pub(crate) fn rethrow_stop(cause: Box<dyn std::any::Any + Send>) -> Box<dyn std::any::Any + Send> {
    if cause.is::<Unwound>() { panic::resume_unwind(cause) } else { cause }
}

/// Results of `work` for each item, in their order, computed on all cores. A stop of the calling thread's computation
/// stops these too.
pub fn in_parallel<T: Send, U: Send>(
    items: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> U + Sync,
) -> Vec<U> {
    let places: Vec<Place<T, U>> = items.into_iter().map(|item| Mutex::new((Some(item), None))).collect();
    on_all_cores(places.len(), &|index| {
        // no lock is held while it works
        let item = lock(&places[index]).0.take();
        let result = item.map(&work);
        lock(&places[index]).1 = result;
    });
    let results =
        places.into_iter().map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner).1);
    results.flatten().collect()
}

/// An item, and then its result.
type Place<T, U> = Mutex<(Option<T>, Option<U>)>;

fn lock<T>(place: &Mutex<T>) -> MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls `work` with each index below `n`. Not generic: the scheduler would be compiled for every closure, which took a sixth of
/// the program's compile time.
fn on_all_cores(n: usize, work: &(dyn Fn(usize) + Sync)) {
    let wish = WISH.with_borrow(Clone::clone);
    (0..n).into_par_iter().for_each(|index| {
        let outer = WISH.replace(wish.clone());
        // also when it unwinds: the thread goes on to other computations
        let _restored = Restored(outer);
        work(index);
    });
}

/// Restores the stop request of the computation that the thread was in before.
struct Restored(Option<StopRequest>);

impl Drop for Restored {
    fn drop(&mut self) {
        WISH.set(self.0.take());
    }
}

pub use counting::counted;

mod counting {
    use std::cell::Cell;

    use super::*;

    thread_local! {
        static STEPS_LEFT: Cell<Option<u64>> = const { Cell::new(None) };
    }

    /// Number of calls of [`check`] by a computation on this thread; `None` if it exceeds `most`, at which the
    /// computation is ended. Lets a test state without a clock that a search ends.
    pub fn counted(most: u64, work: impl FnOnce()) -> Option<u64> {
        STEPS_LEFT.set(Some(most));
        let result = panic::catch_unwind(AssertUnwindSafe(work));
        let left = STEPS_LEFT.take();
        match result {
            Ok(()) => left.map(|left| most - left),
            Err(cause) if cause.is::<Unwound>() => None,
            Err(cause) => panic::resume_unwind(cause),
        }
    }

    #[inline]
    pub(super) fn count() {
        if let Some(left) = STEPS_LEFT.get() {
            if left == 0 {
                panic::resume_unwind(Box::new(Unwound));
            }
            STEPS_LEFT.set(Some(left - 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn computation_stops_at_its_next_check() {
        let stop = StopRequest::default();
        let mut last = 0;
        let result = interruptible(&stop, || {
            for step in 0..10 {
                last = step;
                if step == 3 {
                    stop.ask();
                }
                check();
            }
        });
        assert_eq!((result, last), (Err(Interrupted::Stopped), 3));
        // requested, but outside a computation: nothing happens
        check();
        assert_eq!(interruptible(&StopRequest::default(), || 7), Ok(7));
    }

    #[test]
    fn parallel_work_stops_and_its_threads_continue() {
        let stop = StopRequest::default();
        let squares = interruptible(&stop, || in_parallel(0..100, |n| n * n));
        assert_eq!(squares, Ok((0..100).map(|n| n * n).collect()));
        let asked = interruptible(&stop, || {
            in_parallel(0..100, |n| {
                if n == 50 {
                    stop.ask();
                }
                let is_late = n >= 50;
                // ends only on request
                loop {
                    check();
                    if !is_late {
                        break;
                    }
                }
            })
        });
        assert_eq!(asked, Err(Interrupted::Stopped));
        assert_eq!(
            interruptible(&StopRequest::default(), || in_parallel(0..100, |_| check()).len()),
            Ok(100)
        );
        in_parallel(0..100, |_| check());
    }

    #[test]
    fn distinguishes_a_panic_from_a_stop() {
        let hook = panic::take_hook();
        panic::set_hook(Box::new(|_| {}));
        let result = interruptible(&StopRequest::default(), || panic!("on purpose"));
        panic::set_hook(hook);
        assert_eq!(result, Err::<(), _>(Interrupted::Panicked));
    }
}
