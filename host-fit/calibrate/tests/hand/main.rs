//! Calibration of simulated and real devices, from outside.

mod coverage;
mod device;
mod exports;
mod properties;
mod real_logs;
mod refusals;
mod rivals;
mod turntable;
