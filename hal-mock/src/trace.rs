//! Recorded traces as CSV: read as tables, played as scenes, written from scenes.

mod cells;
mod clock;
mod clock_time;
mod head_line;
mod header;
mod layout;
mod look;
mod played;
mod refused;
mod rounding;
mod row_reader;
mod rows;
mod stamps;
mod table;
mod time_column;
mod write;

pub use clock::RowClock;
pub use rounding::spacing_sigma_s;
pub use row_reader::{OpenRows, PROGRESS_ROWS, RowReader, Timing, ValueAt, check_order};
pub use rows::Rows;
pub use table::Table;
pub use time_column::{TIME_COLUMN, TimeColumn};
pub use write::write_csv;

use crate::file_error::FileError;
use crate::scene::{INPUTS, Scene};
use core::f64::consts::{FRAC_PI_2, PI};
pub use played::Failure;
use played::{Place, Played};
use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::Arc;

/// Rows whose stamps give the first guess of their spacing.
const HEAD_ROWS: usize = 4096;

/// A recording whose rate is within this share of the scan's is held: a chip's clock may be off by
/// as much.
const HELD_SHARE: f64 = 0.004;

/// Zeros of the filter's sinc on either side: it passes up to 0.44 of the lower rate, and stops
/// from 0.56 on.
const ZEROS: f64 = 8.0;

/// How a recording is played.
#[derive(Clone, Copy, Debug)]
pub struct Playback {
    /// Rows per second, whatever their stamps; without it those of the stamps or, where there are
    /// none, the scan's own rate.
    pub row_rate_hz: Option<f64>,
    /// Scans per second of a chip without a clock error.
    pub scan_rate_hz: f64,
    /// Volts per unit of the file.
    pub volts_per_unit: f64,
    /// The first value beyond these volts is remembered.
    pub limit_v: f64,
}

/// A recording played to the chip: its column k is on AINk, inputs without a column are at 0 V. It
/// is read row by row as it is played; one pass before that finds its rate and its faults.
///
/// - **Rows at about the scan's own rate are held**: row k is what scan k converts, unchanged. The
///   chip's clock has to run as the recording's did: [`clock_error_ppm`](Self::clock_error_ppm).
/// - **Rows at another rate are resampled** by a windowed sinc with the lower rate's band. Of a
///   faster recording it takes the noise above the scan's band and leaves the rest white. A slower
///   recording has no noise above its own band, so that neighbouring scans are alike.
/// - **Rows that are missing**, by the stamps or because they are blank, are conversions without a
///   result.
/// - **A blank cell** is bridged by a straight line; in a run of more than eight it is beyond the
///   scale, with OVF.
pub struct Trace {
    open: OpenRows,
    playback: Playback,
    survey: Survey,
    played: Option<Played>,
    failure: Failure,
}

/// What one pass over the rows finds.
#[derive(Clone, Debug)]
struct Survey {
    /// Numbers the rows again.
    clock: Option<RowClock>,
    spacing_s: f64,
    spacing_sigma_s: f64,
    /// Number of the last row.
    last: u64,
    /// Rows that were read.
    rows: u64,
    columns: usize,
    /// Columns with any reading.
    alive: u16,
    beyond: Option<Beyond>,
    guessed: Option<String>,
}

/// Most bytes that are read from a pipe.
const PIPE_MOST: u64 = 1 << 30;

/// A value that the chip cannot convert.
#[derive(Clone, Debug)]
pub struct Beyond {
    /// Number of its row, from 1.
    pub row: u64,
    /// Its column's name.
    pub column: String,
    /// The value.
    pub volts: f64,
}

impl Trace {
    /// Opens a CSV file and passes over its rows. `progress` takes the rows that have been read.
    pub fn open(
        path: &Path,
        playback: Playback,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self, FileError> {
        let file = path.display().to_string();
        let refuse = |error| FileError::new(&file, None, error);
        if std::fs::metadata(path).map_err(refuse)?.is_file() {
            let path = path.to_owned();
            return Self::new(
                Arc::new(move || Ok(Box::new(Rows::open(&path)?))),
                playback,
                progress,
            );
        }
        // A pipe is read only once, and a device may never end.
        let mut bytes = Vec::new();
        let input = std::fs::File::open(path).map_err(refuse)?;
        let read = input.take(PIPE_MOST).read_to_end(&mut bytes);
        if read.map_err(refuse)? as u64 == PIPE_MOST {
            let why = "more than 1 GiB: write it into a file, and name that";
            return Err(FileError::new(&file, None, why));
        }
        Self::parse(&bytes, &file, playback)
    }

    /// The same with the bytes of a file of that name.
    pub fn parse(bytes: &[u8], file: &str, playback: Playback) -> Result<Self, FileError> {
        let (bytes, file) = (Arc::<[u8]>::from(bytes), file.to_owned());
        let open =
            move || Ok(Box::new(Rows::new(Cursor::new(Arc::clone(&bytes)), &file)?) as Box<_>);
        Self::new(Arc::new(open), playback, &mut |_| {})
    }

    /// The same with any rows.
    pub fn new(
        open: OpenRows,
        playback: Playback,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self, FileError> {
        let survey = Survey::new(open()?, &playback, progress)?;
        Ok(Self {
            open,
            playback,
            survey,
            played: None,
            failure: Failure::default(),
        })
    }

    /// Rows per second, missing ones counted.
    pub fn rate_hz(&self) -> f64 {
        self.survey.spacing_s.recip()
    }

    /// Standard deviation of the rate as a share of it.
    pub fn rate_share(&self) -> f64 {
        self.survey.spacing_sigma_s / self.survey.spacing_s
    }

    /// Error of the chip's clock with which a scan lasts as long as a row that is held; 0 where
    /// rows are resampled.
    pub fn clock_error_ppm(&self) -> f64 {
        if self.is_held() {
            1e6 * (self.rate_hz() / self.playback.scan_rate_hz - 1.0)
        } else {
            0.0
        }
    }

    /// Why the recording ended early while it was played, if it did.
    pub fn failure(&self) -> Failure {
        Arc::clone(&self.failure)
    }

    /// The first value beyond the limit.
    pub fn beyond(&self) -> Option<&Beyond> {
        self.survey.beyond.as_ref()
    }

    /// What was guessed of how the rows are written.
    pub fn guessed(&self) -> Option<&str> {
        self.survey.guessed.as_deref()
    }

    fn is_held(&self) -> bool {
        (self.rate_hz() / self.playback.scan_rate_hz - 1.0).abs() <= HELD_SHARE
    }

    /// The rows from the first one on, or from where they were played to.
    fn played(&mut self, from: u64) -> Option<&mut Played> {
        // A scene that is repeated begins again.
        if self
            .played
            .as_ref()
            .is_none_or(|played| played.is_past(from))
        {
            let rows = (self.open)()
                .map_err(|error| self.failure.set(error))
                .ok()?;
            let failure = self.failure();
            let played = Played::new(rows, self.survey.clock, self.survey.rows, failure);
            self.played = Some(played);
        }
        self.played.as_mut()
    }
}

impl Scene for Trace {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let Survey {
            spacing_s,
            last,
            columns,
            alive,
            ..
        } = self.survey;
        let column = usize::from(input);
        if column >= columns || alive & 1 << column == 0 {
            return 0.0;
        }
        let at = (t_s / spacing_s).clamp(0.0, last as f64);
        let is_held = self.is_held();
        let narrow = (self.playback.scan_rate_hz * spacing_s).min(1.0);
        let half = if is_held { 0.0 } else { ZEROS / narrow };
        let volts_per_unit = self.playback.volts_per_unit;
        let (from, to) = (
            (at - half).max(0.0).floor() as u64,
            ((at + half).ceil() as u64).min(last),
        );
        let Some(played) = self.played(from) else {
            return 0.0;
        };
        played.read(from, to);
        let nearest = if is_held {
            at as u64
        } else {
            at.round() as u64
        };
        match played.place(nearest, column) {
            Place::NoRow => return f64::NAN,
            Place::Blank => return f64::INFINITY,
            Place::Value(value) if is_held => return volts_per_unit * value,
            Place::Value(_) => {}
        }
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, value) in played.values(from, to, column) {
            let off = (row as f64 - at) * narrow;
            let window = (FRAC_PI_2 * (off / ZEROS).clamp(-1.0, 1.0)).cos().powi(2);
            let weight = if off == 0.0 {
                1.0
            } else {
                window * (PI * off).sin() / (PI * off)
            };
            sum += weight * value;
            weights += weight;
        }
        volts_per_unit * sum / weights
    }

    fn end_s(&self) -> f64 {
        (self.survey.last + 1) as f64 * self.survey.spacing_s
    }
}

impl Survey {
    fn new(
        mut rows: Box<dyn RowReader + Send>,
        playback: &Playback,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self, FileError> {
        let columns = rows.names().len();
        if columns > INPUTS {
            let message = format!("{columns} channels, the chip has {INPUTS}");
            return Err(FileError::new(rows.file(), Some(1), message));
        }
        let (mut head, mut clock, mut values) = (Vec::new(), None::<RowClock>, Vec::new());
        let (mut read, mut alive, mut beyond, mut last) = (0, 0, None, 0);
        let (mut numbers, mut before_s) = (None, None);
        if let (Timing::Unclear(why), None) = (rows.timing(), playback.row_rate_hz) {
            return Err(FileError::new(rows.file(), None, why));
        }
        loop {
            let is_over = !rows.advance()?;
            if clock.is_none() && (is_over || head.len() == HEAD_ROWS) {
                numbers = RowClock::new(&head);
                clock = numbers;
                head.iter()
                    .for_each(|t_s| last = clock.as_mut().map_or(0, |clock| clock.push(*t_s)));
            }
            if is_over {
                break;
            }
            rows.values(&mut values)?;
            read += 1;
            if read % PROGRESS_ROWS == 0 {
                progress(read);
            }
            for (column, value) in values.iter().enumerate() {
                alive |= u16::from(!value.is_nan()) << column;
                let volts = value * playback.volts_per_unit;
                if volts.abs() > playback.limit_v && beyond.is_none() {
                    beyond = Some(Beyond {
                        row: read,
                        column: rows.names()[column].clone(),
                        volts,
                    });
                }
            }
            let time_s = rows.time_s().filter(|_| playback.row_rate_hz.is_none());
            if let Some(t_s) = time_s {
                check_order(&*rows, before_s.unwrap_or(f64::NEG_INFINITY), t_s)?;
                before_s = time_s;
            }
            match (time_s, &mut clock) {
                (Some(t_s), Some(clock)) => last = clock.push(t_s),
                (Some(t_s), None) => head.push(t_s),
                (None, _) => last = read - 1,
            }
        }
        let rate_hz = playback.row_rate_hz.unwrap_or(playback.scan_rate_hz);
        let (spacing_s, spacing_sigma_s) = clock.map_or((rate_hz.recip(), 0.0), |clock| {
            (clock.spacing_s(), clock.spacing_sigma_s(0.0))
        });
        if !(spacing_s > 0.0 && spacing_s.is_finite()) {
            return Err(FileError::new(rows.file(), None, "its rows have no rate"));
        }
        Ok(Self {
            clock: numbers,
            spacing_s,
            spacing_sigma_s,
            last,
            rows: read,
            columns,
            alive,
            beyond,
            guessed: rows.guessed(),
        })
    }
}
