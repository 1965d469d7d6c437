//! The device side.
#![no_std]
