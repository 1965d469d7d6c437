//! Tests of the evaluator through its public interface.

mod align;
mod bounded;
mod coasts;
mod fixed_point;
mod image;
mod missing_cells;
mod model;
mod monitor;
mod prediction;
mod robustness;
mod stillness;
mod together;
mod unit_image;
