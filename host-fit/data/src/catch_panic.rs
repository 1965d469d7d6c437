//! Turns panics of libraries on faulty input into errors.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Calls into a library. State changed by a failed call must not be used again. A requested stop is no panic and unwinds
/// further. Returns the message of a panic.
pub fn catch_panic<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    let outer = INSIDE.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    INSIDE.set(outer);
    result.map_err(|payload| match crate::interrupt::rethrow_stop(payload).downcast::<String>() {
        Ok(text) => *text,
        Err(payload) => {
            payload.downcast_ref::<&str>().copied().unwrap_or("an error without a text").to_owned()
        }
    })
}

/// Suppresses the announcement of caught panics from now on: the resulting error carries their message.
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
    fn panic_becomes_its_message() {
        assert_eq!(catch_panic(|| 7), Ok(7));
        assert_eq!(catch_panic(|| -> u8 { panic!("too {}", "long") }), Err("too long".to_owned()));
        assert_eq!(catch_panic(|| -> u8 { panic!("short") }), Err("short".to_owned()));
        assert!(!INSIDE.get());
    }
}
