//! A run to look back at: a file, or a recording made on the page. Its samples are fitted as by
//! `fit`; telemetry also shows the board's state at any time.

use crate::digits::time_s;
use crate::fit_report;
use crate::frames::{Frames, Reading};
use crate::live::{Live, STRIP_FRAMES, point};
use crate::messages::{Form, Message, messages};
use crate::overview::Recorded;
use crate::samples::Samples;
use crate::seen::Seen;
use crate::table_fit::{Selection, TableFit};
use crate::tables::TableForm;
use crate::track::{Point, Track};
use crate::windows::{self, Steps, Window};
use crate::{fit_picture, touch_part};
use anyhow::{Error, Result, anyhow, bail, ensure};
use ridgetone_finger::Pipeline;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Hello, Packet, Raw, Span, Starts};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Advice on a run in which no slide was found.
const BY_HAND: &str = "select a part of the recording";

/// Maximum size in memory of a run that a page opens, in bytes: 3.5 hours of raw frames.
const MAX_BYTES: usize = 256 << 20;

/// Options for opening a file as a run.
#[derive(Clone, Debug)]
pub struct How {
    /// Settings that replace those of the board.
    pub settings: Option<Settings>,
    /// Rows per second of a table that does not state its times.
    pub rate_hz: Option<f64>,
    pub form: TableForm,
    /// True if the run was recorded here; its file is removed when the command ends.
    pub is_recorded: bool,
    /// Maximum size in memory, bytes.
    pub max_bytes: usize,
}

impl Default for How {
    /// Options for a file that a page sends.
    fn default() -> Self {
        Self {
            settings: None,
            rate_hz: None,
            form: TableForm::default(),
            is_recorded: false,
            max_bytes: MAX_BYTES,
        }
    }
}

/// A part of a run, in seconds of the run's time; without an end it extends to the end of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    pub from_s: Option<f64>,
    pub until_s: Option<f64>,
}

pub struct Run {
    pub name: String,
    pub path: PathBuf,
    form: Form,
    /// Rows per second of a table that does not state its times.
    rate_hz: Option<f64>,
    table: TableForm,
    /// Samples, read at the first use, or the reason why there are none.
    recorded: OnceLock<Result<Recorded, String>>,
    /// Fit of the whole run, or the reason why there is none.
    fit: OnceLock<Result<TableFit, String>>,
    /// All packets but raw frames, in order of arrival.
    packets: Vec<Packet>,
    frames: Vec<Raw>,
    /// A remark if frames were left out.
    remark: Option<String>,
    starts: Starts,
    /// Maximum size in memory.
    max_bytes: usize,
}

/// Key figures of a run, for a comparison with other runs.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub name: String,
    pub from_s: f64,
    pub until_s: f64,
    /// True if the run is a table and not telemetry.
    pub is_table: bool,
    pub frames: usize,
    pub touches: usize,
    /// Time of the first contact, seconds.
    pub contact_s: Option<f64>,
    /// Estimate of the latest whole slide; without one, the latest estimate with a tone.
    pub estimate: Option<crate::events::view::Estimate>,
    /// Reason why no window has an estimate.
    pub why_none: Option<String>,
    pub remark: Option<String>,
    /// The result of `fit`, as with `--json`.
    pub fit: Option<serde_json::Value>,
    /// Why there is no fit.
    pub no_fit: Option<String>,
}

/// A fit as the page shows it.
#[derive(Serialize)]
struct Fitted<'a> {
    #[serde(flatten)]
    fit: fit_report::Fit<'a>,
    /// Names and values, as `fit` prints them.
    lines: Vec<(&'static str, String)>,
    /// Guesses about the file's format.
    remark: Option<&'a str>,
}

impl Run {
    /// Opens a run. Telemetry that was exported or has new settings goes through the library first;
    /// other telemetry is read unchanged. Other files are tables.
    pub fn open(name: &str, path: &Path, how: &How) -> Result<Self> {
        let mut run = Self {
            name: name.to_owned(),
            path: path.to_owned(),
            form: Form::of(path).map_err(|error| anyhow!("{name}: {error}"))?,
            rate_hz: how.rate_hz,
            table: how.form.clone(),
            recorded: OnceLock::new(),
            fit: OnceLock::new(),
            packets: Vec::new(),
            frames: Vec::new(),
            remark: None,
            starts: Starts::new(),
            max_bytes: how.max_bytes,
        };
        let opened = run.read(how.settings);
        opened.map_err(|error| run.with_name(&error))?;
        Ok(run)
    }

    /// Replaces the path in an error by the name that the user knows.
    fn with_name(&self, error: &Error) -> Error {
        let text = format!("{error:#}").replace(&self.path.display().to_string(), &self.name);
        match text.starts_with(&self.name) {
            true => anyhow!(text),
            false => anyhow!("{}: {text}", self.name),
        }
    }

    fn read(&mut self, settings: Option<Settings>) -> Result<()> {
        match (self.form, settings) {
            (Form::Telemetry, None) => {
                for message in messages(&self.path, Form::Telemetry)? {
                    if let Message::Packet(packet, _) = message? {
                        self.take(*packet);
                        self.check_size()?;
                    }
                }
            }
            (Form::Table, None) => {
                self.recorded()?;
            }
            (Form::Table, Some(_)) => bail!("settings are for the frames of a board"),
            (_, settings) => self.replay(settings)?,
        }
        let has_time = self.form == Form::Table || self.ends_s().is_some();
        ensure!(has_time, "it holds nothing with a time");
        Ok(())
    }

    /// Returns the samples of the run, which are read at the first use.
    pub fn recorded(&self) -> Result<&Recorded> {
        let read = || {
            let samples = self.samples()?;
            Recorded::read(&samples, &self.selection(Part::default()), self.max_bytes)
        };
        let found = self
            .recorded
            .get_or_init(|| read().map_err(|error| self.with_name(&error).to_string()));
        found.as_ref().map_err(|why| anyhow!(why.clone()))
    }

    fn samples(&self) -> Result<Samples> {
        Samples::file_as(&self.path, self.table.clone())
    }

    fn selection(&self, part: Part) -> Selection {
        Selection {
            rate_hz: self.rate_hz,
            from_s: part.from_s,
            to_s: part.until_s,
            ..Selection::default()
        }
    }

    /// Fits a part, or the part that `fit` would choose.
    fn fit(&self, part: Part) -> Result<TableFit> {
        let fit = || {
            let samples = self.samples()?;
            touch_part::fit(&samples, &self.selection(part), false, &mut |_| {})
        };
        if part != Part::default() {
            return fit().map_err(|error| self.with_name(&error));
        }
        let found = self
            .fit
            .get_or_init(|| fit().map_err(|error| self.with_name(&error).to_string()));
        found.clone().map_err(|why| anyhow!(why))
    }

    /// Returns the fit of a part as one JSON object.
    pub fn fit_json(&self, part: Part) -> Result<serde_json::Value> {
        let fit = self.fit(part)?;
        Ok(serde_json::to_value(Fitted {
            fit: fit_report::object(&self.name, &fit),
            lines: fit_report::lines(&fit),
            remark: fit.guessed.as_deref(),
        })?)
    }

    /// Returns the frequency in windows over the run.
    pub fn track(&self, steps: Steps) -> Result<Track> {
        let samples = self.samples()?;
        let mut points = Vec::new();
        let mut take = |window: Window| {
            points.extend(Point::of(&window));
            Ok(())
        };
        let selection = self.selection(Part::default());
        windows::fit(
            &mut *samples.open()?,
            &selection,
            steps,
            &mut take,
            &mut |_| {},
        )
        .map_err(|error| self.with_name(&error))?;
        Ok(Track::new(points, self.recorded()?, steps.window_s))
    }

    /// Draws the fit of a part as SVG.
    pub fn fit_svg(&self, part: Part) -> Result<String> {
        let fit = self.fit(part)?;
        let samples = self.samples()?.named(&self.name);
        fit_picture::draw(&samples, &self.selection(part), &fit)
            .map_err(|error| self.with_name(&error))
    }

    /// Runs the raw frames through the library, as `replay` does.
    fn replay(&mut self, settings: Option<Settings>) -> Result<()> {
        let frames = Frames::open(&self.samples()?, Reading::default())?;
        let settings = Settings {
            plan: frames.plan(),
            vref_v: frames.settings.vref_v,
            ..settings.unwrap_or(frames.settings)
        };
        self.take(Packet {
            sequence: 0,
            event: Pipeline::new(settings).hello(),
        });
        let mut take = |packet: &Packet| {
            self.take(packet.clone());
            self.check_size()
        };
        frames.run(&settings, true, &mut take, &mut |_, _| {})
    }

    fn take(&mut self, packet: Packet) {
        if self.starts.take(&packet.event) {
            // The board has restarted, so the time axis starts again.
            self.packets.clear();
            self.frames.clear();
            self.remark =
                Some("the board restarted: this is what came after the last restart".into());
        }
        match packet.event {
            Event::Raw(raw) => self.frames.push(raw),
            _ => self.packets.push(packet),
        }
    }

    /// Fails if the run takes too much memory; a compressed file may expand to a large one.
    fn check_size(&self) -> Result<()> {
        let bytes = size_of_val(&*self.packets) + size_of_val(&*self.frames);
        ensure!(
            bytes <= self.max_bytes,
            "it takes more than {} MiB of memory: cut it into parts, or use `replay` or `export`",
            self.max_bytes >> 20
        );
        Ok(())
    }

    fn ends_s(&self) -> Option<(f64, f64)> {
        if self.form == Form::Table {
            return self.recorded().ok().map(Recorded::ends_s);
        }
        let frames = self
            .frames
            .first()
            .into_iter()
            .chain(self.frames.last())
            .map(raw_s);
        let times = self
            .packets
            .iter()
            .filter_map(|packet| time_s(&packet.event))
            .chain(frames);
        times.fold(None, |ends, t_s| {
            let (from_s, until_s) = ends.unwrap_or((t_s, t_s));
            Some((t_s.min(from_s), t_s.max(until_s)))
        })
    }

    pub fn summary(&self) -> Summary {
        let (from_s, until_s) = self.ends_s().unwrap_or_default();
        let (fit, no_fit) = match self.fit_json(Part::default()) {
            Ok(fit) => (Some(fit), None),
            Err(why) => (None, Some(why.to_string())),
        };
        let contacts = || {
            self.packets
                .iter()
                .filter(|packet| matches!(packet.event, Event::Contact(_)))
        };
        let estimates = || {
            let estimate = |packet: &'_ Packet| match &packet.event {
                Event::Estimate(found) if found.status.has_tone() => Some(point(found)),
                _ => None,
            };
            self.packets.iter().rev().filter_map(estimate)
        };
        let touches = match self.form {
            Form::Table => self.recorded().map_or(0, Recorded::contacts),
            _ => contacts().count(),
        };
        Summary {
            name: self.name.clone(),
            from_s,
            until_s,
            is_table: self.form == Form::Table,
            frames: self.frames.len(),
            touches,
            contact_s: contacts().next().and_then(|packet| time_s(&packet.event)),
            estimate: estimates()
                .find(|found| found.span == Span::Slide)
                .or_else(|| estimates().next()),
            why_none: self.why_none(),
            remark: self.remark.clone(),
            fit,
            no_fit,
        }
    }

    fn why_none(&self) -> Option<String> {
        let mut seen = Seen::default();
        for Packet { event, .. } in &self.packets {
            if !matches!(event, Event::Estimate(found) if found.span == Span::Slide) {
                seen.take(event);
            }
        }
        seen.why_no_estimate(self.settings().window_s, BY_HAND)
    }

    pub fn settings(&self) -> Settings {
        self.hello()
            .map_or(Settings::DEFAULT, |hello| hello.settings)
    }

    fn hello(&self) -> Option<&Hello> {
        self.packets
            .iter()
            .rev()
            .find_map(|packet| match &packet.event {
                Event::Hello(hello) => Some(hello),
                _ => None,
            })
    }

    pub fn at(&self, t_s: f64) -> Live {
        let mut live = Live::new(self.name.clone());
        let is_past = |packet: &&Packet| time_s(&packet.event).is_none_or(|then_s| then_s <= t_s);
        self.packets
            .iter()
            .filter(is_past)
            .for_each(|packet| live.take(packet));
        let end = self.frames.partition_point(|raw| raw_s(raw) <= t_s);
        for raw in &self.frames[end.saturating_sub(STRIP_FRAMES)..end] {
            live.take(&Packet {
                sequence: 1,
                event: Event::Raw(*raw),
            });
        }
        live.now.now_s = Some(t_s);
        live
    }
}

fn raw_s(raw: &Raw) -> f64 {
    raw.t_us as f64 * 1e-6
}
