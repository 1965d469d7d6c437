//! NumPy arrays as columns of a log, and back.
//!
//! The engine owns its columns and corrects them while reading (rows without a timestamp are dropped, units converted),
//! so a column of any type is copied once, as 64-bit floats. Results of the engine are handed over without a copy.

use numpy::{Element, PyReadonlyArray1};
use pyo3::prelude::*;

/// A column of numbers, of any type and stride of NumPy.
#[derive(FromPyObject)]
pub(crate) enum Column<'py> {
    F64(PyReadonlyArray1<'py, f64>),
    F32(PyReadonlyArray1<'py, f32>),
    I64(PyReadonlyArray1<'py, i64>),
    I32(PyReadonlyArray1<'py, i32>),
    I16(PyReadonlyArray1<'py, i16>),
    U64(PyReadonlyArray1<'py, u64>),
    U32(PyReadonlyArray1<'py, u32>),
    U16(PyReadonlyArray1<'py, u16>),
    U8(PyReadonlyArray1<'py, u8>),
    Bool(PyReadonlyArray1<'py, bool>),
}

impl Column<'_> {
    /// Copies the values.
    pub(crate) fn to_vec(&self) -> Vec<f64> {
        match self {
            // A plain copy if the values are contiguous.
            Self::F64(array) => match array.as_slice() {
                Ok(values) => values.to_vec(),
                Err(_) => converted(array, |value| value),
            },
            Self::F32(array) => converted(array, f64::from),
            // A timestamp in nanoseconds is rounded to 53 bits, as in a text file.
            Self::I64(array) => converted(array, |value| value as f64),
            Self::I32(array) => converted(array, f64::from),
            Self::I16(array) => converted(array, f64::from),
            Self::U64(array) => converted(array, |value| value as f64),
            Self::U32(array) => converted(array, f64::from),
            Self::U16(array) => converted(array, f64::from),
            Self::U8(array) => converted(array, f64::from),
            Self::Bool(array) => converted(array, |value| f64::from(u8::from(value))),
        }
    }
}

fn converted<T: Element + Copy>(array: &PyReadonlyArray1<'_, T>, convert: impl Fn(T) -> f64) -> Vec<f64> {
    array.as_array().iter().map(|value| convert(*value)).collect()
}
