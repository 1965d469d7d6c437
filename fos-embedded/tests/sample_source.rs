//! The sources of samples: over transcripts of their buses, over simulated sensors, and in front of a hub.

#[path = "sample_source/matrix.rs"]
mod matrix;
mod page;
#[path = "sample_source/simulated.rs"]
mod simulated;
#[path = "sample_source/streams.rs"]
mod streams;
#[path = "sample_source/transcripts.rs"]
mod transcripts;
