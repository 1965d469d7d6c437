//! Tests of the sample sources: with bus transcripts, with simulated sensors, and with a hub.

mod matrix;
mod moments;
mod simulated;
mod streams;
mod transcripts;
