//! Values of scenes between Python and TOML.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use toml::{Table, Value};

/// A value as TOML writes it behind `key = `.
#[pyfunction]
pub fn literal(value: &Bound<'_, PyAny>) -> PyResult<String> {
    Ok(of_python(value)?.to_string())
}

/// A dict as the text of a scene. A key with dots stands for tables in each other.
#[pyfunction]
pub fn toml_text(scene: &Bound<'_, PyDict>) -> PyResult<String> {
    toml::to_string(&table(scene)?).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// The TOML value of a Python value: flags, numbers, texts, paths, lists, tuples, dicts, and arrays and numbers of numpy.
///
/// # Errors
/// TypeError for any other type.
pub fn of_python(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    // a flag is a number in Python
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(Value::Table(table(dict)?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let entries: PyResult<Vec<Value>> = value.try_iter()?.map(|entry| of_python(&entry?)).collect();
        return Ok(Value::Array(entries?));
    }
    // numpy
    if value.hasattr("tolist")? {
        return of_python(&value.call_method0("tolist")?);
    }
    if value.hasattr("__fspath__")? {
        return of_python(&value.call_method0("__fspath__")?);
    }
    let what = value.get_type().name()?;
    Err(PyTypeError::new_err(format!("a scene holds no {what}: flags, numbers, texts, paths, lists and dicts of them")))
}

fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict {
        let key: String = key.extract().map_err(|_| PyTypeError::new_err(format!("a key of a scene is a text, not {key}")))?;
        enter(&mut table, &key, &key, of_python(&value)?)?;
    }
    Ok(table)
}

/// Puts a value into a table at a key with dots, of which `rest` is left. Tables are merged.
fn enter(table: &mut Table, key: &str, rest: &str, value: Value) -> PyResult<()> {
    let twice = || PyValueError::new_err(format!("{key} is there twice"));
    if let Some((name, rest)) = rest.split_once('.') {
        let inner = table.entry(name).or_insert_with(|| Value::Table(Table::new()));
        return enter(inner.as_table_mut().ok_or_else(twice)?, key, rest, value);
    }
    match (table.get_mut(rest), value) {
        (None, value) => {
            table.insert(rest.into(), value);
            Ok(())
        }
        (Some(Value::Table(there)), Value::Table(more)) => {
            more.into_iter().try_for_each(|(name, value)| enter(there, &format!("{key}.{name}"), &name, value))
        }
        _ => Err(twice()),
    }
}

/// The Python value of a TOML value.
pub fn to_python(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::String(text) => text.into_py_any(py),
        Value::Integer(number) => number.into_py_any(py),
        Value::Float(number) => number.into_py_any(py),
        Value::Boolean(flag) => flag.into_py_any(py),
        Value::Datetime(time) => time.to_string().into_py_any(py),
        Value::Array(entries) => {
            let entries: PyResult<Vec<Py<PyAny>>> = entries.iter().map(|entry| to_python(py, entry)).collect();
            entries?.into_py_any(py)
        }
        Value::Table(table) => {
            let dict = PyDict::new(py);
            for (name, value) in table {
                dict.set_item(name, to_python(py, value)?)?;
            }
            dict.into_py_any(py)
        }
    }
}
