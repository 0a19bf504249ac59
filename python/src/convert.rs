//! Values between Python and the library: parameters, and reports as dictionaries.

use crate::failure::Failure;
use greenstick::ErrorKind;
use greenstick::schema::Value;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use serde::Serialize;

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
    let value = serde_json::to_value(report)
        .map_err(|e| Failure::new("ReportError", ErrorKind::Work, e))?;
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
