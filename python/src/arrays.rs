//! NumPy arrays that look into memory of the library, and arrays of users that are read, checked.

#![allow(unsafe_code)]

use crate::failure::Failure;
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An array of `rows` × `columns` that looks into `data`, which `owner` keeps alive and never changes. It is read-only, and
/// NumPy does not let it be made writeable, as its owner lends no writeable memory.
pub fn view<'py, T: Element>(
    owner: &Bound<'py, PyAny>,
    data: &[T],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let rows = data.len() / columns.max(1);
    let shaped = ArrayView2::from_shape((rows, columns), &data[..rows * columns]);
    let shaped = shaped.map_err(|e| Failure::value(e.to_string()))?;
    // SAFETY: `owner` is the base of the array, so it lives as long; it is frozen, and its vectors are never changed.
    let array = unsafe { PyArray2::borrow_from_array(&shaped, owner.clone()) };
    let options = PyDict::new(owner.py());
    options.set_item("write", false)?;
    array.call_method("setflags", (), Some(&options))?;
    Ok(array)
}

/// What an array must be.
pub struct Expected {
    /// Its name in messages.
    pub name: &'static str,
    /// Its columns.
    pub columns: usize,
    /// The dtype that it is read as.
    pub dtype: &'static str,
    /// Kinds of dtypes that are taken: letters of `numpy.dtype.kind`.
    pub kinds: &'static str,
}

/// Reads an array of rows: any strides, byte orders and widths of a kind that fits, read-only or not. It is copied.
///
/// # Errors
/// `InputError` that says what was found where something else was given.
pub fn rows<T: Element + Copy>(
    given: &Bound<'_, PyAny>,
    expected: &Expected,
) -> PyResult<(Vec<T>, usize)> {
    let Expected {
        name,
        columns,
        dtype,
        kinds,
    } = *expected;
    let py = given.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (given,))?;
    let untyped = array
        .cast::<PyUntypedArray>()
        .map_err(|_| Failure::value(format!("{name} is no array")))?;
    let found = untyped.dtype().str()?.to_string();
    let kind: String = untyped.dtype().getattr("kind")?.extract()?;
    let shape = untyped.shape().to_vec();
    let wanted = format!("an array of shape (n, {columns}) and dtype {dtype}");
    if shape.len() != 2 || shape[1] != columns {
        let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
        let shape = format!(
            "({}{})",
            shape.join(", "),
            if shape.len() == 1 { "," } else { "" }
        );
        return Err(
            Failure::value(format!("{name} has the shape {shape}; expected {wanted}")).into(),
        );
    }
    if !kinds.contains(&kind) {
        return Err(
            Failure::value(format!("{name} has the dtype {found}; expected {wanted}")).into(),
        );
    }
    let options = PyDict::new(py);
    options.set_item("dtype", dtype)?;
    let plain = numpy.call_method("ascontiguousarray", (&array,), Some(&options))?;
    let plain = plain
        .cast::<PyArray2<T>>()
        .map_err(|_| Failure::value(format!("{name} has the dtype {found}; expected {wanted}")))?;
    let data = plain.readonly().as_slice()?.to_vec();
    Ok((data, shape[0]))
}

/// Checks that rows of `columns` numbers are finite.
///
/// # Errors
/// `InputError` that names the first that is not.
pub fn check_finite(name: &str, flat: &[f64], columns: usize) -> PyResult<()> {
    let Some(at) = flat.iter().position(|x| !x.is_finite()) else {
        return Ok(());
    };
    let (row, column, found) = (at / columns, at % columns, flat[at]);
    Err(Failure::value(format!(
        "{name}[{row}, {column}] is {found}; expected finite numbers"
    ))
    .into())
}
