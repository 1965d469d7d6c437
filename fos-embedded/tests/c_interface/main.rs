//! The C interface, called from Rust.

mod c_api;
mod c_store;
mod c_unit;
#[path = "../models/mod.rs"]
mod models;
