//! Libraries that panic on what they are given, and should say an error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Calls into a library. What the call changes is not to be used again if it fails. A computation that is to stop stops: that is no panic.
///
/// # Errors
///
/// What the library said when it panicked.
pub fn catch_panic<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    let outer = INSIDE.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    INSIDE.set(outer);
    result.map_err(|payload| match crate::interrupt::not_a_stop(payload).downcast::<String>() {
        Ok(text) => *text,
        Err(payload) => {
            payload.downcast_ref::<&str>().copied().unwrap_or("an error without a text").to_owned()
        }
    })
}

/// From now on a panic that is caught is not announced: the error that comes of it says what it said.
pub fn announce_no_caught_panic() {
    let announce = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        if !INSIDE.get() {
            announce(panic);
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_what_it_said() {
        assert_eq!(catch_panic(|| 7), Ok(7));
        assert_eq!(catch_panic(|| -> u8 { panic!("too {}", "long") }), Err("too long".to_owned()));
        assert_eq!(catch_panic(|| -> u8 { panic!("short") }), Err("short".to_owned()));
        assert!(!INSIDE.get());
    }
}
