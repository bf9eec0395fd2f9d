//! Rows of samples from a file, or from an array that is not copied.

use crate::raised;
use anyhow::bail;
use pyo3::buffer::{Element, PyBuffer};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use ridgetone_host::tables::{TableForm, TimeColumn, Timing};
use ridgetone_host::{samples, tables};
use std::path::PathBuf;
use std::sync::Arc;

/// Rows that `fit`, `replay` and `feel` accept.
#[pyclass(frozen)]
pub struct Samples(pub samples::Samples);

/// Result of [`Samples::read`].
type Rows<'py> = (
    Vec<String>,
    Option<Bound<'py, PyByteArray>>,
    Bound<'py, PyByteArray>,
    Option<String>,
);

/// An additional column for an array, such as the speed of its rows, from a `dict` with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Beside<'py> {
    name: String,
    values: Bound<'py, PyAny>,
}

struct Read {
    names: Vec<String>,
    times: Vec<u8>,
    values: Vec<u8>,
    guessed: Option<String>,
}

/// Reads a value by its row and its column.
type ValueAt = Arc<dyn Fn(usize, usize) -> f64 + Send + Sync>;

/// A two-dimensional array with any strides, which is not copied.
struct View<T: Element> {
    buffer: PyBuffer<T>,
    /// Address of the first value, as a number, because raw pointers are not `Send`.
    start: usize,
    shape: [usize; 2],
    strides: [isize; 2],
}

impl<T: Element> View<T> {
    fn new(buffer: PyBuffer<T>) -> PyResult<Self> {
        let (Ok(shape), Ok(strides)) = (buffer.shape().try_into(), buffer.strides().try_into())
        else {
            return Err(PyTypeError::new_err(
                "an array of two dimensions is needed: rows, then channels",
            ));
        };
        Ok(Self {
            start: buffer.buf_ptr() as usize,
            shape,
            strides,
            buffer,
        })
    }

    fn at(&self, row: usize, column: usize) -> T {
        assert!(row < self.shape[0] && column < self.shape[1]);
        let offset = row as isize * self.strides[0] + column as isize * self.strides[1];
        #[expect(
            unsafe_code,
            reason = "the safe readers copy, or hold the interpreter's lock"
        )]
        // SAFETY: `buffer` keeps the memory of this shape and these strides alive, and the indices
        // are inside it. As in NumPy's own loops, it is the caller who must not write to an array
        // that is being read.
        unsafe {
            std::ptr::with_exposed_provenance::<T>(self.start.wrapping_add_signed(offset))
                .read_unaligned()
        }
    }
}

/// Returns a reader of an array of f32 or f64, and the numbers of rows and columns.
fn view(array: &Bound<'_, PyAny>) -> PyResult<(ValueAt, [usize; 2])> {
    if let Ok(buffer) = PyBuffer::<f64>::get(array) {
        let view = View::new(buffer)?;
        view.buffer.buf_ptr().expose_provenance();
        let shape = view.shape;
        return Ok((Arc::new(move |row, column| view.at(row, column)), shape));
    }
    let view = View::new(PyBuffer::<f32>::get(array)?)?;
    view.buffer.buf_ptr().expose_provenance();
    let shape = view.shape;
    Ok((
        Arc::new(move |row, column| view.at(row, column).into()),
        shape,
    ))
}

#[pymethods]
impl Samples {
    /// Opens the samples of a file in any form that the command reads.
    #[staticmethod]
    #[pyo3(signature = (path, time_column, flatten=false, has_columns=false))]
    fn file(
        path: PathBuf,
        time_column: Option<&str>,
        flatten: bool,
        has_columns: bool,
    ) -> PyResult<Self> {
        let time = time_column
            .map(TimeColumn::parse)
            .transpose()
            .map_err(crate::UsageError::new_err)?;
        let form = TableForm {
            time,
            is_flat: flatten,
            has_columns,
        };
        samples::Samples::file_as(&path, form)
            .map(Self)
            .map_err(raised)
    }

    /// Makes samples from an array, optionally with a column of times and one additional named
    /// column.
    #[staticmethod]
    #[pyo3(signature = (name, names, values, times, beside))]
    fn array(
        name: &str,
        mut names: Vec<String>,
        values: &Bound<'_, PyAny>,
        times: Option<&Bound<'_, PyAny>>,
        beside: Option<Beside<'_>>,
    ) -> PyResult<Self> {
        let (mut value_at, [rows, columns]) = view(values)?;
        if names.len() != columns {
            return Err(crate::UsageError::new_err(format!(
                "{} names for {columns} columns",
                names.len()
            )));
        }
        let times = match times.map(view).transpose()? {
            Some((_, [stamps, _])) if stamps != rows => {
                return Err(crate::UsageError::new_err(format!(
                    "{stamps} times for {rows} rows"
                )));
            }
            Some((time_at, _)) => Some(Arc::new(move |row| time_at(row, 0)) as samples::TimeAt),
            None => None,
        };
        if let Some(beside) = beside {
            let (beside_at, [count, _]) = view(&beside.values)?;
            if count != rows {
                let name = beside.name;
                return Err(crate::UsageError::new_err(format!(
                    "{name}: {count} values for {rows} rows"
                )));
            }
            if names.contains(&beside.name) {
                let name = beside.name;
                return Err(crate::UsageError::new_err(format!(
                    "a channel is called {name}, too: give it another name"
                )));
            }
            names.push(beside.name);
            let channel_at = value_at;
            value_at = Arc::new(move |row, column| match column < columns {
                true => channel_at(row, column),
                false => beside_at(row, 0),
            });
        }
        Ok(Self(samples::Samples::array(
            name, names, rows, value_at, times,
        )))
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Reads all rows. Returns the names of the columns, the times if there are any, the values row
    /// by row (both as bytes of f64), and guesses about the format.
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py>> {
        let Read {
            names,
            times,
            values,
            guessed,
        } = py.detach(|| self.read_all()).map_err(raised)?;
        let times = (!times.is_empty()).then(|| PyByteArray::new(py, &times));
        Ok((names, times, PyByteArray::new(py, &values), guessed))
    }
}

impl Samples {
    fn read_all(&self) -> anyhow::Result<Read> {
        let mut rows = self.0.open()?;
        if let Timing::Unclear(why) = rows.timing() {
            bail!("{}: {why}", rows.file());
        }
        let (mut row, mut times, mut values) = (Vec::new(), Vec::new(), Vec::new());
        while rows.advance()? {
            rows.values(&mut row)?;
            times.extend(rows.time_s().into_iter().flat_map(f64::to_ne_bytes));
            values.extend(row.iter().flat_map(|value| value.to_ne_bytes()));
        }
        Ok(Read {
            names: rows.names().to_vec(),
            times,
            values,
            guessed: rows.guessed(),
        })
    }
}

/// Returns a unit of time in seconds; `None` if the unit is unknown.
#[pyfunction]
pub fn time_unit(unit: &str) -> Option<f64> {
    tables::per_second(unit).map(f64::recip)
}

/// Returns pairs of columns whose names are those of seconds and their fraction: the two positions,
/// and the fraction's unit in seconds.
#[pyfunction]
#[expect(
    clippy::needless_pass_by_value,
    reason = "a Python list is converted to a vector"
)]
pub fn split_times(names: Vec<String>) -> Vec<(usize, usize, f64)> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let pairs = tables::SplitTime::named(&names).into_iter();
    pairs
        .map(|pair| (pair.seconds, pair.fraction, pair.per_second.recip()))
        .collect()
}

/// True if a column's name marks it as a time.
#[pyfunction]
pub fn is_time(name: &str) -> bool {
    tables::is_time(name)
}

/// Returns the unit declared by the name of a time column, in seconds; `None` if there is none.
/// Fails for an unknown unit.
#[pyfunction]
pub fn declared_unit(name: &str) -> PyResult<Option<f64>> {
    tables::declared_seconds(name).map_err(|unit| {
        crate::UsageError::new_err(format!(
            "column {name}: the unit {unit:?} is not known: say which with time_column=\"{name}:ms\" (or s, us, ns, min, h, d)"
        ))
    })
}
