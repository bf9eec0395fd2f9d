//! A run to look back at: what a file holds, or what was recorded on the page, at any of its times.

use crate::digits::time_s;
use crate::frames::{Frames, Reading};
use crate::live::{Live, STRIP_FRAMES, point};
use crate::messages::{Form, Message, messages};
use crate::recording::no_telemetry;
use crate::samples::Samples;
use crate::seen::Seen;
use anyhow::{Result, anyhow, ensure};
use ridgetone_finger::Pipeline;
use ridgetone_finger::Window;
use ridgetone_finger::{Estimator, WindowFit};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Estimate, Event, Hello, Packet, Raw, Span, Starts};
use ridgetone_tone::{FRAMES_MAX, FRAMES_MIN, Table, Values};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What to do with a run without a slide.
const BY_HAND: &str = "mark a part, or press Fit all";

/// A part of a run, seconds of device time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    pub from_s: f64,
    pub until_s: f64,
}

#[derive(Clone, Debug)]
pub struct Run {
    pub name: String,
    pub path: PathBuf,
    /// All but raw frames, in the order of their arrival.
    packets: Vec<Packet>,
    frames: Vec<Raw>,
    /// A remark if frames were left out.
    remark: Option<String>,
    starts: Starts,
    /// Greatest size in memory.
    max_bytes: usize,
}

/// A run in a few numbers, to compare it with others.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub name: String,
    pub from_s: f64,
    pub until_s: f64,
    pub frames: usize,
    pub touches: usize,
    /// The first contact.
    pub contact_s: Option<f64>,
    /// The estimate of the latest whole slide; without one the latest with a tone.
    pub estimate: Option<crate::events::view::Estimate>,
    /// Why no window of it has an estimate.
    pub why_none: Option<String>,
    pub remark: Option<String>,
}

impl Run {
    /// Reads telemetry as it is; what `export` made of it, and telemetry with new `settings`, goes
    /// through the library first. A table is refused.
    pub fn open(
        name: &str,
        path: &Path,
        settings: Option<Settings>,
        max_bytes: usize,
    ) -> Result<Self> {
        let (packets, frames) = (Vec::new(), Vec::new());
        let mut run = Self {
            name: name.to_owned(),
            path: path.to_owned(),
            packets,
            frames,
            remark: None,
            starts: Starts::new(),
            max_bytes,
        };
        run.read(settings).map_err(|error| {
            // The name that people know, instead of the path.
            let text = format!("{error:#}").replace(&path.display().to_string(), name);
            if text.starts_with(name) {
                anyhow!(text)
            } else {
                anyhow!("{name}: {text}")
            }
        })?;
        Ok(run)
    }

    fn read(&mut self, settings: Option<Settings>) -> Result<()> {
        match (Form::of(&self.path)?, settings) {
            (Form::Telemetry, None) => {
                for message in messages(&self.path, Form::Telemetry)? {
                    if let Message::Packet(packet, _) = message? {
                        self.take(*packet);
                        self.check_size()?;
                    }
                }
            }
            (Form::Table, _) => return Err(no_telemetry(&self.path)),
            (_, settings) => self.replay(settings)?,
        }
        ensure!(self.ends_s().is_some(), "it holds nothing with a time");
        Ok(())
    }

    /// Runs the raw frames through the library, as `replay` does.
    fn replay(&mut self, settings: Option<Settings>) -> Result<()> {
        let frames = Frames::open(&Samples::file(&self.path)?, Reading::default())?;
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
            // Its clock begins at zero again.
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

    /// Refuses a run that would fill the memory: a short file may expand to a long one.
    fn check_size(&self) -> Result<()> {
        let bytes = size_of_val(&*self.packets) + size_of_val(&*self.frames);
        ensure!(
            bytes <= self.max_bytes,
            "it takes more than {} MiB of memory: cut it into parts, or use `replay` or `export`",
            self.max_bytes >> 20
        );
        Ok(())
    }

    /// The first and the last time.
    fn ends_s(&self) -> Option<(f64, f64)> {
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
        Summary {
            name: self.name.clone(),
            from_s,
            until_s,
            frames: self.frames.len(),
            touches: contacts().count(),
            contact_s: contacts().next().and_then(|packet| time_s(&packet.event)),
            estimate: estimates()
                .find(|found| found.span == Span::Slide)
                .or_else(|| estimates().next()),
            why_none: self.why_none(),
            remark: self.remark.clone(),
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

    /// The settings of its board.
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

    /// The board's state at a time; with a `mark` at the mark's end, with the estimate of the
    /// marked part.
    pub fn at(&self, t_s: f64, mark: Option<Part>) -> Result<Live> {
        let t_s = mark.map_or(t_s, |mark| mark.until_s);
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
        if let Some(mark) = mark {
            live.take(&Packet {
                sequence: 1,
                event: Event::Estimate(self.estimate(mark)?),
            });
        }
        live.now.now_s = Some(t_s);
        Ok(live)
    }

    /// The board's own estimate of a part.
    pub fn estimate(&self, Part { from_s, until_s }: Part) -> Result<Estimate> {
        let begin = self.frames.partition_point(|raw| raw_s(raw) < from_s);
        let end = self
            .frames
            .partition_point(|raw| raw_s(raw) <= until_s)
            .max(begin);
        let frames = &self.frames[begin..end];
        let enough = frames.len() >= FRAMES_MIN as usize;
        ensure!(
            enough,
            "the marked part has {} raw frames, and a fit needs {FRAMES_MIN}: mark more",
            frames.len()
        );
        let (first, last) = (frames[0], frames[frames.len() - 1]);
        let slots = last.number.wrapping_sub(first.number) as usize + 1;
        ensure!(
            slots <= FRAMES_MAX,
            "the marked part has {slots} frames, and a fit takes {FRAMES_MAX}: mark less"
        );
        let usable = |raw: &Raw, taxel: usize| raw.present & raw.good & 1 << taxel != 0;
        let reference: Values = std::array::from_fn(|taxel| {
            frames
                .iter()
                .find(|raw| usable(raw, taxel))
                .map_or(0.0, |raw| raw.codes[taxel] as f32)
        });
        let (mut values, mut valid) = (vec![[0.0; TAXELS]; slots], vec![0; slots]);
        for raw in frames {
            let at = raw.number.wrapping_sub(first.number) as usize;
            let (Some(values), Some(valid)) = (values.get_mut(at), valid.get_mut(at)) else {
                continue;
            };
            *valid = raw.present & raw.good;
            for taxel in 0..TAXELS {
                values[taxel] = if usable(raw, taxel) {
                    raw.codes[taxel] as f32 - reference[taxel]
                } else {
                    0.0
                };
            }
        }
        let window = Window {
            end_us: last.t_us,
            frame_rate_hz: ((slots - 1) as f64 / (raw_s(&last) - raw_s(&first))) as f32,
            reference,
            ..Window::new(self.settings().plan, slots as u32)
        };
        // The part is as long as it was marked.
        let settings = Settings {
            accuracy: 0.0,
            ..self.settings()
        };
        let mut source = Table {
            values: &values,
            valid: &valid,
        };
        let mut estimator = Box::new(Estimator::new(settings));
        match estimator.run(&window, &mut source) {
            Ok(WindowFit::Done(estimate)) => Ok(estimate),
            _ => Err(anyhow!("the fit did not reach all frames")),
        }
    }
}

fn raw_s(raw: &Raw) -> f64 {
    raw.t_us as f64 * 1e-6
}
