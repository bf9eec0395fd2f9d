//! `fit --window`: fits a recording of any length in windows, on all cores. Only rows of the
//! windows being fitted are in memory.

use crate::part::{Part, Selection, columns, given_rate_hz, push_row};
use crate::table_fit::{TableFit, TableHead, fit_part};
use crate::tables::{RowReader, check_order};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::mpsc::{channel, sync_channel};
use std::thread;

/// Duration of a row relative to the mean spacing, with a margin for rounded stamps.
const ROW_LENGTH: f64 = 1.001;

/// Length and stride of windows, seconds.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    pub window_s: f64,
    pub stride_s: f64,
}

/// A window and its fit, or the reason why there is none.
pub struct Window {
    pub from_s: f64,
    pub fit: Result<TableFit>,
}

/// Fits all complete windows in order, and skips those without a row. `progress` takes the number
/// of rows read so far.
pub fn fit(
    rows: &mut dyn RowReader,
    selection: &Selection,
    steps: Steps,
    take: &mut dyn FnMut(Window) -> Result<()>,
    progress: &mut dyn FnMut(u64),
) -> Result<()> {
    let chosen = columns(rows, selection)?;
    let table = TableHead::of(rows);
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let (jobs, queue) = sync_channel::<(u64, Part)>(2 * workers);
    let (done, fits) = channel();
    let queue = Mutex::new(queue);
    thread::scope(|scope| {
        for _ in 0..workers {
            let (queue, table, chosen, done) = (&queue, &table, &chosen, done.clone());
            scope.spawn(move || {
                loop {
                    // Release the lock before the work.
                    let next = queue.lock().map(|queue| queue.recv());
                    let Ok(Ok((number, part))) = next else {
                        break;
                    };
                    let window = Window {
                        from_s: part.times_s[0],
                        fit: fit_part(table, &part, chosen, selection),
                    };
                    if done.send((number, window)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        let (mut sent, mut given, mut waiting) = (0, 0, BTreeMap::new());
        let mut in_order = |number, window| {
            waiting.insert(number, window);
            while let Some(window) = waiting.remove(&given) {
                given += 1;
                take(window)?;
            }
            anyhow::Ok(())
        };
        let mut cutter = Cutter::new(rows, selection, steps)?;
        while let Some(part) = cutter.next(progress)? {
            jobs.send((sent, part)).context("no thread fits windows")?;
            sent += 1;
            for (number, window) in fits.try_iter() {
                in_order(number, window)?;
            }
        }
        drop(jobs);
        for (number, window) in fits {
            in_order(number, window)?;
        }
        ensure!(
            sent > 0,
            "{}: its rows fill no window of {} s: choose a shorter --window",
            table.file(),
            steps.window_s
        );
        Ok(())
    })
}

/// Rounds a positive number down to two significant digits.
fn two_digits_below(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let digits = 1 - value.log10().floor() as i32;
    let unit = 10_f64.powi(digits);
    (value * unit + 1e-6).floor() / unit
}

struct Cutter<'a> {
    rows: &'a mut dyn RowReader,
    selection: &'a Selection,
    steps: Steps,
    read: u64,
    /// Values of the last row read.
    row: Vec<f64>,
    /// Times in seconds of the rows that the next window may need, and their values by column.
    times_s: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Number in the file of the first row in `times_s`.
    first: u64,
    /// Time of the first row of the part.
    begin_s: Option<f64>,
    /// Number of the next window.
    number: u64,
    is_over: bool,
}

impl<'a> Cutter<'a> {
    fn new(rows: &'a mut dyn RowReader, selection: &'a Selection, steps: Steps) -> Result<Self> {
        ensure!(
            steps.window_s > 0.0 && steps.stride_s > 0.0,
            "--window and --stride must be greater than 0 s"
        );
        Ok(Self {
            columns: vec![Vec::new(); rows.names().len()],
            rows,
            selection,
            steps,
            read: 0,
            row: Vec::new(),
            times_s: Vec::new(),
            first: 0,
            begin_s: None,
            number: 0,
            is_over: false,
        })
    }

    /// Returns the next window that has a row.
    fn next(&mut self, progress: &mut dyn FnMut(u64)) -> Result<Option<Part>> {
        loop {
            let from_s = self
                .begin_s
                .map(|begin_s| begin_s + self.number as f64 * self.steps.stride_s);
            if let Some(from_s) = from_s {
                self.forget_before(from_s);
                let to_s = from_s + self.steps.window_s;
                let reaches = |last_s: f64| last_s >= to_s;
                if self.times_s.last().copied().is_some_and(reaches) {
                    self.check_stride()?;
                    if let Some(part) = self.cut(from_s, to_s) {
                        return Ok(Some(part));
                    }
                    continue;
                }
                if self.is_over {
                    let ends_s = self.times_s.last().map(|last_s| last_s + self.row_s());
                    if !ends_s.is_some_and(reaches) {
                        return Ok(None);
                    }
                    self.check_stride()?;
                    return Ok(self.cut(from_s, to_s));
                }
            } else if self.is_over {
                return Ok(None);
            }
            self.read_row(progress)?;
        }
    }

    fn row_s(&self) -> f64 {
        let (Some(first_s), Some(last_s)) = (self.times_s.first(), self.times_s.last()) else {
            return 0.0;
        };
        ROW_LENGTH * (last_s - first_s) / (self.times_s.len() - 1).max(1) as f64
    }

    /// Fails if the stride is shorter than the spacing of rows in the first window, because many
    /// windows would have the same rows.
    fn check_stride(&self) -> Result<()> {
        if self.number > 0 {
            return Ok(());
        }
        let spacings_s = self.times_s.windows(2).map(|pair| pair[1] - pair[0]);
        let mut spacings_s: Vec<f64> = spacings_s.collect();
        spacings_s.sort_by(f64::total_cmp);
        let spacing_s = spacings_s.get(spacings_s.len() / 2).copied();
        let shortest_s = two_digits_below(spacing_s.unwrap_or(0.0));
        ensure!(
            self.steps.stride_s >= shortest_s,
            "{}: a stride of {} s is shorter than a row: type --stride {shortest_s} or more",
            self.rows.file(),
            self.steps.stride_s
        );
        Ok(())
    }

    fn read_row(&mut self, progress: &mut dyn FnMut(u64)) -> Result<()> {
        if !self.rows.advance()? {
            self.is_over = true;
            return Ok(());
        }
        let stamp_s = self.rows.time_s();
        let t_s = match (stamp_s, self.selection.rate_hz) {
            (Some(stamp_s), None) => stamp_s,
            _ => self.read as f64 / given_rate_hz(self.rows, self.selection)?,
        };
        self.read += 1;
        if self.read.is_multiple_of(crate::tables::PROGRESS_ROWS) {
            progress(self.read);
        }
        if let (Some(before_s), None) = (self.times_s.last(), self.selection.rate_hz) {
            check_order(self.rows, *before_s, t_s)?;
        }
        if self.selection.to_s.is_some_and(|to_s| t_s > to_s) {
            self.is_over = true;
            return Ok(());
        }
        if self.selection.from_s.is_some_and(|from_s| t_s < from_s) {
            self.first = self.read;
            return Ok(());
        }
        self.rows.values(&mut self.row)?;
        push_row(&mut self.columns, &self.row);
        self.times_s.push(t_s);
        self.begin_s.get_or_insert(t_s);
        Ok(())
    }

    /// Returns the rows between two times, and advances the number of the next window. Windows
    /// without rows are skipped, up to the next row after a pause.
    fn cut(&mut self, from_s: f64, to_s: f64) -> Option<Part> {
        let start = self.times_s.partition_point(|t_s| *t_s < from_s);
        let end = self.times_s.partition_point(|t_s| *t_s < to_s);
        if start == end {
            let (next_s, begin_s) = (self.times_s.get(end)?, self.begin_s?);
            let first_with_it = (next_s - begin_s - self.steps.window_s) / self.steps.stride_s;
            self.number = (self.number + 1).max(first_with_it.floor().max(0.0) as u64);
            return None;
        }
        self.number += 1;
        let times_s = self.times_s[start..end].to_vec();
        let columns = self.columns.iter().map(|all| all[start..end].to_vec());
        let before = self.first + start as u64;
        Some(Part::of_rows(before, times_s, columns.collect()))
    }

    fn forget_before(&mut self, from_s: f64) {
        // Return early, because this is called for each row.
        if self.times_s.first().is_none_or(|t_s| *t_s >= from_s) {
            return;
        }
        let count = self.times_s.partition_point(|t_s| *t_s < from_s);
        // Keep the last row, to check that stamps increase.
        let count = count.min(self.times_s.len().saturating_sub(1));
        self.times_s.drain(..count);
        for column in &mut self.columns {
            column.drain(..count);
        }
        self.first += count as u64;
    }
}
