//! Columns of NumPy as columns of a log, and back.
//!
//! The engine owns its columns and corrects them while it reads (rows without a stamp are dropped, units converted), so a
//! column is copied once on its way in, whatever its type: as 64-bit floats. What the engine has computed for Python is
//! handed over as it is.

use numpy::{Element, PyReadonlyArray1};
use pyo3::prelude::*;

/// A column of numbers, in any type and stride that NumPy has it in.
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
    /// Its values.
    pub(crate) fn to_vec(&self) -> Vec<f64> {
        match self {
            // a plain copy where the values lie side by side
            Self::F64(array) => match array.as_slice() {
                Ok(values) => values.to_vec(),
                Err(_) => converted(array, |value| value),
            },
            Self::F32(array) => converted(array, f64::from),
            // a stamp in nanoseconds loses what 53 bits do not hold, as it does in a file of text
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
