//! Log messages: defmt's with the feature of that name, on the target; elsewhere nothing.
//!
//! On a host there is nothing that takes them, and a program with one would not link.

#[cfg(all(feature = "defmt", target_os = "none"))]
macro_rules! info {
    ($($message:tt)*) => { defmt::info!($($message)*) };
}

#[cfg(all(feature = "defmt", target_os = "none"))]
macro_rules! warn {
    ($($message:tt)*) => { defmt::warn!($($message)*) };
}

// the values count as used

#[cfg(not(all(feature = "defmt", target_os = "none")))]
macro_rules! info {
    ($text:literal $(, $value:expr)* $(,)?) => {{ let _ = ($(&$value,)*); }};
}

#[cfg(not(all(feature = "defmt", target_os = "none")))]
macro_rules! warn {
    ($text:literal $(, $value:expr)* $(,)?) => {{ let _ = ($(&$value,)*); }};
}
