//! Fits and diagnoses on simulated logs, through the interfaces of the libraries.

mod cases;
mod every_effect;
mod fitted_rows;
mod missing_cells;
mod real_effects;
mod sanity;
mod search_termination;
mod two_poses;
