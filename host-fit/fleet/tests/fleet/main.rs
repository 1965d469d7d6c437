//! Rows of devices, and the populations behind them.

mod degenerate_fleets;
mod drawn;
mod gathered;
mod of_logs;
mod population;
mod ship;
mod small_fleets;
mod stored_rows;
