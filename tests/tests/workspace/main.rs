//! Host and device together: the same numbers on both sides, and stored files that still load.

mod c_source;
mod compatibility;
mod exported_model;
mod noise_accuracy;
mod noise_of_a_log;
mod path;
mod reference_series;
mod refusal;
mod rust_source;
mod telemetry;
mod test_vector;
