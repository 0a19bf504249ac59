//! What all sets of parameters have in common in Python.

use crate::convert::{from_python, to_python};
use crate::failure::Failure;
use greenstick::schema::{ParameterInfo, Parameters, Value};
use greenstick_sweep::keys::find;
use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The value of a parameter.
pub fn get<'py>(py: Python<'py>, set: &dyn Parameters, key: &str) -> PyResult<Bound<'py, PyAny>> {
    let info = find(set, key).map_err(Failure::from)?;
    to_python(py, &info.value)
}

/// The value of a parameter as an attribute: one that does not exist is an `AttributeError`, as Python expects.
pub fn attribute<'py>(
    py: Python<'py>,
    set: &dyn Parameters,
    key: &str,
) -> PyResult<Bound<'py, PyAny>> {
    match find(set, key) {
        Ok(info) => to_python(py, &info.value),
        Err(error) => Err(PyAttributeError::new_err(error.to_string())),
    }
}

/// Calls `set` with every key and value of two dictionaries, the second over the first.
pub fn each(
    dictionaries: [Option<&Bound<'_, PyDict>>; 2],
    mut set: impl FnMut(&str, &Value) -> Result<(), Failure>,
) -> PyResult<()> {
    for dictionary in dictionaries.into_iter().flatten() {
        for (key, value) in dictionary {
            let key: String = key.extract()?;
            set(&key, &from_python(&key, &value)?)?;
        }
    }
    Ok(())
}

/// Parameters as a dictionary.
pub fn dictionary<'py>(
    py: Python<'py>,
    list: impl IntoIterator<Item = ParameterInfo>,
) -> PyResult<Bound<'py, PyDict>> {
    let dictionary = PyDict::new(py);
    for info in list {
        dictionary.set_item(&info.key, to_python(py, &info.value)?)?;
    }
    Ok(dictionary)
}
