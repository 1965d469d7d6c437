//! Tests of the device side through its public interface: hub, sample sources, streams, store.

mod alarm;
mod c_header;
mod fault_matrix;
mod fixed;
mod hub;
mod loggable;
#[path = "../models/mod.rs"]
mod models;
mod page;
mod sample_source;
mod store;
mod streams;
