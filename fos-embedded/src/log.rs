//! Log messages: through defmt with the feature `defmt` on the target, otherwise none.
//!
//! On a host there is no defmt logger, and a program with log messages would not link.

#[cfg(all(feature = "defmt", target_os = "none"))]
macro_rules! info {
    ($($message:tt)*) => { defmt::info!($($message)*) };
}

#[cfg(all(feature = "defmt", target_os = "none"))]
macro_rules! warn {
    ($($message:tt)*) => { defmt::warn!($($message)*) };
}

// the expressions count as used, without a warning

#[cfg(not(all(feature = "defmt", target_os = "none")))]
macro_rules! info {
    ($text:literal $(, $value:expr)* $(,)?) => {{ let _ = ($(&$value,)*); }};
}

#[cfg(not(all(feature = "defmt", target_os = "none")))]
macro_rules! warn {
    ($text:literal $(, $value:expr)* $(,)?) => {{ let _ = ($(&$value,)*); }};
}
