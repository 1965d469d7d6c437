//! The sources of samples: over transcripts of their buses, over simulated sensors, and in front of a hub.

mod matrix;
mod simulated;
mod streams;
mod transcripts;
