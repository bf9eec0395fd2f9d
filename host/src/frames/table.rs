//! The rows of a table as plain frames.

use super::frame::{Frame, Reading};
use crate::digits::significant;
use crate::events::Columns;
use crate::input::rate_of;
use crate::output::Progress;
use crate::raw_rows;
use crate::samples::Samples;
use crate::tables::{PROGRESS_ROWS, RowClock, RowReader, Timing, check_order};
use anyhow::{Result, bail, ensure};
use ridgetone_finger::PlainFrame;
use ridgetone_proto::plan::{FRAME_RATE_MAX_HZ, FRAME_RATE_MIN_HZ, Plan};
use ridgetone_proto::settings::{Array, Settings, TAXELS, TRACK_STRIDE_S};
use std::fmt;
use std::ops::ControlFlow;

/// Number of rows whose stamps are used for the first guess of the spacing.
const HEAD_ROWS: usize = 4096;

/// Tolerance of a board's frame rate, as a fraction of the nominal rate: the error of the chip's
/// clock.
const SCAN_OFF_MAX: f64 = 0.004;

/// Longest gap between two rows, seconds. A longer one means that the clock was set, or that the
/// recording was interrupted.
const GAP_MAX_S: f64 = 60.0;

/// Longest gap between two rows, as a fraction of the whole time.
const GAP_FRACTION_MAX: f64 = 0.5;

/// Minimum ratio of a wide gap to the mean spacing of the rows before it.
const GAP_ROWS: f64 = 10.0;

/// Maximum number of rows that may be missing, as a fraction of all.
const MISSING_MAX: f64 = 0.2;

/// Minimum number of rows in a suggested window.
const WINDOW_ROWS: f64 = 64.0;

/// Stride between windows, as a fraction of the window.
const STRIDE_FRACTION: f32 = 0.25;

pub struct Table {
    samples: Samples,
    volts_per_unit: f64,
    names: Vec<String>,
    units: Vec<Option<String>>,
    rate_hz: f64,
    /// Relative standard deviation of the rate.
    rate_fraction: f64,
    plan: Plan,
    /// Clock that numbers the rows in each later pass.
    clock: Option<RowClock>,
    rows: u64,
    /// Number of the last row, counting missing ones.
    last: u64,
    largest: Option<Largest>,
    guessed: Option<String>,
    may_be_volts: bool,
}

/// Value with the largest magnitude.
#[derive(Clone, Copy, Debug)]
struct Largest {
    /// Number of the value's row, from 1.
    row: u64,
    column: usize,
    value: f64,
}

impl Table {
    /// Reads all rows in one pass.
    pub fn open(samples: &Samples, reading: Reading) -> Result<Self> {
        let (mut progress, mut survey) = (Progress::default(), Survey::default());
        let mut rows = samples.open()?;
        let read = survey.read(&mut *rows, reading, &mut progress);
        progress.end();
        read?;
        let file = samples.name();
        let (rate_hz, rate_fraction) = survey.rate(reading)?.ok_or_else(|| {
            anyhow::anyhow!("{file}: its rows have no rate: give it with --rate HZ")
        })?;
        let missing = survey.last + 1 - survey.rows;
        ensure!(
            missing as f64 <= MISSING_MAX * survey.rows as f64,
            "{file}: its rows are not evenly spaced: {}",
            instead(samples, None)
        );
        let names = rows.names().to_vec();
        ensure!(
            (1..=TAXELS).contains(&names.len()),
            "{file}: {} channels, and 1 to {TAXELS} are taken together: {}",
            names.len(),
            instead(samples, Some("--columns NAMES"))
        );
        let (min, max) = (FRAME_RATE_MIN_HZ, FRAME_RATE_MAX_HZ);
        let window = format!("--window {}", (WINDOW_ROWS / rate_hz).ceil());
        ensure!(
            (f64::from(min)..=f64::from(max)).contains(&rate_hz),
            "{file}: {} rows a second, and touches are found from {min} to {max}: {}",
            significant(rate_hz, 5),
            instead(samples, Some(&window))
        );
        let plan = if is_of_board(&names, rate_hz) {
            let clock_hz = rate_hz * f64::from(Plan::PAPER.frame_ticks);
            Plan::PAPER.with_clock(clock_hz.round() as u32)
        } else {
            Plan::of_frames(rate_hz as f32, names.len())
                .map_err(|error| anyhow::anyhow!("{file}: {error:?}"))?
        };
        Ok(Self {
            samples: samples.clone(),
            volts_per_unit: reading.volts_per_unit,
            names,
            units: rows.units(),
            rate_hz,
            rate_fraction,
            plan,
            clock: survey.numbers,
            rows: survey.rows,
            last: survey.last,
            largest: survey.largest,
            guessed: rows.guessed(),
            may_be_volts: {
                let all: Vec<usize> = (0..rows.names().len()).collect();
                // Scaled values are volts.
                reading.volts_per_unit != 1.0 || super::may_be_volts(&*rows, &all)
            },
        })
    }

    /// True if the values may be the voltages of a finger.
    pub fn may_be_volts(&self) -> bool {
        self.may_be_volts
    }

    /// Returns the library's settings with the plan of these rows. Columns that are not a board's
    /// have no positions on a finger, so no spatial period can follow from them.
    pub fn settings(&self) -> Settings {
        let front = match self.is_of_board() {
            true => Array::DEFAULT.front,
            false => 0,
        };
        let array = Array {
            front,
            ..Array::DEFAULT
        };
        let settings = Settings::DEFAULT.with_plan(self.plan);
        Settings {
            array,
            // Use a shorter stride than the plan's, which is chosen for the chip, but one long
            // enough that each window is reported as a whole estimate.
            stride_s: (STRIDE_FRACTION * settings.window_s).max(TRACK_STRIDE_S),
            ..settings
        }
    }

    pub fn length_s(&self) -> f64 {
        (self.last + 1) as f64 / self.rate_hz
    }

    pub fn rate_fraction(&self) -> f64 {
        self.rate_fraction
    }

    pub fn guessed(&self) -> Option<String> {
        self.guessed.clone()
    }

    pub fn columns(&self) -> Columns {
        Columns {
            names: self.names.clone(),
            units: self.units.clone(),
            volts_per_unit: self.volts_per_unit,
        }
    }

    /// True if the columns are those that `export` and `emulate --print-scene` write, at the rate
    /// of the board's scan: its inputs are read one after the other.
    pub fn is_of_board(&self) -> bool {
        is_of_board(&self.names, self.rate_hz)
    }

    /// Returns a warning if values are beyond the reference, since they are left out.
    pub fn beyond(&self, vref_v: f64) -> Option<String> {
        let Largest { row, column, value } = self.largest?;
        let volts = value * self.volts_per_unit;
        (volts.abs() > vref_v).then(|| {
            format!(
                "{}: row {row}, column {}: {volts:.4e} V is beyond +-{vref_v:.3} V; such values are left out: scale the file with --scale",
                self.samples.name(),
                self.names[column]
            )
        })
    }

    pub fn each(&self, take: &mut dyn FnMut(Frame<'_>) -> Result<ControlFlow<()>>) -> Result<()> {
        let (mut rows, mut clock) = (self.samples.open()?, self.clock);
        let (mut values, mut readings, mut read) = (Vec::new(), Vec::new(), 0);
        while rows.advance()? {
            let number = match (&mut clock, rows.time_s()) {
                (Some(clock), Some(t_s)) => clock.push(t_s),
                _ => read,
            };
            read += 1;
            rows.values(&mut values)?;
            readings.clear();
            readings.extend(
                values
                    .iter()
                    .map(|value| (value * self.volts_per_unit) as f32),
            );
            let frame = PlainFrame {
                t_us: (number as f64 * 1e6 / self.rate_hz).round() as u64,
                readings: &readings,
            };
            if take(Frame::Plain(frame))?.is_break() {
                return Ok(());
            }
        }
        if read != self.rows {
            bail!(
                "{}: row {read}: it ended after {read} rows, and had {} before",
                self.samples.name(),
                self.rows
            );
        }
        Ok(())
    }
}

fn is_of_board(names: &[String], rate_hz: f64) -> bool {
    names == raw_rows::names() && (rate_hz / rate_of(&Plan::PAPER) - 1.0).abs() <= SCAN_OFF_MAX
}

/// Returns the command that fits a recording of any rate.
fn instead(samples: &Samples, options: Option<&str>) -> String {
    let Some(file) = samples.path() else {
        return "`fit` takes rows of any rate".into();
    };
    let file = match samples.name() {
        "standard input" => "-".to_owned(),
        _ => quoted(&file.display().to_string()),
    };
    let options = options.map_or(String::new(), |options| format!("{options} "));
    format!("`ridgetone fit {options}{file}` fits it")
}

fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/+:,@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[derive(Clone, Copy, Debug)]
struct Gap {
    /// Number of the row after the gap, from 1.
    row: u64,
    from_s: f64,
    to_s: f64,
    /// Time from the first row to the start of the gap, seconds.
    before_s: f64,
}

impl Gap {
    fn length_s(&self) -> f64 {
        self.to_s - self.from_s
    }

    /// True if the gap is far wider than the mean spacing of the rows before it.
    fn is_wide(&self) -> bool {
        let spacings = self.row.saturating_sub(2) as f64;
        self.length_s() * spacings > GAP_ROWS * self.before_s && spacings > 0.0
    }
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            row,
            from_s,
            to_s,
            before_s,
        } = self;
        write!(
            f,
            "row {row} (time_s {to_s}): a gap of {} s behind {} s of data; `ridgetone fit --to {from_s}` fits the rows before it",
            significant(self.length_s(), 6),
            significant(*before_s, 4)
        )
    }
}

/// Result of one pass over the rows.
#[derive(Default)]
struct Survey {
    head: Vec<f64>,
    clock: Option<RowClock>,
    /// Copy of the clock before its first row, for later passes.
    numbers: Option<RowClock>,
    rows: u64,
    last: u64,
    largest: Option<Largest>,
}

impl Survey {
    fn read(
        &mut self,
        rows: &mut dyn RowReader,
        reading: Reading,
        progress: &mut Progress,
    ) -> Result<()> {
        let (mut values, mut before_s) = (Vec::new(), None);
        let (mut first_s, mut widest) = (None, None::<Gap>);
        while rows.advance()? {
            rows.values(&mut values)?;
            self.rows += 1;
            if self.rows.is_multiple_of(PROGRESS_ROWS) {
                progress.show(format_args!("{} rows checked", self.rows));
            }
            self.look_at(&values);
            if reading.rate_hz.is_some() {
                self.last = self.rows - 1;
                continue;
            }
            let t_s = match (rows.time_s(), rows.timing()) {
                (Some(t_s), _) => t_s,
                (None, Timing::Absent(why) | Timing::Unclear(why)) => {
                    bail!("{}: {why}", rows.file())
                }
                (None, Timing::Stamped) => bail!("{}: a row has no time", rows.file()),
            };
            let begin_s = *first_s.get_or_insert(t_s);
            if let Some(from_s) = before_s {
                check_order(rows, from_s, t_s)?;
                let gap = Gap {
                    row: self.rows,
                    from_s,
                    to_s: t_s,
                    before_s: from_s - begin_s,
                };
                if gap.is_wide() && gap.length_s() > GAP_MAX_S {
                    bail!("{}: {gap}", rows.file());
                }
                if widest.is_none_or(|widest| gap.length_s() > widest.length_s()) {
                    widest = Some(gap);
                }
            }
            before_s = Some(t_s);
            self.push(t_s);
        }
        if let (Some(gap), Some(first_s), Some(last_s)) = (widest, first_s, before_s) {
            let is_pause = gap.length_s() > GAP_FRACTION_MAX * (last_s - first_s);
            ensure!(!(gap.is_wide() && is_pause), "{}: {gap}", rows.file());
        }
        self.start_clock();
        Ok(())
    }

    fn look_at(&mut self, values: &[f64]) {
        for (column, value) in values.iter().enumerate() {
            let is_larger = |largest: Largest| value.abs() > largest.value.abs();
            if !value.is_nan() && self.largest.is_none_or(is_larger) {
                self.largest = Some(Largest {
                    row: self.rows,
                    column,
                    value: *value,
                });
            }
        }
    }

    fn push(&mut self, t_s: f64) {
        match &mut self.clock {
            Some(clock) => self.last = clock.push(t_s),
            None => self.head.push(t_s),
        }
        if self.head.len() == HEAD_ROWS {
            self.start_clock();
        }
    }

    /// Starts the clock from the first rows, and numbers these rows.
    fn start_clock(&mut self) {
        if self.clock.is_some() || self.head.is_empty() {
            return;
        }
        self.numbers = RowClock::new(&self.head);
        self.clock = self.numbers;
        if let Some(clock) = &mut self.clock {
            for t_s in self.head.drain(..) {
                self.last = clock.push(t_s);
            }
        }
    }

    /// Returns the rows per second, and their relative standard deviation.
    fn rate(&self, reading: Reading) -> Result<Option<(f64, f64)>> {
        if let Some(rate_hz) = reading.rate_hz {
            return Ok(Some((rate_hz, 0.0)));
        }
        Ok(self.clock.and_then(|clock| {
            let spacing_s = clock.spacing_s();
            let is_rate = spacing_s > 0.0 && spacing_s.is_finite();
            is_rate.then(|| (spacing_s.recip(), clock.spacing_sigma_s(0.0) / spacing_s))
        }))
    }
}
