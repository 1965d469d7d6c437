//! x
pub mod figures;
pub mod signal;
