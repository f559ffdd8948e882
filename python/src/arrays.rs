//! Arrays of Python made of what was computed.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// `values` as an array of `shape`, in the order of rows.
pub fn array<'py, T: Element, const N: usize>(
    py: Python<'py>,
    values: Vec<T>,
    shape: [usize; N],
) -> PyResult<Bound<'py, PyAny>>
where
    [usize; N]: numpy::ndarray::IntoDimension,
{
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}
