//! Native part of the Python package `ridgetone`, based on the library of the command `ridgetone`.
//!
//! Results are passed as the JSON of the command's `--json`, written by the same functions, so that
//! numbers are equal to the last bit. `ridgetone/__init__.py` converts this to Python types.

mod array;
mod feel;
mod live;
mod simulate;
mod words;
mod work;

use pyo3::prelude::*;
use pyo3::{PyErr, create_exception};
use ridgetone_host::usage;

create_exception!(
    ridgetone,
    Error,
    pyo3::exceptions::PyException,
    "What the command says in its one line."
);
create_exception!(
    ridgetone,
    UsageError,
    Error,
    "Something impossible was requested."
);

/// Converts an error of the command to an exception with Python wording. An exception that has
/// passed through the library is returned unchanged.
fn raised(error: anyhow::Error) -> PyErr {
    if error.is::<PyErr>() {
        return error
            .downcast::<PyErr>()
            .unwrap_or_else(|error| Error::new_err(error.to_string()));
    }
    let text = words::of_python(&format!("{error:#}").replace(['\n', '\r'], " "));
    if error.is::<usage::UsageError>() {
        UsageError::new_err(text)
    } else {
        Error::new_err(text)
    }
}

#[pymodule]
fn _ridgetone(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Only the command shows progress on standard error.
    ridgetone_host::output::be_quiet();
    module.add("Error", module.py().get_type::<Error>())?;
    module.add("UsageError", module.py().get_type::<UsageError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<array::Samples>()?;
    module.add_class::<live::Board>()?;
    module.add_class::<work::Fitted>()?;
    module.add_function(wrap_pyfunction!(array::time_unit, module)?)?;
    module.add_function(wrap_pyfunction!(array::is_time, module)?)?;
    module.add_function(wrap_pyfunction!(array::split_times, module)?)?;
    module.add_function(wrap_pyfunction!(array::declared_unit, module)?)?;
    module.add_function(wrap_pyfunction!(work::fit, module)?)?;
    module.add_function(wrap_pyfunction!(work::fit_windows, module)?)?;
    module.add_function(wrap_pyfunction!(feel::feel, module)?)?;
    module.add_function(wrap_pyfunction!(feel::volts_per_um, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(work::replay, module)?)?;
    module.add_function(wrap_pyfunction!(work::settings, module)?)?;
    module.add_function(wrap_pyfunction!(work::messages, module)?)
}
