//! Values between Python and the library: parameters, and reports as dictionaries.

use crate::failure::Failure;
use glam::DVec2;
use greenstick::ErrorKind;
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::schema::Value;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyString};
use serde::Serialize;
use std::path::Path;

/// What `__reduce__` returns: what makes the value again, and what it is called with.
pub type Reduced<'py, T> = PyResult<(Bound<'py, PyAny>, T)>;

/// A parameter's value as Python has it: `None` is "auto".
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Auto => py.None().into_bound(py),
        Value::Flag(b) => PyBool::new(py, *b).to_owned().into_any(),
        Value::Integer(n) => n.into_pyobject(py)?.into_any(),
        Value::Number(x) => PyFloat::new(py, *x).into_any(),
        Value::Text(text) => PyString::new(py, text).into_any(),
        Value::List(list) => {
            let all: PyResult<Vec<_>> = list.iter().map(|value| to_python(py, value)).collect();
            PyList::new(py, all?)?.into_any()
        }
    })
}

/// A value from Python, as yet unchecked; `key` is for the message.
pub fn from_python(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if value.is_none() {
        return Ok(Value::Auto);
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Flag(flag.is_true()));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(Value::Text(text));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Number(value.extract()?));
    }
    // NumPy's scalars and arrays of them as Python's.
    if let Ok(plain) = value.call_method0("tolist") {
        return from_python(key, &plain);
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract::<i128>();
        return Ok(Value::Integer(whole.map_err(|_| {
            Failure::new(
                "ParameterError",
                ErrorKind::Request,
                format!("{key} is {value}, which is out of any range"),
            )
        })?));
    }
    if let Ok(items) = value.try_iter() {
        let all: PyResult<Vec<Value>> = items.map(|item| from_python(key, &item?)).collect();
        return all.map(Value::List);
    }
    let class = value.get_type().name()?;
    Err(Failure::new(
        "ParameterError",
        ErrorKind::Request,
        format!("{key} is of type {class}; expected a number, a text, a bool, None or a list"),
    )
    .into())
}

/// A report as dictionaries, lists and numbers.
pub fn report<'py>(py: Python<'py>, report: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let value = serde_json::to_value(report).map_err(Failure::report)?;
    json(py, &value)
}

/// JSON as Python's own types.
pub fn json<'py>(py: Python<'py>, value: &serde_json::Value) -> PyResult<Bound<'py, PyAny>> {
    use serde_json::Value as Json;
    Ok(match value {
        Json::Null => py.None().into_bound(py),
        Json::Bool(b) => PyBool::new(py, *b).to_owned().into_any(),
        Json::Number(n) => match (n.as_i64(), n.as_u64(), n.as_f64()) {
            (Some(n), ..) => n.into_pyobject(py)?.into_any(),
            (_, Some(n), _) => n.into_pyobject(py)?.into_any(),
            (_, _, x) => PyFloat::new(py, x.unwrap_or(f64::NAN)).into_any(),
        },
        Json::String(text) => PyString::new(py, text).into_any(),
        Json::Array(list) => {
            let all: PyResult<Vec<_>> = list.iter().map(|value| json(py, value)).collect();
            PyList::new(py, all?)?.into_any()
        }
        Json::Object(map) => {
            let dict = PyDict::new(py);
            for (key, value) in map {
                dict.set_item(key, json(py, value)?)?;
            }
            dict.into_any()
        }
    })
}

/// Points of a plane as an array of shape (n, 2).
pub fn points<'py>(py: Python<'py>, points: &[DVec2]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = points.iter().map(|p| p.to_array().to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows).map_err(|e| Failure::value(e.to_string()))?)
}

/// A table as comma-separated values, as a dictionary of its columns.
pub fn columns<'py>(py: Python<'py>, csv: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("greenstick._arrays")?
        .call_method1("csv_columns", (csv,))
}

/// Encoded files as a dictionary of their names and bytes.
pub fn encoded_files<'py>(py: Python<'py>, files: &[Encoded]) -> PyResult<Bound<'py, PyDict>> {
    let dictionary = PyDict::new(py);
    for file in files {
        dictionary.set_item(&file.name, PyBytes::new(py, &file.bytes))?;
    }
    Ok(dictionary)
}

/// Writes such a dictionary into a folder, all files or none.
pub fn write_files(dictionary: &Bound<'_, PyDict>, folder: &Path) -> PyResult<()> {
    let mut encoded = Vec::new();
    for (name, bytes) in dictionary {
        let (name, bytes): (String, Vec<u8>) = (name.extract()?, bytes.extract()?);
        encoded.push(Encoded::new(&name, bytes));
    }
    let written = files::write_folder(folder, encoded);
    written.map(drop).map_err(|e| Failure::from(e).into())
}
