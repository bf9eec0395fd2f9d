//! Joins positions logged by a robot to the raw frames of a recording: `fit --positions`.
//!
//! The robot's times are UTC or device time. Device time is converted to UTC with the times at
//! which packets were received ([`crate::utc`]). Between the robot's rows the position is a cubic;
//! its slope at a row is that of the polynomial through the five nearest rows.

use crate::alignment::Alignment;
use crate::messages::{Form, Message, messages};
use crate::part::Selection;
use crate::samples::Samples;
use crate::speed::{Column, Quantity};
use crate::tables::{RowReader, TimeColumn};
use crate::utc::UtcClock;
use anyhow::{Context, Result, bail, ensure};
use hal_mock::FileError;
use ridgetone_proto::plan::{Plan, Sampling};
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Event, Starts};
use std::path::PathBuf;
use std::sync::Arc;

/// Name of the column added to the frames.
const JOINED: &str = "position_mm";

/// Times from here on are UTC, seconds since 1970; earlier ones are device time.
const UTC_FROM_S: f64 = 1e9;

/// Longest time without a row, seconds. A hand that moves to and fro at 1.07 Hz can deviate by 7 mm
/// from constant speed in this time. Slow logs may have gaps of four times their usual spacing.
const GAP_S: f64 = 0.1;
const GAP_SPACINGS: f64 = 4.0;

/// Number of rows on each side that the polynomial for the slope at a row uses.
const SIDE: usize = 2;

/// Delay in seconds of the low-pass of the bridges on all boards: 820 ohm parallel to 820 ohm, with
/// 1 uF.
const LOW_PASS_S: f64 = 0.41e-3;

/// Standard deviation in seconds of delays that the clocks cannot reveal: the minimum delay of a
/// USB adapter, up to 1 ms, and the tolerance of the low-pass.
const DELAY_SIGMA_S: f64 = 0.5e-3;

/// Device time between two points at which the clocks are compared, seconds.
const RELATION_S: f64 = 10.0;

/// Maximum number of points at which the clocks are compared: a recording of four months.
const RELATIONS_MAX: f64 = 1e6;

/// A file of positions, and how to read it.
#[derive(Clone, Debug)]
pub struct PositionFile {
    pub path: PathBuf,
    /// Column of the positions or speeds; `None` means the one whose name begins with `position` or
    /// `speed`.
    pub column: Option<Column>,
    /// Column of the times, if it cannot be recognised by its name.
    pub time: Option<TimeColumn>,
}

impl PositionFile {
    /// Joins the positions to a recording's frames. Returns the frames for which there are
    /// positions, with a position column, and a selection that fits in the spatial domain.
    pub fn join(&self, samples: &Samples, selection: &Selection) -> Result<(Samples, Selection)> {
        let track = Track::load(self)?;
        let board = Board::read(samples)?;
        let (clock, clock_sigma_s) = board.clock(&track)?;
        let joined = Arc::new(Joined {
            track,
            clock,
            after_s: board.middle_s() - LOW_PASS_S,
        });
        joined.check_overlap(samples.name(), board.frames_s.0, board.frames_s.1)?;
        let mut selection = selection.clone();
        selection.position = Some(Column::millimetres(JOINED));
        selection.alignment = Some(Alignment {
            file: joined.track.file.clone(),
            skew_frames: board.skew_frames(),
            low_pass_s: LOW_PASS_S,
            sigma_s: clock_sigma_s.hypot(DELAY_SIGMA_S),
        });
        let samples = samples.with_rows(Arc::new(move |rows| {
            let mut names = rows.names().to_vec();
            names.push(JOINED.to_owned());
            Box::new(JoinedRows {
                rows,
                names,
                joined: Arc::clone(&joined),
            })
        }));
        Ok((samples, selection))
    }
}

/// A row of a robot's log: time, position and speed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    t_s: f64,
    mm: f64,
    mm_s: f64,
}

/// A robot's positions over the time of its own clock.
#[derive(Debug)]
struct Track {
    file: String,
    knots: Vec<Knot>,
    gap_s: f64,
}

impl Track {
    fn load(from: &PositionFile) -> Result<Self> {
        let samples = Samples::file_with(&from.path, from.time.clone())?;
        let mut rows = samples.open()?;
        let file = samples.name().to_owned();
        let column = match &from.column {
            Some(column) => column.clone(),
            None => Column::found(rows.names()).map_err(|why| anyhow::anyhow!("{file}: {why}"))?,
        };
        let at = crate::part::named(&*rows, column.name())?;
        let (mut times_s, mut values, mut row) = (Vec::<f64>::new(), Vec::new(), Vec::new());
        while rows.advance()? {
            let t_s = rows.time_s().with_context(|| {
                format!("{file}: no column is the time: name one utc_s, or give --time-column")
            })?;
            if let Some(before_s) = times_s.last()
                && t_s <= *before_s
            {
                bail!("{file}: time {t_s} after {before_s}: times must increase");
            }
            rows.values(&mut row)?;
            // Treat a missing reading as a missing row.
            if !row[at].is_nan() {
                times_s.push(t_s);
                values.push(row[at]);
            }
        }
        ensure!(
            times_s.len() > 1,
            "{file}: column {}: fewer than two values",
            column.name()
        );
        let unit_mm = column.mm_per_unit(&values);
        let unit_mm = unit_mm.map_err(|why| anyhow::anyhow!("{file}: {why}"))?;
        values.iter_mut().for_each(|value| *value *= unit_mm);
        Ok(Self::new(file, &times_s, &values, column.quantity()))
    }

    fn new(file: String, times_s: &[f64], values: &[f64], quantity: Quantity) -> Self {
        let slopes: Vec<f64> = (0..times_s.len())
            .map(|row| slope(times_s, values, row))
            .collect();
        let mut knots = Vec::with_capacity(times_s.len());
        let mut mm = 0.0;
        for (row, (t_s, value)) in times_s.iter().zip(values).enumerate() {
            let (mm, mm_s) = match quantity {
                Quantity::Position => (*value, slopes[row]),
                Quantity::Speed => {
                    if row > 0 {
                        // Add the integral of the cubic between the two rows.
                        let step_s = t_s - times_s[row - 1];
                        let bend = (slopes[row - 1] - slopes[row]) * step_s / 12.0;
                        mm += step_s * (0.5 * (values[row - 1] + value) + bend);
                    }
                    (mm, *value)
                }
            };
            knots.push(Knot {
                t_s: *t_s,
                mm,
                mm_s,
            });
        }
        let mut steps_s: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps_s.sort_by(f64::total_cmp);
        let gap_s = GAP_S.max(GAP_SPACINGS * steps_s[steps_s.len() / 2]);
        Self { file, knots, gap_s }
    }

    fn range_s(&self) -> (f64, f64) {
        (self.knots[0].t_s, self.knots[self.knots.len() - 1].t_s)
    }

    fn is_utc(&self) -> bool {
        self.knots[0].t_s >= UTC_FROM_S
    }

    /// Returns the position at a time; NaN before the first row, after the last row and in a gap.
    fn mm(&self, t_s: f64) -> f64 {
        let next = self.knots.partition_point(|knot| knot.t_s <= t_s);
        let from = match next.checked_sub(1) {
            Some(before) => self.knots[before],
            None => return f64::NAN,
        };
        let Some(to) = self.knots.get(next) else {
            return if t_s == from.t_s { from.mm } else { f64::NAN };
        };
        let step_s = to.t_s - from.t_s;
        if step_s > self.gap_s {
            return f64::NAN;
        }
        let u = (t_s - from.t_s) / step_s;
        let (rise, left, right) = (to.mm - from.mm, step_s * from.mm_s, step_s * to.mm_s);
        from.mm
            + u * (left + u * (3.0 * rise - 2.0 * left - right + u * (left + right - 2.0 * rise)))
    }
}

/// Returns the slope at a row, from the polynomial through the row and its nearest neighbours.
fn slope(times_s: &[f64], values: &[f64], row: usize) -> f64 {
    let last = times_s.len() - 1;
    let from = row.saturating_sub(SIDE).min(last.saturating_sub(2 * SIDE));
    let near = || (from..=last.min(from + 2 * SIDE)).filter(|other| *other != row);
    // Derivative of the Lagrange polynomial: a weighted sum of the chords to the neighbours.
    near()
        .map(|at| {
            let chord = (values[at] - values[row]) / (times_s[at] - times_s[row]);
            let weights = near()
                .filter(|other| *other != at)
                .map(|other| (times_s[other] - times_s[row]) / (times_s[other] - times_s[at]));
            chord * weights.product::<f64>()
        })
        .sum()
}

struct Board {
    name: String,
    clock: UtcClock,
    has_receipts: bool,
    plan: Plan,
    /// Device time of the recording's first and last raw frame.
    frames_s: (f64, f64),
}

impl Board {
    /// Reads a recording up to its end, or up to a restart of the board.
    fn read(samples: &Samples) -> Result<Self> {
        let name = samples.name().to_owned();
        let path = samples.path().map(|path| (path, Form::of(path)));
        let Some((path, Ok(Form::Telemetry))) = path else {
            bail!(
                "{name}: --positions is for recordings of a board, as `ridgetone record --raw` writes them; in a table give the column of the positions with --position-column"
            );
        };
        let (mut clock, mut starts) = (UtcClock::default(), Starts::new());
        let (mut plan, mut frames_s, mut has_receipts) = (None, None, false);
        for message in messages(path, Form::Telemetry)? {
            let Message::Packet(packet, receipt) = message? else {
                continue;
            };
            if starts.take(&packet.event) {
                break;
            }
            if let Some(receipt) = receipt {
                has_receipts = true;
                clock.take(&packet, receipt);
            }
            match &packet.event {
                Event::Hello(hello) => {
                    let now = hello.settings.plan;
                    ensure!(
                        *plan.get_or_insert(now) == now,
                        "{name}: the plan changes in this recording: record each plan by itself"
                    );
                }
                Event::Raw(raw) => {
                    let t_s = raw.t_us as f64 * 1e-6;
                    frames_s.get_or_insert((t_s, t_s)).1 = t_s;
                }
                _ => {}
            }
        }
        Ok(Self {
            frames_s: frames_s.with_context(|| {
                format!("{name}: no raw frames: record with `ridgetone record --raw`")
            })?,
            plan: plan.with_context(|| format!("{name}: no greeting, which has the plan"))?,
            name,
            clock,
            has_receipts,
        })
    }

    /// Returns the relation of the board's clock to a track's, and its standard deviation, seconds.
    fn clock(&self, track: &Track) -> Result<(Clock, f64)> {
        if !track.is_utc() {
            return Ok((Clock::default(), 0.0));
        }
        let Self { name, .. } = self;
        ensure!(
            self.has_receipts,
            "{name}: has no times of receipt, so that positions in UTC cannot be aligned: give them in device time, time_s"
        );
        let (first_s, last_s) = self.frames_s;
        // Limit the number of steps, which a damaged time could make arbitrarily large.
        let steps = ((last_s - first_s) / RELATION_S)
            .ceil()
            .clamp(1.0, RELATIONS_MAX);
        let (mut relations, mut max_s) = (Vec::new(), 0f64);
        for step in 0..=steps as usize {
            let t_s = first_s + (last_s - first_s) * step as f64 / steps;
            let utc = self.clock.utc(t_s);
            let sigma_s = utc.and_then(|utc| utc.sigma_s);
            let (Some(utc), Some(sigma_s)) = (utc, sigma_s) else {
                bail!("{name}: too short to align its clock: record 0.5 s or more");
            };
            relations.push((t_s, utc.utc_s() - t_s));
            max_s = max_s.max(sigma_s);
        }
        Ok((Clock { relations }, max_s))
    }

    /// Returns the time in seconds from a frame's stamp to the middle of its conversions, where the
    /// frame's position is evaluated.
    fn middle_s(&self) -> f64 {
        match self.plan.sampling {
            Sampling::InTurn => {
                0.5e-9
                    * f64::from(self.plan.inputs.count_ones().saturating_sub(1))
                    * f64::from(self.plan.conversion_ns())
            }
            Sampling::AtOnce => 0.0,
        }
    }

    fn skew_frames(&self) -> [f32; TAXELS] {
        let Plan {
            inputs, sampling, ..
        } = self.plan;
        let middle = 0.5 * (inputs.count_ones().max(1) - 1) as f32;
        let slots = self.plan.slots() as f32;
        std::array::from_fn(|taxel| match sampling {
            Sampling::InTurn if inputs >> taxel & 1 != 0 => {
                let before = (inputs & ((1 << taxel) - 1)).count_ones();
                (before as f32 - middle) / slots
            }
            _ => 0.0,
        })
    }
}

/// Differences in seconds of two clocks at device times, interpolated linearly. If there are none,
/// the clocks are equal.
#[derive(Debug, Default)]
struct Clock {
    relations: Vec<(f64, f64)>,
}

impl Clock {
    fn time_s(&self, t_s: f64) -> f64 {
        let next = self.relations.partition_point(|(at_s, _)| *at_s <= t_s);
        let next = next.clamp(1, self.relations.len().max(2) - 1);
        match self.relations.get(next - 1..=next) {
            Some(&[(from_s, from), (to_s, to)]) if to_s > from_s => {
                t_s + from + (to - from) * (t_s - from_s) / (to_s - from_s)
            }
            _ => {
                t_s + self
                    .relations
                    .first()
                    .map_or(0.0, |(_, offset_s)| *offset_s)
            }
        }
    }
}

/// A track, and the relation of the frames' times to its times.
#[derive(Debug)]
struct Joined {
    track: Track,
    clock: Clock,
    /// Time added to a frame's stamp, seconds.
    after_s: f64,
}

impl Joined {
    /// Converts a frame's time to the time of the track's clock.
    fn time_s(&self, t_s: f64) -> f64 {
        self.clock.time_s(t_s + self.after_s)
    }

    fn check_overlap(&self, recording: &str, first_s: f64, last_s: f64) -> Result<()> {
        let (first_s, last_s) = (self.time_s(first_s), self.time_s(last_s));
        let (from_s, to_s) = self.track.range_s();
        let unit = if self.track.is_utc() {
            "s since 1970"
        } else {
            "s of device time"
        };
        ensure!(
            first_s < to_s && last_s > from_s,
            "{recording} and {} do not overlap in time: the frames go from {first_s:.3} to {last_s:.3}, the positions from {from_s:.3} to {to_s:.3} {unit}",
            self.track.file
        );
        Ok(())
    }
}

/// Rows within the time range of a track, with a column of positions added.
struct JoinedRows {
    rows: Box<dyn RowReader + Send>,
    names: Vec<String>,
    joined: Arc<Joined>,
}

impl JoinedRows {
    fn mm(&self) -> f64 {
        let time_s = self.rows.time_s();
        time_s.map_or(f64::NAN, |t_s| {
            self.joined.track.mm(self.joined.time_s(t_s))
        })
    }
}

impl RowReader for JoinedRows {
    fn file(&self) -> &str {
        self.rows.file()
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        let (from_s, to_s) = self.joined.track.range_s();
        while self.rows.advance()? {
            let t_s = self.rows.time_s().unwrap_or(f64::NAN);
            let t_s = self.joined.time_s(t_s);
            if t_s > to_s {
                return Ok(false);
            }
            if t_s >= from_s {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn time_s(&self) -> Option<f64> {
        self.rows.time_s()
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        self.rows.values(values)?;
        values.push(self.mm());
        Ok(())
    }

    fn guessed(&self) -> Option<String> {
        self.rows.guessed()
    }
}
