//! Recordings as frames for the library: raw frames from a board, or the rows of a table at their
//! own rate and with their own number of channels. Without a simulated chip, nothing is resampled,
//! and only events that follow from the frames are reported.

mod board;
mod frame;
mod table;

use crate::events::Columns;
use crate::messages::Form;
use crate::output::Progress;
use crate::samples::Samples;
use crate::stop;
use crate::tables::RowReader;
use crate::touch_times::Touches;
use crate::usage::UsageError;
use anyhow::{Result, ensure};
use board::Board;
use frame::Frame;
pub use frame::Reading;
use ridgetone_finger::{Detector, Diagnostics, Outputs, Pipeline, Ring};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Track};
use std::ops::ControlFlow;
use table::Table;

/// Number of frames between two reports of progress.
const PROGRESS_EVERY: u64 = 4096;

enum Source {
    Board(Board),
    Table(Box<Table>),
}

/// A recording whose frames can be run through the library more than once.
pub struct Frames {
    source: Source,
    /// Settings to start from: those of the board, or the library's with the table's own plan.
    pub settings: Settings,
    pub length_s: f64,
}

impl Frames {
    /// Reads a recording once. Fails, with advice on how to fit it instead, unless it has 1 to 16
    /// channels sampled steadily at a rate that the library accepts.
    pub fn open(samples: &Samples, reading: Reading) -> Result<Self> {
        let board = samples
            .path()
            .and_then(|path| Some((path, Form::of(path).ok()?)))
            .filter(|(_, form)| *form != Form::Table);
        if let Some((path, form)) = board {
            if reading != Reading::default() {
                let why = format!(
                    "{}: --rate and --scale are for tables: telemetry has its own time and volts",
                    samples.name()
                );
                return Err(UsageError(why).into());
            }
            let (board, settings, length_s) = Board::open(samples.name(), path, form)?;
            return Ok(Self {
                source: Source::Board(board),
                settings,
                length_s,
            });
        }
        let table = Table::open(samples, reading)?;
        Ok(Self {
            settings: table.settings(),
            length_s: table.length_s(),
            source: Source::Table(Box::new(table)),
        })
    }

    /// Returns the plan of the recording, which no settings can change.
    pub fn plan(&self) -> Plan {
        self.settings.plan
    }

    /// Returns remarks on how a table was read: guesses, and values beyond the reference.
    pub fn remarks(&self, settings: &Settings) -> Vec<String> {
        match &self.source {
            Source::Board(_) => Vec::new(),
            Source::Table(table) => {
                let beyond = table.beyond(settings.vref_v.into());
                table.guessed().into_iter().chain(beyond).collect()
            }
        }
    }

    /// Returns the columns of a table, unless they are the taxels of a board.
    pub fn columns(&self) -> Option<Columns> {
        match &self.source {
            Source::Table(table) if !table.is_of_board() => Some(table.columns()),
            _ => None,
        }
    }

    pub fn check_window(&self, name: &str, settings: &Settings) -> Result<()> {
        let (length_s, window_s) = (self.length_s, settings.window_s);
        ensure!(
            length_s >= f64::from(window_s),
            "{name}: {length_s:.3} s of data do not fill a window of {window_s} s: choose a shorter one (--window)"
        );
        Ok(())
    }

    /// Returns the settings, with the whole table as one slide if no touch is detected in it.
    /// Values beyond the reference could hide a touch, so the settings then stay unchanged.
    pub fn settings_for(&self, settings: Settings) -> Result<Settings> {
        let Source::Table(table) = &self.source else {
            return Ok(settings);
        };
        let is_always = settings.slide.rule == SlideRule::Always;
        if is_always || table.beyond(settings.vref_v.into()).is_some() {
            return Ok(settings);
        }
        let mut has_touch = false;
        if !table.may_be_volts() {
            return Ok(always(settings));
        }
        self.detect(&settings, &mut |event| {
            has_touch |= matches!(event, Event::Contact(_) | Event::Slide(_));
            match has_touch {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        })?;
        if has_touch {
            return Ok(settings);
        }
        Ok(always(settings))
    }

    /// Finds touches in a table of volts by touch detection alone; times are seconds from its first
    /// row, and slides count only after a contact.
    pub fn touches(&self) -> Result<Touches> {
        if let Source::Table(table) = &self.source {
            let beyond = table.beyond(self.settings.vref_v.into());
            ensure!(beyond.is_none(), "values outside the ADC's range");
        }
        let mut touches = Touches::default();
        self.detect(&self.settings, &mut |event| {
            if !touches.contacts_s.is_empty() || matches!(event, Event::Contact(_)) {
                touches.take(&event);
            }
            ControlFlow::Continue(())
        })?;
        Ok(touches)
    }

    /// Runs all frames through the library with settings that have passed [`Settings::validate`],
    /// and passes the numbered packets to `sink`; with `raw`, also one for every frame. Ends early
    /// when this process is asked to stop.
    pub fn run(
        &self,
        settings: &Settings,
        raw: bool,
        sink: &mut dyn FnMut(&Packet) -> Result<()>,
        progress: &mut dyn FnMut(f64, f64),
    ) -> Result<()> {
        let new = || {
            let mut pipeline = Box::new(Pipeline::new(*settings));
            pipeline.report_raw(if raw { u32::MAX } else { 0 });
            pipeline
        };
        let (mut pipeline, mut sequence, mut count) = (new(), 0u16, 0u64);
        let mut failure = None;
        let mut send = |mut event: Event| {
            if failure.is_some() || !self.is_of_frames(&event) {
                return;
            }
            self.enlarge(&mut event);
            let packet = Packet { sequence, event };
            sequence = sequence.wrapping_add(1);
            failure = sink(&packet).err();
        };
        self.each(&mut |frame| {
            let t_us = match frame {
                Frame::Raw(raw) => {
                    pipeline.push_raw(&raw, &mut send);
                    raw.t_us
                }
                Frame::Plain(frame) => {
                    pipeline.push_frame(frame, &mut send);
                    frame.t_us
                }
                Frame::Restart => {
                    pipeline.finish(&mut send);
                    pipeline = new();
                    0
                }
            };
            count += 1;
            if count.is_multiple_of(PROGRESS_EVERY) {
                progress(t_us as f64 * 1e-6, self.length_s);
            }
            match stop::is_requested() {
                true => Ok(ControlFlow::Break(())),
                false => Ok(ControlFlow::Continue(())),
            }
        })?;
        pipeline.finish(&mut send);
        failure.map_or(Ok(()), Err)
    }

    /// True if an event follows from the frames alone. A table has no firmware, health or faults,
    /// and only a board's columns have positions on a finger.
    fn is_of_frames(&self, event: &Event) -> bool {
        match event {
            Event::Hello(_) | Event::Health(_) | Event::Converter(_) | Event::Fault(_) => false,
            Event::Image(_) => match &self.source {
                Source::Board(_) => true,
                Source::Table(table) => table.is_of_board(),
            },
            _ => true,
        }
    }

    /// Adds the uncertainty of the table's rate to that of an estimate.
    fn enlarge(&self, event: &mut Event) {
        if let (
            Source::Table(table),
            Event::Estimate(Estimate {
                sigma, frequency, ..
            })
            | Event::Track(Track {
                sigma, frequency, ..
            }),
        ) = (&self.source, event)
        {
            *sigma = sigma.hypot(table.rate_fraction() as f32 * *frequency);
        }
    }

    /// Runs touch detection alone, and passes the events to `take` until it breaks.
    fn detect(
        &self,
        settings: &Settings,
        take: &mut dyn FnMut(Event) -> ControlFlow<()>,
    ) -> Result<()> {
        let mut detector = Box::new(Detector::new(*settings));
        let (mut ring, diagnostics) = (Box::new(Ring::new()), Diagnostics::new());
        let (mut is_over, mut count) = (false, 0u64);
        let mut emit = |event| {
            if !is_over {
                is_over = take(event).is_break();
            }
        };
        let mut progress = Progress::default();
        let ended = self.each(&mut |frame| {
            ensure!(!stop::is_requested(), "interrupted");
            let outputs = &mut Outputs {
                emit: &mut emit,
                due: &mut |_| {},
            };
            match frame {
                Frame::Raw(raw) => detector.push_raw(&raw, &mut ring, &diagnostics, outputs),
                Frame::Plain(frame) => {
                    detector.push_frame(frame, &mut ring, &diagnostics, outputs);
                    count += 1;
                    if count.is_multiple_of(PROGRESS_EVERY) {
                        let (done_s, length_s) = (frame.t_us as f64 * 1e-6, self.length_s);
                        progress.show(format_args!(
                            "looking for a touch: {done_s:.1} of {length_s:.1} s"
                        ));
                    }
                }
                Frame::Restart => {}
            }
            Ok(ControlFlow::Continue(()))
        });
        progress.end();
        ended?;
        detector.finish(&mut ring, &diagnostics, &mut emit, &mut |_| {});
        Ok(())
    }

    /// Passes every frame to `take` until it breaks or fails.
    fn each(&self, take: &mut dyn FnMut(Frame<'_>) -> Result<ControlFlow<()>>) -> Result<()> {
        match &self.source {
            Source::Board(board) => board.each(take),
            Source::Table(table) => table.each(take),
        }
    }
}

/// Minimum number of channels of a finger; a table with fewer is from a different instrument.
const TOUCH_CHANNELS_MIN: usize = 4;

/// True if columns may be the taxels of a finger: four or more, in volts or without a unit.
pub fn may_be_touch(rows: &dyn RowReader, columns: &[usize]) -> bool {
    columns.len() >= TOUCH_CHANNELS_MIN && may_be_volts(rows, columns)
}

/// True if columns are in volts or without a unit.
fn may_be_volts(rows: &dyn RowReader, columns: &[usize]) -> bool {
    let units = rows.units();
    let is_volts = |unit: &Option<String>| {
        let unit = unit.as_deref().map(str::to_lowercase);
        matches!(unit.as_deref(), None | Some("v" | "volt" | "volts"))
    };
    columns.iter().all(|at| is_volts(&units[*at]))
}

/// Returns the settings with the whole recording as one slide.
fn always(settings: Settings) -> Settings {
    // The speed in the settings belongs to this recording only if it is that of a protocol.
    let speed_mm_s = match settings.slide.rule {
        SlideRule::Protocol => settings.slide.speed_mm_s,
        _ => 0.0,
    };
    let slide = Slide {
        rule: SlideRule::Always,
        speed_mm_s,
        ..settings.slide
    };
    Settings { slide, ..settings }
}

/// Remark on settings that [`Frames::settings_for`] has changed.
pub const ALWAYS: &str = "no finger touches: all of it is taken as a slide (slide.rule = always)";

#[cfg(test)]
mod tests;
