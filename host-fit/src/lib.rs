//! Fits models of inertial sensor error with Fast Orthogonal Search, compares and exports them.
//!
//! Data flow one way: [`recording`] → [`candidates`] → [`moments`] → [`fit`] → [`evaluate`] → [`compare`] → [`study`]
//! → [`export`], [`replay`], [`cli`]. What is fitted here runs on fos-core, also where it is judged.
#![forbid(unsafe_code)]
// what is printed goes through cli/output.rs, which shows what would do something to a terminal
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod batch;
pub mod bench;
pub mod calibration;
pub mod candidates;
pub mod case;
pub mod cli;
pub mod compare;
pub mod contained;
pub mod dependence;
pub mod diagnose;
pub mod effects;
pub mod evaluate;
pub mod examine;
pub mod export;
pub mod feed;
pub mod figures;
pub mod file;
pub mod fit;
pub mod grow;
pub mod hub_log;
mod inputs;
pub mod interrupt;
pub mod model;
pub mod moments;
mod outside;
pub mod paper;
pub mod plots;
pub mod pose;
mod program;
pub mod record;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rest;
pub mod signal;
pub mod simulate;
pub mod study;
mod text;
pub mod unchanged;
mod versioned;
pub mod workbench;

#[cfg(test)]
mod reference;
#[cfg(test)]
mod searches_end;
