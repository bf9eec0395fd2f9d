//! Rows of samples from any source: a table, a recording of telemetry with raw frames, an export of
//! a recording, or an array in memory.

mod unchanged;

use crate::content::{Content, Input};
use crate::messages::{Form, messages};
use crate::raw_rows::RawRows;
use crate::tables::{FlatRows, OpenRows, RowReader, Rows, TableForm, TimeColumn, Timing, ValueAt};
use crate::wav_rows::WavRows;
use anyhow::Result;
use hal_mock::{FileError, escaped};
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempPath;
use unchanged::{State, UnchangedRows};

/// Rows that can be read more than once. A clone has the same rows.
#[derive(Clone)]
pub struct Samples {
    name: String,
    path: Option<PathBuf>,
    open: OpenRows,
}

impl Samples {
    /// Makes samples of a file in any form that [`open`] knows. A pipe or standard input (`-`) can
    /// be read only once, so it is read completely now.
    pub fn file(path: &Path) -> Result<Self> {
        Self::file_with(path, None)
    }

    /// Like [`file`](Self::file), with the time column of a table.
    pub fn file_with(path: &Path, time: Option<TimeColumn>) -> Result<Self> {
        Self::file_as(path, TableForm::timed(time))
    }

    /// Like [`file`](Self::file), with options for reading a table.
    pub fn file_as(path: &Path, form: TableForm) -> Result<Self> {
        let is_standard_input = path == Path::new("-");
        let name = match is_standard_input {
            true => "standard input".to_owned(),
            false => escaped(&path.display().to_string()).into_owned(),
        };
        let refuse = |error| FileError::new(&name, None, error);
        // Input that can be read only once is kept in a temporary file.
        let kept = if is_standard_input {
            Some(kept(&mut std::io::stdin().lock()).map_err(refuse)?)
        } else if std::fs::metadata(path).map_err(refuse)?.is_file() {
            None
        } else {
            let mut input = File::open(path).map_err(refuse)?;
            Some(kept(&mut input).map_err(refuse)?)
        };
        let at = kept
            .as_ref()
            .map_or(path.to_owned(), |kept| kept.to_path_buf());
        let state = State::of(&at).map_err(refuse)?;
        let (path, file) = (Some(at.clone()), name.clone());
        let open: OpenRows = Arc::new(move || {
            let _kept = &kept;
            let rows = open_named(&at, &file, &form)?;
            Ok(Box::new(UnchangedRows {
                rows,
                path: at.clone(),
                state,
            }))
        });
        Ok(Self { name, path, open })
    }

    /// Makes samples from rows of any source, with a name for error messages.
    pub fn rows(name: &str, open: OpenRows) -> Self {
        Self {
            name: name.to_owned(),
            path: None,
            open,
        }
    }

    /// Makes samples from rows in memory with column names. `value_at` returns the value at a row
    /// and column, or NaN if it is missing; `time_s` returns the time of a row.
    pub fn array(
        name: &str,
        names: Vec<String>,
        rows: usize,
        value_at: ValueAt,
        time_s: Option<TimeAt>,
    ) -> Self {
        let array = ArrayRows {
            file: name.to_owned(),
            names,
            rows,
            value_at,
            time_s,
            next: 0,
            present_s: None,
        };
        Self::rows(name, Arc::new(move || Ok(Box::new(array.clone()))))
    }

    /// Returns the samples with `change` applied whenever the rows are opened.
    #[must_use]
    pub fn with_rows(&self, change: ChangeRows) -> Self {
        let opener = self.opener();
        Self {
            open: Arc::new(move || Ok(change(opener()?))),
            ..self.clone()
        }
    }

    /// Returns the samples with a different name for error messages.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub fn open(&self) -> Result<Box<dyn RowReader + Send>> {
        Ok((self.open)()?)
    }

    pub fn opener(&self) -> OpenRows {
        Arc::clone(&self.open)
    }
}

impl fmt::Debug for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Samples").field(&self.name).finish()
    }
}

/// Transforms rows, such as by adding a column.
pub type ChangeRows =
    Arc<dyn Fn(Box<dyn RowReader + Send>) -> Box<dyn RowReader + Send> + Send + Sync>;

/// A row's time, seconds.
pub type TimeAt = Arc<dyn Fn(usize) -> f64 + Send + Sync>;

#[derive(Clone)]
struct ArrayRows {
    file: String,
    names: Vec<String>,
    rows: usize,
    value_at: ValueAt,
    time_s: Option<TimeAt>,
    /// Index of the row after the current one.
    next: usize,
    present_s: Option<f64>,
}

impl RowReader for ArrayRows {
    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        if self.rows == 0 || self.names.is_empty() {
            return Err(FileError::new(
                &self.file,
                None,
                "no data: it needs a row and a column",
            ));
        }
        if self.next == self.rows {
            return Ok(false);
        }
        let t_s = self.time_s.as_ref().map(|time_s| time_s(self.next));
        self.next += 1;
        if let Some(t_s) = t_s.filter(|t_s| !t_s.is_finite()) {
            return Err(self.refuse(&format!("time_s: {t_s} is no time")));
        }
        self.present_s = t_s;
        Ok(true)
    }

    fn time_s(&self) -> Option<f64> {
        self.present_s
    }

    fn timing(&self) -> Timing {
        match self.time_s {
            Some(_) => Timing::Stamped,
            None => Timing::Absent("give rate_hz, or time_s; of a data frame, or a file, time_column names the column that is the time".into()),
        }
    }

    fn refuse(&self, why: &str) -> FileError {
        FileError::new(&self.file, None, format!("row {}: {why}", self.next))
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clear();
        values.extend((0..self.names.len()).map(|column| (self.value_at)(self.next - 1, column)));
        match values.iter().position(|value| value.is_infinite()) {
            Some(at) => Err(self.refuse(&format!(
                "column {}: {} is not finite",
                self.names[at], values[at]
            ))),
            None => Ok(()),
        }
    }

    fn in_memory(&self) -> Option<ValueAt> {
        Some(Arc::clone(&self.value_at))
    }
}

/// Bytes read from the beginning of an input to detect its form.
const LOOK_BYTES: u64 = 1 << 16;

/// Maximum size in bytes of a recording from a pipe: about a week of a fast instrument.
const KEPT_MAX: u64 = 4 << 30;

/// Copies `input` to a temporary file, which is removed when it is no longer used. A device may
/// never end, so an input that does not begin like a recording or table is refused early.
fn kept(input: &mut dyn Read) -> std::io::Result<TempPath> {
    let mut file = tempfile::NamedTempFile::new()?;
    std::io::copy(&mut input.take(LOOK_BYTES), &mut file)?;
    if Form::of(file.path())? == Form::Table {
        Content::of(Box::new(File::open(file.path())?)).map_err(std::io::Error::other)?;
    }
    if std::io::copy(&mut input.take(KEPT_MAX), &mut file)? == KEPT_MAX {
        return Err(std::io::Error::other(
            "more than 4 GiB: write it into a file, and name that",
        ));
    }
    Ok(file.into_temp_path())
}

/// Opens the rows of a file for one pass: those of a table, or raw telemetry frames, in volts.
pub fn open(
    path: &Path,
    time: Option<&TimeColumn>,
) -> Result<Box<dyn RowReader + Send>, FileError> {
    let form = TableForm::timed(time.cloned());
    open_named(path, &path.display().to_string(), &form)
}

/// Opens a file; errors call it `file`.
fn open_named(
    path: &Path,
    file: &str,
    form: &TableForm,
) -> Result<Box<dyn RowReader + Send>, FileError> {
    let refuse = |error: anyhow::Error| {
        let text = format!("{error:#}");
        FileError::new(
            file,
            None,
            text.strip_prefix(&format!("{file}: ")).unwrap_or(&text),
        )
    };
    match Form::of(path).map_err(|error| FileError::new(file, None, error))? {
        Form::Table => {
            let input = File::open(path).map_err(|error| FileError::new(file, None, error))?;
            decoded(Box::new(input), file, form)
        }
        _ if form.time.is_some() || form.is_flat => Err(FileError::new(
            file,
            None,
            "--time-column and --flatten are for tables: telemetry has its own time",
        )),
        telemetry => {
            // Open the messages twice: the first pass finds taxels without any value.
            let open = || messages(path, telemetry).map_err(refuse);
            Ok(Box::new(
                RawRows::new(file, open()?, open()?).map_err(refuse)?,
            ))
        }
    }
}

/// Returns the rows of a table or of a sound file, in any known encoding.
fn decoded(
    input: Input,
    file: &str,
    form: &TableForm,
) -> Result<Box<dyn RowReader + Send>, FileError> {
    match Content::of(input) {
        Ok(Content::Text(text)) => {
            let rows = Rows::with(text, file, form)?;
            Ok(match form.is_flat {
                true => Box::new(FlatRows::new(rows)),
                false => Box::new(rows),
            })
        }
        Ok(Content::Wav(sound)) => Ok(Box::new(WavRows::new(sound, file)?)),
        Err(error) => Err(FileError::new(file, None, error)),
    }
}
