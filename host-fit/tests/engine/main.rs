//! Fits and diagnoses on simulated logs, through the interfaces of the libraries.

mod cases;
mod every_effect;
mod fitted_rows;
mod glance;
mod missing_cells;
mod real_effects;
mod searches_end;
mod two_poses;
