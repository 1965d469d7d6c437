//! x

pub mod recording;
